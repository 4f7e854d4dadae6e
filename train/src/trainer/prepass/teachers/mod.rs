//! Fields that teach another one what lies between few photographs.
//!
//! What a field gets wrong there is half chance: fields that differ in nothing but their random
//! numbers differ from each other by as much as from the scene, and the mean of their pictures is
//! closer to it than each (deep ensembles, Lakshminarayanan et al. 2017). So some fields are trained
//! first. The field that is kept learns from the photographs and from the mean of what these
//! teachers show between them (distillation, Hinton et al. 2015): one model, as close as their mean.

mod between;

use std::time::Instant;

use pocketnerf_core::{Camera, Error, SimdLevel};
use pocketnerf_formats::{About, FormatError, Precision, WriteError, open, write};

use super::Prepared;
use crate::cameras::EveryFew;
use crate::lens::Lens;
use crate::picture::{Renderer, Settings};
use crate::trainer::pixels::rays::{Pseudo, RaySource};
use crate::trainer::{Length, Progress, Run, RunError, TrainConfig, Trainer};

/// Pixels of all pictures between the photographs, about: each takes every teacher some time.
const PIXELS: f64 = 10e6;
/// Teachers at most: more tell no more.
pub const MOST_TEACHERS: u32 = 8;
/// What lies between the seeds of teachers and that of the run.
const APART: u64 = 1 << 32;

/// Why nothing could be taught.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TeacherError {
    /// The configuration does not make a valid field, or the SIMD level is not there.
    #[error(transparent)]
    Field(#[from] Error),
    /// A teacher could not be trained.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A teacher could not be stored.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A stored teacher cannot be read.
    #[error(transparent)]
    Format(#[from] FormatError),
}

impl Prepared {
    /// Trains `n` teachers, at most [`MOST_TEACHERS`], each for a run of this `length`, and adds the mean of what they show
    /// between the photographs to what is learnt from. `on_step` hears of each step, with the
    /// teacher's number from 1; where it gives `false` all is over, and there is `None`.
    ///
    /// For photographs without alpha, of which neither poses nor exposures are corrected.
    ///
    /// # Errors
    /// As a [`Run`], and when the configuration does not make a valid field or teachers are too many.
    pub fn taught(
        mut self,
        (n, length): (u32, Length),
        simd: SimdLevel,
        on_step: &mut dyn FnMut(u32, &Progress) -> bool,
    ) -> Result<Option<Self>, TeacherError> {
        if n > MOST_TEACHERS {
            return Err(Error::Range("teachers").into());
        }
        let mut teachers = Vec::new();
        for number in 1..=n {
            let Self { source, space, candidates, hull, config } = self;
            let seed = config.seed.wrapping_add(u64::from(number) * APART);
            let own = TrainConfig { seed, ..config.clone() };
            let own =
                Self { source, space, candidates: candidates.clone(), hull: None, config: own };
            let mut trainer = Trainer::from_prepared(own, simd)?;
            let mut run = Run::new(length, Instant::now());
            while let Some(progress) = run.step(&mut trainer)? {
                if !on_step(number, &progress) {
                    return Ok(None);
                }
            }
            teachers.push(write(&trainer.model(), &About::default(), Precision::I8)?);
            self = Self { source: trainer.source, space, candidates, hull, config };
        }
        self.source.learn_from(teachers, simd)?;
        Ok(Some(self))
    }
}

impl RaySource {
    /// From now on the mean of what these models show between the photographs is learnt as well.
    pub(crate) fn learn_from(
        &mut self,
        teachers: Vec<Vec<u8>>,
        simd: SimdLevel,
    ) -> Result<(), TeacherError> {
        let cameras = between::cameras(self.photographs());
        let apart = EveryFew::apart(cameras.iter().map(|(camera, _)| camera), PIXELS);
        let cameras: Vec<(Camera, Lens)> = cameras
            .into_iter()
            .map(|(camera, of)| (EveryFew::new(&camera, apart).camera, self.lenses()[of]))
            .collect();
        let mut sums: Vec<Vec<u16>> = Vec::new();
        for teacher in &teachers {
            let file = open(teacher)?;
            let settings = Settings { simd, ..Settings::default() };
            let mut renderer = Renderer::new(&file.model, &settings);
            for (i, (camera, lens)) in cameras.iter().enumerate() {
                let rgb = renderer.render_through(camera, lens)?.rgb8(&file.model.display);
                match sums.get_mut(i) {
                    Some(sum) => sum.iter_mut().zip(rgb).for_each(|(sum, v)| *sum += u16::from(v)),
                    None => sums.push(rgb.into_iter().map(u16::from).collect()),
                }
            }
        }
        let n = teachers.len().max(1) as u16;
        let mean = |sum: &[u16; 3]| {
            let [r, g, b] = sum.map(|sum| ((sum + n / 2) / n) as u8);
            [r, g, b, u8::MAX]
        };
        let views = cameras.into_iter().zip(sums).map(|((camera, lens), sum)| Pseudo {
            camera,
            lens,
            rgba: sum.as_chunks::<3>().0.iter().flat_map(mean).collect(),
        });
        self.add_pseudo_views(views, teachers);
        Ok(())
    }
}
