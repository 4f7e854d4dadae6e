//! Writes the files of a chart, and reads them back.

use std::path::Path;

use pocketnerf_train::metrics::Metrics;
use pocketnerf_train::output::write_atomic;
use pocketnerf_train::picture::image_file;
use pocketnerf_train::picture::image_file::encode_rgb;
use serde::Deserialize;

use super::Chart;
use super::measure::Measured;
use crate::chart::{
    self, Axis, MachineFacts, Point, Program, Protocol, bjontegaard, drawing, page, table,
};
use crate::commands::train::quoted;
use crate::commands::{Common, Failure, print_line};
use crate::machine::Machine;

/// Costs by which methods are compared.
const COMPARED: [Axis; 3] = [Axis::MsPerFrame, Axis::Bytes, Axis::TrainSeconds];
const POINTS: &str = "points.json";

impl Chart {
    /// Writes all files, once all of them are made.
    pub(super) fn write(
        &self,
        measured: Measured,
        asked: String,
        metrics: &Metrics,
    ) -> Result<chart::Chart, Failure> {
        let Measured { points, pictures, rounds, slowdown } = measured;
        let machine = MachineFacts::of(&Machine::measure(self.vectors.level(), true)?);
        let comparisons = COMPARED.iter().flat_map(|cost| bjontegaard::compare(&points, *cost));
        let chart = chart::Chart {
            program: Program::this(),
            machine,
            protocol: Protocol {
                rounds,
                slowdown,
                unsteady_above: Point::UNSTEADY,
                lpips: metrics.lpips.as_ref().map(|lpips| lpips.network().to_owned()),
                command: command(),
                asked,
                measured_at: now(),
            },
            comparisons: comparisons.collect(),
            points,
        };
        let svg = drawing::svg(&chart.points, self.y, &self.x)?;
        let (width, height) = drawing::size(&chart.points, &self.x);
        let rgb = drawing::rgb(&chart.points, self.y, &self.x)?;
        let png = encode_rgb(width, height, &rgb)?;
        let mut shown = page::Pictures::new();
        for (id, path) in &pictures {
            let picture = image_file::open(path).map_err(|e| format!("{}: {e}", path.display()))?;
            let picture = picture.into_rgb8();
            let address = page::picture(picture.width(), picture.height(), picture.as_raw())?;
            shown.insert(id.clone(), address);
        }
        let html = page::html(&chart, &shown)?;
        let csv = table::csv(&chart.points)?;
        let json = serde_json::to_vec_pretty(&chart)?;
        let files: [(&str, &[u8]); 5] = [
            ("chart.svg", svg.as_bytes()),
            ("chart.png", &png),
            ("index.html", html.as_bytes()),
            ("points.csv", &csv),
            (POINTS, &json),
        ];
        for (name, bytes) in files {
            write_atomic(&self.out.join(name), bytes)?;
        }
        Ok(chart)
    }

    /// A summary for people.
    pub(super) fn report(&self, chart: &chart::Chart, common: &Common) {
        if common.json {
            return;
        }
        for point in chart.points.iter().filter(|point| point.is_ours()) {
            let figure = |value: Option<f64>, digits: usize| {
                value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"))
            };
            print_line(format_args!(
                "{} {}: {} dB, {} ms per frame{}, {} bytes",
                if point.frontier { '*' } else { ' ' },
                point.id,
                figure(point.psnr, 2),
                figure(point.ms_per_frame, 1),
                if point.unsteady == Some(true) { " (unsteady)" } else { "" },
                point.bytes.unwrap_or(0),
            ));
        }
        chart.comparisons.iter().for_each(print_line);
        print_line(format_args!(
            "{}: {} points, * on the frontier of PSNR and speed",
            self.out.join("index.html").display(),
            chart.points.len()
        ));
    }
}

/// The part of a chart that is read back.
#[derive(Debug, Deserialize)]
struct Written {
    protocol: Protocol,
    points: Vec<Point>,
}

/// The points of the chart in the folder, if it is that of the same command.
pub(super) fn measured(out: &Path, asked: &str) -> Option<Vec<Point>> {
    let bytes = std::fs::read(out.join(POINTS)).ok()?;
    let written: Written = serde_json::from_slice(&bytes).ok()?;
    (written.protocol.asked == asked).then_some(written.points)
}

/// The command line of this process.
fn command() -> String {
    let words = std::env::args_os().skip(1).map(|word| quoted(Path::new(&word)));
    std::iter::once("pocketnerf".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// Seconds since 1970.
fn now() -> u64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    since.map_or(0, |since| since.as_secs())
}
