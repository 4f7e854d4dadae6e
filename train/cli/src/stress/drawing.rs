//! The table as a picture: `stress.svg`, a line a mode, a square a strength.

use std::fmt::Write;

use super::page::{escaped, number};
use super::{Mode, Row, Verdict};

const LINE: usize = 22;
const NAMES: usize = 170;
const SQUARE: usize = 74;

/// The colour of a verdict, distinguishable by colour-blind readers too (Okabe and Ito 2008).
#[must_use]
pub const fn color(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Within => "#8fd0b8",
        Verdict::SaysSo => "#f3d27a",
        Verdict::Fails => "#e89a74",
    }
}

/// The worst of the rows at each strength: the verdict first, then the value.
#[must_use]
pub fn worst<'r>(mode: &Mode, strength: f64, rows: &[&'r Row]) -> Option<&'r Row> {
    let of = rows.iter().filter(|row| row.mode == mode.name && row.strength == strength);
    let rank = |row: &Row| match row.verdict {
        Verdict::Within => 0,
        Verdict::SaysSo => 1,
        Verdict::Fails => 2,
    };
    of.copied().max_by(|a, b| {
        let excess = |row: &Row| {
            row.value.map_or(f64::INFINITY, |v| if row.figure.starts_with("loss") { v } else { -v })
        };
        rank(a).cmp(&rank(b)).then(excess(a).total_cmp(&excess(b)))
    })
}

/// The rows of one method and scene.
#[must_use]
pub fn svg(modes: &[Mode], rows: &[&Row]) -> String {
    let shown: Vec<&Mode> =
        modes.iter().filter(|mode| rows.iter().any(|row| row.mode == mode.name)).collect();
    let columns = shown.iter().map(|mode| mode.strengths.len()).max().unwrap_or(0);
    let (width, height) = (NAMES + SQUARE * columns, LINE * (shown.len() + 1));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"11\"><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>"
    );
    let mut key = NAMES;
    for verdict in [Verdict::Within, Verdict::SaysSo, Verdict::Fails] {
        square(&mut svg, key, 0, color(verdict), verdict.text());
        key += SQUARE;
    }
    for (line, mode) in shown.iter().enumerate() {
        let top = LINE * (line + 1);
        let _ = write!(svg, "<text x=\"4\" y=\"{}\">{}</text>", top + 15, escaped(mode.name));
        for (i, strength) in mode.strengths.iter().enumerate() {
            let Some(row) = worst(mode, *strength, rows) else { continue };
            let value =
                row.value.map_or_else(|| "refused".to_owned(), |value| format!("{value:.2}"));
            let text = format!("{}: {value}", number(*strength));
            square(&mut svg, NAMES + SQUARE * i, top, color(row.verdict), &text);
        }
    }
    svg.push_str("</svg>\n");
    svg
}

fn square(svg: &mut String, left: usize, top: usize, color: &str, text: &str) {
    let _ = write!(
        svg,
        "<rect x=\"{left}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{color}\"/>\
         <text x=\"{}\" y=\"{}\">{}</text>",
        top + 1,
        SQUARE - 2,
        LINE - 2,
        left + 4,
        top + 15,
        escaped(text),
    );
}
