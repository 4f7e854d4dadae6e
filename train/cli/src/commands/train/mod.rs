//! `pocketnerf train`.

mod bar;
mod baseline;
mod begin;
mod kinds;
mod model;
mod options;
mod origin;
mod photographs;
mod refined;
mod saving;
mod scene;
mod sized;
mod taught;
#[cfg(feature = "view")]
mod watch;
#[cfg(not(feature = "view"))]
#[path = "unwatched.rs"]
mod watch;
mod world;

use std::path::{Path, PathBuf};
use std::time::Duration;

use pocketnerf_train::cameras::{GAP, WIDE, spacing, widest_gap};
use pocketnerf_train::compact::CompactError;
use pocketnerf_train::dataset::Dataset;
use pocketnerf_train::output;
use pocketnerf_train::picture::Device;
use pocketnerf_train::trainer::{Checkpoint, Run, Size, Trainer};
use serde_json::{Value, json};

use super::device::Opening;
use super::stop::Stop;
use super::{Common, Failure, device, memory, print_line};
pub(super) use bar::Bar;
pub(super) use kinds::Method;
pub(super) use options::{SECONDS, Train};
use origin::method;
pub(super) use origin::{Origin, default_camera};
use refined::Refined;
pub(super) use saving::{Interrupted, Unfinished};
use saving::{Resume, Saving};
pub(super) use saving::{checkpoint_path, quoted};
use sized::{Sized, sized};
use watch::Audience;
pub(super) use world::{WorldOptions, parse_metres};

/// Share of surface points whose colours jump between the training views from which on the user
/// is told: sound models of lego have up to three quarters of it, one of which a view is too
/// bright has 1.2 times as much, one of which two saturate 2.8 times.
const JUMPS: f64 = 9e-4;
/// JPEG quality of photographs below which more is lost than 1.5 dB, at the size of the still
/// life's pictures of 100x100: 2.4 dB at 50, 0.5 at 90.
const COMPRESSED: f32 = 60.0;

impl Train {
    pub(super) fn run(&self, common: &Common) -> Result<(), Failure> {
        self.check()?;
        if let Some(begin) = self.baseline()? {
            return self.train_baseline(begin, common);
        }
        self.watch.attend(&self.out, |audience| self.train(common, audience))
    }

    fn train(&self, common: &Common, mut audience: Audience) -> Result<(), Failure> {
        let outcome = "interrupted before the first step; there is nothing to save";
        let stop = Stop::listen(common, outcome)?;
        let saved = checkpoint_path(&self.out);
        output::check_output(&self.out)?;
        output::check_output(&saved)?;
        let checkpoint = self.resume.as_deref().map(Checkpoint::read).transpose()?;
        let mut bar = audience.bar(common);
        let mut level = self.vectors.level();
        let device = self.device.begin_to_open();
        if let Some(checkpoint) = &checkpoint {
            self.check_against(checkpoint)?;
            level = self.level_to_resume(checkpoint, &mut bar);
        }
        let factor = checkpoint.as_ref().map(|c| c.trained_on().downscale_factor);
        let factor = factor.unwrap_or_else(|| self.downscale_factor());
        let mut dataset = self.photographs(checkpoint.is_none(), factor, common, &mut bar)?;
        let backdrop = match &checkpoint {
            Some(checkpoint) => checkpoint.config().backdrop,
            None => self.scene.background,
        };
        let plain = dataset.cut_out(backdrop);
        let doubts = self.doubts(&dataset, plain.is_some());
        if plain.is_some() {
            bar.say(
                "the background of the photographs is plain and is cut out; --background with \
                 another colour keeps it",
            );
        }
        let known = checkpoint.as_ref().map_or_else(|| dataset.world(), Checkpoint::world);
        let origin = Origin::new(&dataset, factor, self.precision, self.world.or(known));
        bar.phase("finding the scene");
        let (mut trainer, mut run) = match checkpoint {
            Some(checkpoint) => {
                let (mut trainer, run) = checkpoint.resume(dataset, level, common.started)?;
                trainer.train_on(opened(device, &mut bar));
                (trainer, run)
            }
            None => {
                let level = (level, device);
                let trainer =
                    self.new_trainer(dataset, level, (common.started, &stop), &mut bar)?;
                (trainer, Run::new(self.length(), common.started))
            }
        };
        let refused = trainer.fallback();
        refused.iter().for_each(|why| bar.warn(device::trained_on_cpu(why)));
        self.model.check_size(&trainer)?;
        run.aim_at(self.model.size());
        // Not before: a refusal is one line.
        doubts.into_iter().for_each(|doubt| bar.warn(doubt));
        let every = self.save_every.map(Duration::from_secs_f64);
        let mut saving = Saving::begin(saved, every, stop.clone());
        let resume = |checkpoint: PathBuf| Resume {
            checkpoint,
            data: self.data.clone(),
            out: self.out.clone(),
            precision: self.precision,
            size: self.model.size(),
            reading: self.reading,
            views: self.views,
        };
        train(&mut trainer, &mut run, &mut bar, |trainer, run, bar| {
            audience.after_step(trainer, run, &origin, bar);
            let checkpoint = || saving::checkpoint(trainer, run, &origin);
            match saving.after_step(run.is_over(trainer), checkpoint, bar)? {
                Some(saved) => {
                    Err(Interrupted { step: trainer.steps(), resume: resume(saved) }.into())
                }
                None => Ok(()),
            }
        })?;
        if trainer.gave_up_clearing() {
            bar.note("thin fog is kept: training views became worse without it");
        }
        if let (None, Some(why)) = (&refused, trainer.fallback()) {
            bar.warn(device::trained_on_cpu(&why));
        }
        let checkpoint = || saving::checkpoint(&trainer, &run, &origin);
        let stopped = || saving.is_asked_to_stop();
        let mut result = match finish(&trainer, &run, &origin, (&self.out, &stopped), &mut bar) {
            Ok(Some(result)) => result,
            Ok(None) => {
                let saved = saving.rescue(&checkpoint()?)?;
                return Err(Interrupted { step: trainer.steps(), resume: resume(saved) }.into());
            }
            Err(reason) => {
                let saved = saving.rescue(&checkpoint()?)?;
                let mut resume = resume(saved);
                // With a limit that can be met.
                if let Some(CompactError::TooSmall { least, .. }) = reason.downcast_ref() {
                    resume.size = u32::try_from(*least).map_or(Size::Whole, Size::Bytes);
                }
                return Err(Unfinished { reason, resume }.into());
            }
        };
        result["background_cut_out"] = plain.is_some().into();
        result["teachers"] = trainer.n_teachers().into();
        result["fog_cleared"] = trainer.has_cleared_fog().into();
        result["exposure_evened_out"] = trainer.is_evened_out().into();
        if let Some(refined) = Refined::of(&trainer, &origin) {
            refined.add_to(&mut result);
        }
        saving.at_end(checkpoint, &mut bar);
        drop(bar);
        audience.finish(&self.out);
        report(result, common);
        if audience.stays() {
            stop.done();
        }
        Ok(())
    }
}

impl Train {
    /// What is to be said of photographs and options before training.
    fn doubts(&self, dataset: &Dataset, is_cut_out: bool) -> Vec<String> {
        let mut doubts = Vec::new();
        let cameras = || dataset.views.iter().map(|view| &view.camera);
        let gap = widest_gap(cameras());
        if let Some(angle) = spacing(cameras()).filter(|angle| *angle > WIDE) {
            doubts.push(format!(
                "{} photographs, {angle:.0} degrees from one to the next, expected at most {WIDE}: \
                 what lies between them is a guess; take more",
                dataset.views.len()
            ));
        }
        // Wherever they are far apart there are gaps.
        else if gap > GAP {
            doubts.push(format!(
                "photographs leave a gap: from a direction between them none is nearer than \
                 {gap:.0} degrees, expected at most {GAP}: what is seen from there is a guess; take \
                 some there"
            ));
        }
        let pixels = dataset.views.iter().map(|view| view.rgba.len() / 4).sum();
        doubts.extend(self.model.doubt(dataset.pixels_across(), pixels, self.length()));
        doubts.extend(self.model.doubt_of_rate());
        if let Some(quality) = dataset.jpeg_quality().filter(|quality| *quality < COMPRESSED) {
            doubts.push(format!(
                "photographs were compressed by JPEG at quality {quality:.0}, expected at least \
                 {COMPRESSED}: details are lost; give the originals, or smaller pictures of them \
                 (--downscale-factor)"
            ));
        }
        if self.scene.background.is_some() && dataset.has_alpha && !is_cut_out {
            doubts.push(
                "--background: against one colour, alpha teaches nothing, and what has that colour \
                 may become a hole; leave it out for images with alpha"
                    .to_owned(),
            );
        }
        doubts
    }
}

/// Prints what a run came to.
fn report(result: Value, common: &Common) {
    if common.json {
        return common.result(result);
    }
    let text = |key: &str| result[key].as_str().unwrap_or_default().to_owned();
    let number = |key: &str| result[key].as_f64().unwrap_or(f64::NAN);
    print_line(format_args!(
        "{}: {} bytes, {} steps, training PSNR {:.2} dB, {:.1} s{}",
        text("out"),
        result["bytes"],
        result["steps"],
        number("train_psnr"),
        number("seconds"),
        if result["replaced"] == true { "; an older file was replaced" } else { "" },
    ));
}

/// The device, once it is open; the user hears why it is the CPU after all.
fn opened(device: Opening, bar: &mut Bar) -> Device {
    let (device, refusal) = device.wait();
    refusal.into_iter().for_each(|why| bar.warn(why));
    device
}

/// Trains to the end unless `after_step` fails, which is also called after the last step.
pub(super) fn train(
    trainer: &mut Trainer,
    run: &mut Run,
    bar: &mut Bar,
    mut after_step: impl FnMut(&Trainer, &Run, &mut Bar) -> Result<(), Failure>,
) -> Result<(), Failure> {
    bar.phase("training");
    while let Some(progress) = run.step(trainer)? {
        bar.show(&progress);
        after_step(trainer, run, bar)?;
    }
    Ok(())
}

/// Writes the model, and returns what `train --json` prints; `None` where it is `stopped` before
/// that.
pub(super) fn finish(
    trainer: &Trainer,
    run: &Run,
    origin: &Origin,
    (out, stopped): (&Path, &dyn Fn() -> bool),
    bar: &mut Bar,
) -> Result<Option<Value>, Failure> {
    bar.phase("finishing the model");
    if stopped() {
        return Ok(None);
    }
    let (steps, least) = (trainer.steps(), trainer.config().least_steps());
    // One that overfits ends early.
    if steps < least && run.overfitted().is_none() {
        bar.warn(format!("only {steps} steps were taken, expected at least {least}; train longer"));
    }
    if let Some(doubt) = run.doubt(trainer) {
        bar.warn(format!("{doubt} after {steps} steps; train longer"));
    }
    if let Some(line) = Refined::of(trainer, origin).and_then(|refined| refined.doubt()) {
        bar.warn(line);
    }
    if let Some(line) = trainer.config().field.kind().doubt() {
        bar.warn(line);
    }
    if let Some(overfitted) = run.overfitted() {
        bar.warn(overfitted.to_string());
    }
    let about = origin.about(trainer, run);
    let finished = trainer.finished(run.finishing_budget(trainer))?;
    let color_jumps = finished.color_jumps()?;
    if let Some(share) = color_jumps.filter(|share| *share > JUMPS) {
        bar.warn(format!(
            "colours of {:.2} % of the surfaces jump between the training views, expected at most \
             {:.2} %: highlights may show where there are none; train with another --seed or give \
             more photographs",
            100.0 * share,
            100.0 * JUMPS
        ));
    }
    if let Some(disagreement) = finished.disagreement()? {
        disagreement.lines(|view| origin.view(view)).into_iter().for_each(|line| bar.warn(line));
    }
    if stopped() {
        return Ok(None);
    }
    let bytes = pocketnerf_formats::write(&finished.model(), &about, origin.precision)?;
    let (bytes, sized) = sized((trainer, run), &bytes, bar)?;
    // Of the file itself, where views are still held out.
    let held_out = match &sized {
        Some(Sized { held_out: Some(found), .. }) => Some(*found),
        _ => run.held_out_psnr(),
    };
    let replaced = out.exists();
    output::write_atomic(out, &bytes)?;
    let (summary, seconds) = (run.summary(trainer), run.elapsed());
    Ok(Some(json!({
        "seconds": seconds,
        "steps": trainer.steps(),
        "restarts": summary.restarts,
        "rays": summary.rays,
        "samples": summary.samples,
        "samples_per_second": summary.samples as f64 / seconds,
        "train_psnr": summary.train_psnr,
        "held_out_psnr": held_out.map(|found| found.mean),
        "held_out_psnr_min": held_out.map(|found| found.min),
        "color_jumps": color_jumps,
        "bytes": bytes.len(),
        "size": sized.map(|sized| sized.facts),
        "replaced": replaced,
        "peak_memory_bytes": memory::peak(),
        "seed": trainer.config().seed,
        "device": if trainer.is_on_gpu() { "gpu" } else { "cpu" },
        "threads": rayon::current_num_threads(),
        "method": method(trainer),
        "warnings": bar.warnings(),
        "out": out.display().to_string(),
    })))
}
