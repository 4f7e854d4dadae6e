//! The chart as a picture: `chart.svg` and `chart.png`, drawn by the same code.
//!
//! One row per scene and picture size, one column per kind of cost.

use std::sync::Once;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

use super::scale::{linear, logarithmic, short, ticks};
use super::{Axis, Group, Point, frontier, groups};

/// Width and height of a panel, pixels.
const PANEL: [u32; 2] = [460, 330];
/// Height of the line that explains the marks.
const LEGEND: u32 = 34;
/// Colours of series, distinguishable by colour-blind readers too (Okabe and Ito 2008).
const COLORS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];
/// The colour of dominated points.
const BEATEN: RGBColor = RGBColor(190, 190, 190);
const FONT: &str = "sans-serif";

/// Why nothing can be drawn.
#[derive(Debug, thiserror::Error)]
#[error("the chart cannot be drawn: {0}")]
pub struct DrawError(String);

type Drawn = Result<(), DrawError>;

fn failed(error: impl std::fmt::Display) -> DrawError {
    DrawError(error.to_string().replace('\n', " "))
}

/// Width and height of the chart of these points, pixels.
#[must_use]
pub fn size(points: &[Point], costs: &[Axis]) -> (u32, u32) {
    let [width, height] = PANEL;
    let rows = groups(points).len().max(1) as u32;
    (width * costs.len().max(1) as u32, LEGEND + height * rows)
}

/// The chart as SVG.
///
/// # Errors
/// [`DrawError`].
pub fn svg(points: &[Point], accuracy: Axis, costs: &[Axis]) -> Result<String, DrawError> {
    let mut text = String::new();
    draw(SVGBackend::with_string(&mut text, size(points, costs)), points, accuracy, costs)?;
    Ok(text)
}

/// The chart as 8-bit RGB of [`size`].
///
/// # Errors
/// [`DrawError`].
pub fn rgb(points: &[Point], accuracy: Axis, costs: &[Axis]) -> Result<Vec<u8>, DrawError> {
    let (width, height) = size(points, costs);
    let mut pixels = vec![0; width as usize * height as usize * 3];
    let backend = BitMapBackend::with_buffer(&mut pixels, (width, height));
    draw(backend, points, accuracy, costs)?;
    Ok(pixels)
}

fn draw<B: DrawingBackend>(backend: B, points: &[Point], accuracy: Axis, costs: &[Axis]) -> Drawn {
    load_font();
    let area = backend.into_drawing_area();
    area.fill(&WHITE).map_err(failed)?;
    let (top, panels) = area.split_vertically(LEGEND);
    let series = series(points);
    legend(&top, &series)?;
    let groups = groups(points);
    let panels = panels.split_evenly((groups.len().max(1), costs.len().max(1)));
    let places = groups.iter().flat_map(|group| costs.iter().map(move |cost| (*group, *cost)));
    for (panel, (group, cost)) in panels.iter().zip(places) {
        let of_group: Vec<Point> =
            points.iter().filter(|point| point.group() == group).cloned().collect();
        panel_of(panel, &of_group, group, &series, [cost, accuracy])?;
    }
    area.present().map_err(failed)
}

/// The program has its own font, so no picture depends on the machine's.
fn load_font() {
    static LOADED: Once = Once::new();
    LOADED.call_once(|| {
        // Fails only for a file that is no font.
        drop(register_font(FONT, FontStyle::Normal, dejavu::sans::regular()));
    });
}

/// Every series, and whether it is another program's.
fn series(points: &[Point]) -> Vec<(&str, bool)> {
    let mut found: Vec<(&str, bool)> = Vec::new();
    for point in points {
        let entry = (point.series(), !point.is_ours());
        if !found.contains(&entry) {
            found.push(entry);
        }
    }
    found
}

fn color(series: usize) -> RGBColor {
    COLORS[series % COLORS.len()]
}

fn legend<B: DrawingBackend>(area: &DrawingArea<B, Shift>, series: &[(&str, bool)]) -> Drawn {
    let mut x = 16;
    let text = |text: &str, x: i32| Text::new(text.to_owned(), (x, 9), (FONT, 15).into_font());
    for (i, (name, is_peer)) in series.iter().enumerate() {
        mark(area, (x, 16), color(i), *is_peer)?;
        area.draw(&text(name, x + 10)).map_err(failed)?;
        x += 34 + 9 * name.chars().count() as i32;
    }
    mark(area, (x, 16), BEATEN, false)?;
    let beaten = "another is as fast and better";
    area.draw(&text(beaten, x + 10)).map_err(failed)?;
    x += 34 + 8 * beaten.len() as i32;
    hollow(area, (x, 16), BEATEN)?;
    area.draw(&text("unsteady time", x + 10)).map_err(failed)
}

/// A point whose time is not to be trusted is a ring.
fn hollow<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    at: (i32, i32),
    color: RGBColor,
) -> Drawn {
    area.draw(&Circle::new(at, 4, WHITE.filled())).map_err(failed)?;
    area.draw(&Circle::new(at, 4, color.stroke_width(2))).map_err(failed)
}

/// A point of ours is a disc, one of another program a triangle.
fn mark<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    at: (i32, i32),
    color: RGBColor,
    is_peer: bool,
) -> Drawn {
    if is_peer {
        area.draw(&TriangleMarker::new(at, 6, color.filled())).map_err(failed)
    } else {
        area.draw(&Circle::new(at, 4, color.filled())).map_err(failed)
    }
}

/// One group, one cost.
fn panel_of<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    points: &[Point],
    group: Group<'_>,
    series: &[(&str, bool)],
    [cost, accuracy]: [Axis; 2],
) -> Drawn {
    let place = |point: &Point| Some((cost.value(point)?, accuracy.value(point)?));
    let places: Vec<Option<(f64, f64)>> =
        points.iter().map(|point| place(point).filter(|(x, _)| *x > 0.0)).collect();
    let known = || places.iter().flatten();
    let title = (format!("{group}"), (FONT, 15).into_font());
    if known().next().is_none() {
        let text = format!("{group}: {} or {} not known", cost.label(), accuracy.label());
        let text = Text::new(text, (20, 20), (FONT, 15).into_font());
        return area.draw(&text).map_err(failed);
    }
    let [xs, ys] = [known().map(|p| p.0).collect(), known().map(|p| p.1).collect()];
    // The drawing library's logarithmic scale names powers of ten alone.
    let ([left, right], [low, high]) = (logarithmic(xs), linear(ys));
    let scale = |x: f64| x.log10();
    let mut chart = ChartBuilder::on(area)
        .caption(title.0, title.1)
        .margin(8)
        .x_label_area_size(40)
        .y_label_area_size(56)
        .build_cartesian_2d(scale(left)..scale(right), low..high)
        .map_err(failed)?;
    chart
        .configure_mesh()
        .x_desc(cost.label())
        .y_desc(accuracy.label())
        .disable_x_mesh()
        .x_labels(0)
        .y_labels(7)
        .y_label_formatter(&|y| short(*y))
        .light_line_style(WHITE)
        .bold_line_style(BLACK.mix(0.12))
        .label_style((FONT, 13))
        .axis_desc_style((FONT, 14))
        .draw()
        .map_err(failed)?;
    let (base_x, base_y) = area.get_base_pixel();
    for tick in ticks(left, right) {
        let line = [(scale(tick), low), (scale(tick), high)];
        let line = PathElement::new(line, BLACK.mix(0.12));
        chart.plotting_area().draw(&line).map_err(failed)?;
        let at = chart.backend_coord(&(scale(tick), low));
        let anchor = Pos::new(HPos::Center, VPos::Top);
        let style = (FONT, 13).into_font().into_text_style(area).pos(anchor);
        let text = Text::new(short(tick), (at.0 - base_x, at.1 - base_y + 6), style);
        area.draw(&text).map_err(failed)?;
    }
    let on = frontier(points, cost, accuracy);
    let mut best: Vec<(f64, f64)> = places
        .iter()
        .zip(points.iter().zip(&on))
        .filter_map(|(place, (point, on))| place.filter(|_| *on && point.is_ours()))
        .map(|(x, y)| (scale(x), y))
        .collect();
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(best, BLACK.mix(0.5).stroke_width(1))).map_err(failed)?;
    // Points on the frontier lie above the others.
    for wanted in [false, true] {
        for ((point, place), on) in points.iter().zip(&places).zip(&on) {
            let (Some(place), true) = (place, *on == wanted) else { continue };
            let at = chart.backend_coord(&(scale(place.0), place.1));
            let own = (point.series(), !point.is_ours());
            let i = series.iter().position(|series| *series == own).unwrap_or(0);
            let at = (at.0 - base_x, at.1 - base_y);
            if cost.is_time() && point.unsteady == Some(true) {
                hollow(area, at, color(i))?;
                continue;
            }
            mark(area, at, color(i), own.1)?;
            if !*on && !own.1 {
                area.draw(&Circle::new(at, 3, BEATEN.filled())).map_err(failed)?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::OURS;

    fn points() -> Vec<Point> {
        let point = |method: &str, ms, psnr, program: &str| Point {
            program: program.to_owned(),
            method: method.to_owned(),
            scene: "a <scene> & more".to_owned(),
            width: 400,
            height: 300,
            ms_per_frame: Some(ms),
            psnr: Some(psnr),
            ..Point::default()
        };
        vec![
            point("hash-grid", 20.0, 33.0, OURS),
            point("hash-grid", 40.0, 34.0, OURS),
            point("hash-grid", 50.0, 33.5, OURS),
            point("nerf", 400.0, 34.5, OURS),
            point("other", 5.0, 32.0, "other"),
        ]
    }

    #[test]
    fn every_point_is_drawn_in_both_formats() {
        let mut points = points();
        let costs = [Axis::MsPerFrame, Axis::Bytes];
        // Four of ours, one of them dominated, and in the legend one for each of two series and
        // for dominated points, and a ring of two circles for unsteady times.
        let marks = |points: &[Point]| {
            let svg = svg(points, Axis::Psnr, &costs).unwrap();
            (svg.matches("<circle").count(), svg.matches("stroke-width=\"2\"").count())
        };
        let (circles, wide) = marks(&points);
        assert_eq!(circles, 4 + 1 + 3 + 2);
        points[1].unsteady = Some(true);
        let (circles, wider) = marks(&points);
        // One more, that of the ring.
        assert_eq!((circles, wider), (4 + 1 + 3 + 2 + 1, wide + 1));
        let svg = svg(&points, Axis::Psnr, &costs).unwrap();
        assert_eq!(svg.matches("<polygon").count(), 1 + 1, "{svg}");
        for text in [
            "hash-grid",
            "nerf",
            "other",
            "unsteady time",
            "a &lt;scene&gt; &amp; more 400x300",
            "ms a frame",
        ] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(svg.contains("bytes of the model or PSNR, dB not known"));
        let rgb = rgb(&points, Axis::Psnr, &costs).unwrap();
        assert_eq!(size(&points, &costs), (920, 364));
        let colors = [COLORS[0], COLORS[1], COLORS[2], BEATEN].map(|c| [c.0, c.1, c.2]);
        for color in colors {
            let found = rgb.as_chunks::<3>().0.iter().filter(|p| **p == color).count();
            assert!(found > 20, "{color:?}: {found}");
        }
    }

    #[test]
    fn one_point_and_none_can_be_drawn() {
        let axes = [Axis::MsPerFrame];
        assert!(svg(&points()[..1], Axis::Psnr, &axes).unwrap().contains("<circle"));
        assert!(svg(&[], Axis::Psnr, &axes).unwrap().starts_with("<svg"));
    }
}
