//! Recommends settings, from the points.

use std::path::{Path, PathBuf};

use pocketnerf_train::output;
use serde_json::json;

use super::Chart;
use crate::chart::{Point, Wish, groups};
use crate::commands::{Common, Failure, open, print_line, read_model};

impl Chart {
    /// Answers every wish for every scene and picture size, and stores the choice with
    /// `--store`.
    pub(super) fn answer(&self, points: &[Point], common: &Common) -> Result<(), Failure> {
        let mut answers = Vec::new();
        let ours: Vec<Point> = points.iter().filter(|point| point.is_ours()).cloned().collect();
        for group in groups(&ours) {
            for wish in &self.recommend {
                let chosen = wish.choose(ours.iter().filter(|point| point.group() == group));
                if let (Some(point), Some(path)) = (chosen, &self.store) {
                    self.keep(point, path)?;
                }
                if common.json {
                    answers.push(json!({
                        "for": group.to_string(), "wish": wish.to_string(), "point": chosen,
                    }));
                } else {
                    print_line(format_args!("{group}: {}", advice(*wish, chosen)));
                }
                if chosen.is_none() && self.store.is_some() {
                    return Err(
                        format!("--store: no point of {group} is {wish}; ask for less").into()
                    );
                }
            }
        }
        if common.json {
            let object = json!({
                "out": self.out.display().to_string(), "points": points, "recommended": answers,
            });
            common.print_json(object, &unsteady(points));
        }
        Ok(())
    }

    /// The chosen model, which from now on knows the quality.
    fn keep(&self, point: &Point, to: &Path) -> Result<(), Failure> {
        let from = model_path(&self.out, point).filter(|path| path.is_file());
        let from = from.or_else(|| {
            let named =
                |path: &&PathBuf| path.file_stem().is_some_and(|stem| *stem == *point.model);
            self.models.iter().find(named).cloned()
        });
        let from = from.ok_or_else(|| format!("{}: its model is not there any more", point.id))?;
        let bytes = read_model(&from)?;
        let file = open(&from, &bytes)?;
        let bytes = pocketnerf_formats::with_quality(&file, point.quality.unwrap_or(0.5))?;
        Ok(output::write_atomic(to, &bytes)?)
    }
}

/// What is to be said of times that cannot be trusted.
fn unsteady(points: &[Point]) -> Vec<String> {
    let unsteady = points.iter().filter(|point| point.unsteady == Some(true));
    let said = |point: &Point| {
        format!("{}: the times of its rounds differ: measure again on a quiet machine", point.id)
    };
    unsteady.map(said).collect()
}

/// Where the model of a point lies.
fn model_path(out: &Path, point: &Point) -> Option<PathBuf> {
    let precision = point.precision.as_deref()?;
    Some(out.join("models").join(format!("{}.{}.{precision}.pnerf", point.scene, point.model)))
}

/// A line: the point and how to get there.
fn advice(wish: Wish, chosen: Option<&Point>) -> String {
    let Some(point) = chosen else { return format!("{wish}: none of the points is") };
    let figure = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let how = point.train_command.as_ref().map_or_else(String::new, |command| {
        let quality = point.quality.unwrap_or(0.5);
        format!(": {command} && pocketnerf render scene.pnerf --quality {quality}")
    });
    format!(
        "{wish}: {} ({:.2} dB, {:.1} frames per second, {} bytes){how}",
        point.id,
        figure(point.psnr),
        figure(point.frames_per_second),
        point.bytes.unwrap_or(0),
    )
}
