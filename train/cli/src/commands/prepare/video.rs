//! Frames of a video: evenly spread, and the sharpest of its neighbours each.

use std::fs;
use std::path::{Path, PathBuf};

use pocketnerf_train::picture::image_file;
use serde_json::Value;

use crate::commands::progress::Progress;
use crate::commands::tool::{FFMPEG, FFPROBE, Runner};
use crate::commands::{Common, Failure};

/// Of so many frames that follow each other, the sharpest is taken.
const OF: usize = 3;

/// Takes `n` frames of a video into a folder, as `00001.jpg` and so on; all, if it has fewer.
pub(super) fn frames(
    video: &Path,
    n: usize,
    to: &Path,
    runner: &Runner<'_>,
    common: &Common,
) -> Result<(), Failure> {
    let seconds = seconds(video)?;
    let rate = (n * OF) as f64 / seconds;
    let mut progress = Progress::new("taking frames", n * OF, common);
    let video = video.display().to_string();
    let pattern = to.join("candidate-%06d.jpg").display().to_string();
    // A rate above the video's own would give frames several times: `mpdecimate` is not needed,
    // as the sharpest of equal frames is one of them.
    let arguments: Vec<String> = ["-nostdin", "-v", "error", "-progress", "pipe:1", "-i", &video]
        .into_iter()
        .chain(["-vf", &format!("fps={rate:.6}"), "-q:v", "2", &pattern])
        .map(str::to_owned)
        .collect();
    runner.run(FFMPEG, &arguments, |line| {
        if let Some(frame) = line.strip_prefix("frame=").and_then(|n| n.trim().parse().ok()) {
            progress.done(frame);
        }
    })?;
    let candidates = candidates(to)?;
    if candidates.is_empty() {
        return Err(format!("{video}: no frame can be read; give another video").into());
    }
    let kept = n.min(candidates.len());
    for i in 0..kept {
        runner.stop.check()?;
        let group = i * candidates.len() / kept..(i + 1) * candidates.len() / kept;
        let sharpness = |file: &PathBuf| sharpness(file).unwrap_or(0.0);
        let graded = candidates[group].iter().map(|file| (sharpness(file), file));
        // The first of equals.
        let best = graded.reduce(|best, next| if next.0 > best.0 { next } else { best });
        if let Some((_, file)) = best {
            let to = to.join(format!("{:05}.jpg", i + 1));
            fs::rename(file, &to).map_err(|error| format!("{}: {error}", to.display()))?;
        }
    }
    for file in candidates.iter().filter(|file| file.is_file()) {
        fs::remove_file(file).map_err(|error| format!("{}: {error}", file.display()))?;
    }
    Ok(())
}

/// How long a video is.
fn seconds(video: &Path) -> Result<f64, Failure> {
    let name = video.display().to_string();
    let said = FFPROBE.ask(&[
        "-v",
        "error",
        "-select_streams",
        "v:0",
        "-show_entries",
        "stream=duration:format=duration",
        "-of",
        "json",
        &name,
    ])?;
    let json: Value = serde_json::from_str(&said).unwrap_or(Value::Null);
    let places = [&json["streams"][0]["duration"], &json["format"]["duration"]];
    let number = |value: &Value| value.as_str().and_then(|text| text.parse::<f64>().ok());
    let found = places.into_iter().filter_map(number).find(|s| *s > 0.0 && s.is_finite());
    if json["streams"].as_array().is_none_or(Vec::is_empty) {
        return Err(format!("{name}: no video that can be read; give another file").into());
    }
    found.ok_or_else(|| {
        format!("{name}: does not say how long it is; write it again with ffmpeg").into()
    })
}

/// Sorted: their names have numbers of one length.
fn candidates(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    files.sort();
    Ok(files)
}

/// The mean difference of neighbouring pixels' differences: of neighbouring frames, the sharpest has
/// the most.
fn sharpness(file: &Path) -> Option<f64> {
    let image = image_file::open(file).ok()?.into_luma8();
    let (width, values) = (image.width() as usize, image.into_raw());
    let along = |step: usize| {
        let triples = values.iter().zip(values.iter().skip(step)).zip(values.iter().skip(2 * step));
        let sum: u64 = triples
            .map(|((a, b), c)| {
                let [a, b, c] = [a, b, c].map(|v| i32::from(*v));
                u64::from((2 * b - a - c).unsigned_abs())
            })
            .sum();
        sum as f64 / values.len() as f64
    };
    (width > 2).then(|| along(1) + along(width))
}
