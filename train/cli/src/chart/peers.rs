//! Points of other programs, from a CSV file.
//!
//! A header line, then one line per point. `program`, `scene`, `width`, `height`, `psnr` and
//! `source` must be there; every other column may be missing or its fields empty:
//! `setting`, `split`, `views`, `background`, `psnr_min`, `ssim`, `ms_ssim`, `lpips`, `depth_error`,
//! `ms_per_frame`, `train_seconds`, `train_memory_bytes`, `bytes`, `samples_per_ray`,
//! `render_memory_bytes`, `machine`. Units are those of `points.csv`; `source` says where a
//! point comes from: an address, a paper, a command.

use std::path::{Path, PathBuf};

use pocketnerf_train::json::{escape, one_line};
use serde::Deserialize;

use super::Point;
use super::point::OURS;

/// Larger files are refused unread.
const MAX_BYTES: u64 = 16 << 20;
/// Longer texts are refused.
const MAX_TEXT: usize = 400;

/// Why a file of peers was refused. Each message is one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PeersError {
    /// It cannot be read.
    #[error("{}: cannot be read: {source}; check the path and its permissions", one_line(.file))]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// It is too large.
    #[error("{}: {bytes} bytes, at most {MAX_BYTES} are read; is this really a table of points?", one_line(.file))]
    TooLarge {
        /// The file.
        file: PathBuf,
        /// Its size.
        bytes: u64,
    },
    /// A column or a field is wrong.
    #[error("{}:{line}: {problem}", one_line(.file))]
    Contents {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: u64,
        /// What was found and what was expected.
        problem: String,
    },
}

/// A line of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    program: String,
    scene: String,
    width: u32,
    height: u32,
    psnr: f64,
    source: String,
    #[serde(default)]
    setting: String,
    #[serde(default)]
    split: String,
    views: Option<usize>,
    #[serde(default)]
    background: String,
    psnr_min: Option<f64>,
    ssim: Option<f64>,
    ms_ssim: Option<f64>,
    lpips: Option<f64>,
    depth_error: Option<f64>,
    ms_per_frame: Option<f64>,
    train_seconds: Option<f64>,
    train_memory_bytes: Option<u64>,
    bytes: Option<u64>,
    samples_per_ray: Option<f64>,
    render_memory_bytes: Option<u64>,
    machine: Option<String>,
}

impl Line {
    fn check(&self) -> Result<(), String> {
        let texts = [
            ("program", Some(&self.program)),
            ("scene", Some(&self.scene)),
            ("source", Some(&self.source)),
            ("setting", Some(&self.setting)),
            ("split", Some(&self.split)),
            ("background", Some(&self.background)),
            ("machine", self.machine.as_ref()),
        ];
        for (column, text) in texts.into_iter().filter_map(|(c, text)| Some((c, text?))) {
            if text.chars().count() > MAX_TEXT || text.contains(char::is_control) {
                return Err(format!(
                    "{column} has more than {MAX_TEXT} characters or a line break, expected a short text"
                ));
            }
        }
        let needed = [("program", &self.program), ("scene", &self.scene), ("source", &self.source)];
        if let Some((column, _)) = needed.into_iter().find(|(_, text)| text.trim().is_empty()) {
            return Err(format!("{column} is empty, expected a text"));
        }
        if self.program == OURS {
            return Err(format!("program is {OURS:?}, expected another one's name"));
        }
        if self.width == 0 || self.height == 0 {
            return Err(format!("{}x{} pixels, expected at least 1x1", self.width, self.height));
        }
        let figures = [
            ("psnr", Some(self.psnr)),
            ("psnr_min", self.psnr_min),
            ("ms_per_frame", self.ms_per_frame),
            ("train_seconds", self.train_seconds),
            ("samples_per_ray", self.samples_per_ray),
            ("lpips", self.lpips),
            ("depth_error", self.depth_error),
        ];
        let bad = |value: f64| !(value.is_finite() && value >= 0.0);
        if let Some((column, value)) =
            figures.into_iter().filter_map(|(c, v)| Some((c, v?))).find(|(_, v)| bad(*v))
        {
            return Err(format!("{column} is {value}, expected a finite number from 0"));
        }
        let similarities = [("ssim", self.ssim), ("ms_ssim", self.ms_ssim)];
        let bad = |value: f64| !(-1.0..=1.0).contains(&value);
        match similarities.into_iter().filter_map(|(c, v)| Some((c, v?))).find(|(_, v)| bad(*v)) {
            Some((column, value)) => {
                Err(format!("{column} is {value}, expected a number from -1 to 1"))
            }
            None => Ok(()),
        }
    }

    fn point(self, number: usize) -> Point {
        let rays = f64::from(self.width) * f64::from(self.height);
        let per_second = |per_frame: f64| self.ms_per_frame.map(|ms| 1000.0 * per_frame / ms);
        Point {
            id: format!("peer-{number}"),
            frames_per_second: per_second(1.0).filter(|v| v.is_finite()),
            rays_per_second: per_second(rays).filter(|v| v.is_finite()),
            method: self.program.clone(),
            program: self.program,
            scene: self.scene,
            model: self.setting,
            split: self.split,
            views: self.views,
            width: self.width,
            height: self.height,
            background: self.background,
            train_seconds: self.train_seconds,
            train_memory_bytes: self.train_memory_bytes,
            bytes: self.bytes,
            psnr: Some(self.psnr),
            psnr_min: self.psnr_min,
            ssim: self.ssim,
            ms_ssim: self.ms_ssim,
            lpips: self.lpips,
            depth_error: self.depth_error,
            ms_per_frame: self.ms_per_frame,
            samples_per_ray: self.samples_per_ray,
            render_memory_bytes: self.render_memory_bytes,
            source: Some(self.source),
            machine: self.machine,
            ..Point::default()
        }
    }
}

/// Reads a file of peers.
///
/// # Errors
/// One line that names file and line.
pub fn read(file: &Path) -> Result<Vec<Point>, PeersError> {
    let unreadable = |source| PeersError::Unreadable { file: file.to_owned(), source };
    let bytes = std::fs::metadata(file).map_err(unreadable)?.len();
    if bytes > MAX_BYTES {
        return Err(PeersError::TooLarge { file: file.to_owned(), bytes });
    }
    parse(&std::fs::read(file).map_err(unreadable)?, file)
}

fn parse(bytes: &[u8], file: &Path) -> Result<Vec<Point>, PeersError> {
    let refused = |line, problem: String| PeersError::Contents {
        file: file.to_owned(),
        line,
        problem: escape(&problem),
    };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
    let header = reader.headers().map_err(|e| refused(1, reason(&e)))?.clone();
    let mut points = Vec::new();
    for record in reader.records() {
        let place = |e: &csv::Error| e.position().map_or(1, csv::Position::line);
        let record = record.map_err(|e| refused(place(&e), reason(&e)))?;
        let at = record.position().map_or(1, csv::Position::line);
        let line: Line =
            record.deserialize(Some(&header)).map_err(|e| refused(at, column(&e, &header)))?;
        line.check().map_err(|problem| refused(at, problem))?;
        points.push(line.point(points.len()));
    }
    if points.is_empty() {
        return Err(refused(1, "no line beside the header, expected a point a line".to_owned()));
    }
    Ok(points)
}

/// The reader's message without its position, which is reported once.
fn reason(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("{len} fields, expected {expected_len} as in the first line")
        }
        csv::ErrorKind::Utf8 { .. } => "not a text in UTF-8".to_owned(),
        other => format!("{other:?}"),
    }
}

/// The same for a field, with the name of its column.
fn column(error: &csv::Error, header: &csv::StringRecord) -> String {
    let csv::ErrorKind::Deserialize { err, .. } = error.kind() else { return reason(error) };
    let problem = err.kind().to_string();
    match err.field().and_then(|field| header.get(field as usize)) {
        Some(name) => format!("column {name}: {problem}"),
        None => format!("{problem} in the first line"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "program,scene,width,height,psnr,source,ms_per_frame,ssim";

    fn refused(text: &str) -> String {
        parse(text.as_bytes(), Path::new("p.csv")).unwrap_err().to_string()
    }

    #[test]
    fn a_table_becomes_points() {
        let text = format!("{HEADER}\nother, lego ,800,800,33.5,\"a paper, table 2\",20,\n");
        let [point] = &parse(text.as_bytes(), Path::new("p.csv")).unwrap()[..] else {
            panic!("one point")
        };
        assert_eq!((&*point.program, &*point.scene, point.width), ("other", "lego", 800));
        assert_eq!((point.psnr, point.ssim), (Some(33.5), None));
        assert_eq!((point.frames_per_second, point.rays_per_second), (Some(50.0), Some(32e6)));
        assert_eq!(point.source.as_deref(), Some("a paper, table 2"));
    }

    #[test]
    fn what_is_wrong_is_said_in_one_line() {
        let row = |fields: &str| refused(&format!("{HEADER}\n{fields}\n"));
        let cases = [
            (refused("program,scene,fps\na,b,1\n"), "p.csv:2: unknown field `fps`"),
            (refused("program,scene\na,b\n"), "p.csv:2: missing field `width`"),
            (refused(HEADER), "p.csv:1: no line beside the header"),
            (row("a,b,800,800,x,s,1,1"), "p.csv:2: column psnr: invalid float literal"),
            (row("a,b,800,800,NaN,s,1,1"), "p.csv:2: psnr is NaN, expected a finite number"),
            (row("a,b,800,0,30,s,1,1"), "p.csv:2: 800x0 pixels"),
            (row("a,b,800,800,30,,1,1"), "p.csv:2: source is empty"),
            (row("a,b,800,800,30,s,1,1.5"), "p.csv:2: ssim is 1.5"),
            (row("a,b,800"), "p.csv:2: 3 fields, expected 8 as in the first line"),
            (row("pocketnerf,b,8,8,30,s,1,1"), "p.csv:2: program is \"pocketnerf\""),
            (row("a,\"b\nc\",8,8,30,s,1,1"), "p.csv:2: scene has more than"),
        ];
        for (found, expected) in cases {
            assert!(found.starts_with(expected), "{found}\n{expected}");
            assert_eq!(found.lines().count(), 1, "{found}");
        }
        let bytes = [HEADER.as_bytes(), b"\n\xff,b,8,8,30,s,1,1\n"].concat();
        let found = parse(&bytes, Path::new("p.csv")).unwrap_err().to_string();
        assert_eq!(found, "p.csv:2: not a text in UTF-8");
        assert!(
            read(Path::new("/nowhere.csv")).unwrap_err().to_string().contains("cannot be read")
        );
    }

    #[test]
    fn whatever_the_bytes_no_panic() {
        arbtest::arbtest(|u| {
            let mut bytes = format!("{HEADER}\na,b,8,8,30,s,1,1\n").into_bytes();
            for _ in 0..u.int_in_range(1..=6)? {
                let at = u.choose_index(bytes.len())?;
                bytes[at] = u.arbitrary()?;
            }
            if let Err(error) = parse(&bytes, Path::new("p.csv")) {
                assert_eq!(error.to_string().lines().count(), 1, "{error}");
            }
            Ok(())
        });
    }
}
