//! The table as one self-contained page: `index.html`.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::drawing::{color, svg};
use super::{Bar, Mode, Row};

const PAGE: &str = include_str!("page.html");

/// Pictures as data URLs, by the [`key`] of their rows.
pub type Pictures = BTreeMap<String, String>;

/// What tells a row from the others.
#[must_use]
pub fn key(row: &Row) -> String {
    format!("{}.{}.{}.{}.{}", row.scene, row.method, row.mode, row.strength, row.seed)
}

/// The page: for each scene and method a picture, and a table with the worst view of every row.
#[must_use]
pub fn html(modes: &[Mode], rows: &[Row], pictures: &Pictures, about: &str) -> String {
    let mut groups: Vec<[&str; 2]> = Vec::new();
    for row in rows {
        let group = [&row.scene[..], &row.method[..]];
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    let mut tables = String::new();
    for [scene, method] in groups {
        let own: Vec<&Row> =
            rows.iter().filter(|row| row.scene == scene && row.method == method).collect();
        let _ = write!(tables, "<h2>{}: {}</h2>", escaped(scene), escaped(method));
        tables.push_str(&svg(modes, &own));
        table(&mut tables, modes, &own, pictures);
    }
    PAGE.replacen("<!--ABOUT-->", &escaped(about), 1).replacen("<!--TABLES-->", &tables, 1)
}

fn table(to: &mut String, modes: &[Mode], rows: &[&Row], pictures: &Pictures) {
    to.push_str(
        "<table><thead><tr><th>what is spoilt</th><th>strength</th><th>seed</th><th>figure</th>\
         <th>bar</th><th>verdict</th><th>what the program says; the worst view</th></tr></thead><tbody>",
    );
    for mode in modes {
        let own: Vec<&&Row> = rows.iter().filter(|row| row.mode == mode.name).collect();
        for (i, row) in own.iter().enumerate() {
            to.push_str("<tr>");
            if i == 0 {
                let _ = write!(
                    to,
                    "<td rowspan=\"{}\"><b>{}</b><br>{}<br><small>{}{}</small></td>",
                    own.len(),
                    escaped(mode.name),
                    escaped(mode.what),
                    escaped(mode.cause),
                    published(mode),
                );
            }
            let figure =
                row.value.map_or_else(|| "refused".to_owned(), |value| format!("{value:.2}"));
            let sign = if matches!(mode.bar, Bar::Loss(_)) { "≤" } else { "≥" };
            let _ = write!(
                to,
                "<td class=\"number\">{} {}</td><td class=\"number\">{}</td>\
                 <td class=\"number\">{figure}</td><td class=\"number\">{sign} {} {}</td>\
                 <td style=\"background: {}\">{}</td><td>{}",
                number(row.strength),
                escaped(mode.unit),
                row.seed,
                number(row.bar),
                escaped(&row.figure),
                color(row.verdict),
                row.verdict.text(),
                row.warning.as_deref().map_or_else(String::new, escaped),
            );
            if let Some(picture) = pictures.get(&key(row)) {
                let psnr = row.psnr_min.unwrap_or(f64::NAN);
                let _ = write!(
                    to,
                    "<details><summary>worst view, {psnr:.2} dB: model, truth, difference</summary>\
                     <img alt=\"\" src=\"{picture}\"></details>"
                );
            }
            to.push_str("</td></tr>");
        }
    }
    to.push_str("</tbody></table>");
}

fn published(mode: &Mode) -> String {
    if mode.published.is_empty() {
        String::new()
    } else {
        format!("<br>Published: {}", escaped(mode.published))
    }
}

/// Text that is no markup.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A number as people write it.
pub(super) fn number(value: f64) -> String {
    value.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stress::{Verdict, all};

    #[test]
    fn a_row_is_shown_with_what_was_said_and_its_picture() {
        let row = Row {
            mode: "views".to_owned(),
            method: "hash-grid".to_owned(),
            scene: "<lego>".to_owned(),
            strength: 12.0,
            seed: 0,
            figure: "loss, dB".to_owned(),
            value: Some(4.256),
            bar: 2.0,
            verdict: Verdict::SaysSo,
            warning: Some("few & far".to_owned()),
            psnr: Some(25.0),
            psnr_min: Some(20.0),
            reference_psnr: Some(29.256),
        };
        let pictures = Pictures::from([(key(&row), "data:image/jpeg;base64,AAAA".to_owned())]);
        let refused = Row { strength: 3.0, value: None, ..row.clone() };
        let page = html(&all(), &[row, refused], &pictures, "by test");
        for text in [
            "&lt;lego&gt;: hash-grid",
            "12: 4.26",
            "few &amp; far",
            "3: refused",
            "by test",
            "base64,AAAA",
        ] {
            assert!(page.contains(text), "{text}");
        }
        assert!(!page.contains("<lego>"));
    }
}
