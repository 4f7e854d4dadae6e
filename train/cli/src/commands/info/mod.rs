//! `pocketnerf info`.

mod baseline;
mod cost;
mod table;

use std::path::{Path, PathBuf};

use pocketnerf_baselines::is_baseline;
use pocketnerf_core::Space;
use pocketnerf_core::march::Reach;
use pocketnerf_formats::{Container, ModelFile, Role, SectionId};
use pocketnerf_train::dataset::Footage;
use pocketnerf_train::trainer::checkpoint::{Checkpoint, kind, section_name};
use pocketnerf_train::{dataset, field, output};
use serde_json::{Value, json};

#[cfg(feature = "gpu")]
use super::device;
use super::{Common, Failure, Reading, open, print_line, read_model};
use cost::Cost;
use table::table;

#[derive(Debug, clap::Args)]
pub(super) struct Info {
    /// Model file, checkpoint or dataset folder
    ///
    /// Of a dataset, what is suspicious is told, a line each with what to do, and what training
    /// costs. Photographs are looked at for this.
    #[cfg_attr(feature = "gpu", arg(required_unless_present = "gpus"))]
    #[cfg_attr(not(feature = "gpu"), arg(required = true))]
    path: Option<PathBuf>,
    /// List the GPUs of this machine, first the one that --device gpu takes
    #[cfg(feature = "gpu")]
    #[arg(long, conflicts_with = "path")]
    gpus: bool,
    /// Draw the cameras of a dataset and the scene's box, from above and from the side: an SVG file
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

impl Info {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        match &self.path {
            Some(path) => self.show(path, common),
            None => {
                #[cfg(feature = "gpu")]
                device::list(common);
                Ok(())
            }
        }
    }

    fn show_dataset(&self, path: &Path, common: &Common) -> Result<(), Failure> {
        let options = self.reading.options(1);
        let report = dataset::inspect_with(path, &options)?;
        if let Some(file) = &self.picture {
            output::write_atomic(file, dataset::picture(path, &options)?.as_bytes())?;
        }
        let cost = Cost::of(&report);
        let doubt = cost.and_then(|cost| cost.doubt());
        if common.json {
            let mut object = serde_json::to_value(&report)?;
            object["cost"] = serde_json::to_value(cost)?;
            object["picture"] = json!(self.picture);
            let warnings: Vec<String> = report.warnings().into_iter().chain(doubt).collect();
            common.print_json(object, &warnings);
        } else {
            print_line(report);
            cost.iter().for_each(|cost| print_line(cost.row()));
            doubt.iter().for_each(|doubt| print_line(format_args!("suspect   {doubt}")));
        }
        Ok(())
    }

    fn show(&self, path: &Path, common: &Common) -> Result<(), Failure> {
        // Of a video and an archive, the dataset's loader names the next step.
        if path.is_dir() || Footage::of(path) != Footage::Other {
            return self.show_dataset(path, common);
        }
        if self.picture.is_some() {
            return Err(format!(
                "{}: --picture is for datasets, and this is a file; give a dataset's folder",
                path.display()
            )
            .into());
        }
        let bytes = read_model(path)?;
        if is_baseline(&bytes) {
            return baseline::show(path, &bytes, common);
        }
        let file = open(path, &bytes)?;
        let space = match file.model.space {
            Space::Box { .. } => json!("box"),
            Space::Ndc(ndc) => json!({"ndc": {"near": ndc.near, "slope": ndc.slope}}),
            Space::Contracted(space) => {
                json!({"contracted": {"center": space.center, "radius": space.radius}})
            }
            _ => return Err("this build does not know the model's kind of space".into()),
        };
        let parameters: usize = file.tensors().map(|(_, t)| t.rows() * t.cols()).sum();
        // As they lie on disk.
        let sections: Vec<_> = Container::open(bytes.stored())?
            .sections()
            .map(|s| {
                json!({
                    "kind": section_name(s.id.kind),
                    "index": s.id.index,
                    "bytes": s.bytes.len(),
                    "unpacked_bytes": s.decoded_length,
                })
            })
            .collect();
        let provenance = file.about.provenance;
        let is_checkpoint = file.container().find(SectionId::first(kind::TRAINER)).is_some();
        let checkpoint = match is_checkpoint {
            true => Some(checkpoint(&Checkpoint::from_bytes(path, &bytes)?)),
            false => None,
        };
        let value = json!({
            "checkpoint": checkpoint,
            "method": file.model.field.kind(),
            "bytes": bytes.stored().len(),
            "unpacked_bytes": bytes.len(),
            "parameters": parameters,
            "networks": field::networks(&file.model.field),
            "paper_sampling": file.model.hierarchical.map(|h| {
                json!({"n_coarse": h.n_coarse, "n_fine": h.n_fine, "clipped": h.reach == Reach::Clipped})
            }),
            "precision": precision(&file),
            "sections": sections,
            "space": space,
            "aabb": file.model.space.bounds(),
            "world": world(&file),
            "tolerance": file.model.display.tolerance,
            "quality": file.about.quality,
            "photographs": file.about.photographs.map(|photographs| photographs.len()),
            "occupancy_fraction": file.model.occupancy.map(|o| o.fraction()),
            "trained_on": provenance.map(|p| {
                json!({"dataset": p.dataset, "fingerprint": format!("{:016x}", p.trained_on),
                    "seed": p.seed, "steps": p.steps, "program": p.program})
            }),
            "metrics": provenance.and_then(|p| p.train_psnr).map(|p| json!({"train_psnr": p})),
        });
        if common.json {
            common.print_json(value, &[]);
        } else {
            print_line(table(&path.display().to_string(), &value).trim_end());
        }
        Ok(())
    }
}

/// The stored types: `f16`, or `i8 tables, f16 networks`.
fn precision(file: &ModelFile<'_>) -> String {
    let name = |dtype| format!("{dtype:?}").to_lowercase();
    let networks = file.model.field.dtype();
    let weights =
        file.tensors().filter(|(name, _)| !matches!(name.role(), Role::Exact | Role::Index));
    match weights.map(|(_, view)| view.dtype()).find(|dtype| *dtype != networks) {
        Some(tables) => format!("{} tables, {} networks", name(tables), name(networks)),
        None => name(networks),
    }
}

/// The way from the model's coordinates to the dataset's, and what is known of these.
fn world(file: &ModelFile<'_>) -> Value {
    let (scene, world) = (&file.about.scene, &file.about.world);
    json!({
        "scale": scene.scale,
        "rotation": scene.rotation,
        "translation": scene.translation,
        "up": world.up,
        "metres": world.metres,
    })
}

/// How far the run of a checkpoint is.
fn checkpoint(checkpoint: &Checkpoint) -> Value {
    json!({
        "step": checkpoint.steps(),
        "steps": checkpoint.plan().map(|plan| plan.end),
        "restarts": checkpoint.restarts(),
        "seconds": checkpoint.elapsed(),
        "seed": checkpoint.config().seed,
        "downscale_factor": checkpoint.trained_on().downscale_factor,
    })
}
