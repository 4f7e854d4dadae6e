//! Photographs that do not agree with the model, or with each other.
//!
//! A field that was shown contradictions learns their mean, and training's PSNR does not say why
//! it is low. What is wrong can be told from the pictures: each photograph of a camera that is not
//! where it should be is shifted as a whole, a focal length that is wrong makes near parts too
//! large or too small, a blurred photograph differs by a share of its Laplacian, and one of
//! something else has an error like no other.

mod compare;
mod cut;
mod focal;
mod lines;
mod odd;
mod patches;
mod poses;
mod sharpness;

use std::collections::BTreeSet;
use std::ops::Range;

use pocketnerf_core::Error;
use rayon::prelude::*;

use super::Finished;
use crate::picture::{Renderer, Settings};
use crate::trainer::Trainer;
use crate::trainer::held_out::HeldOut;
use crate::trainer::run::LONG_ENOUGH;
use compare::{Pair, Products};
use odd::{odd, psnr};

/// Views that are looked at in any case, where there is time.
pub(super) const VIEWS: usize = 32;
/// What the parts of a view take, in calibration tiles of the largest size.
pub(super) const TILES: usize = 2;
/// Of fewer, nothing is known of what is usual.
pub(super) const FEWEST: usize = 8;
/// Of smaller pictures a part of a pixel is much.
const LEAST: u32 = 64;
/// A photograph that is blurred or has noise is also worse than usual by so many dB: by more, fog has
/// weak edges and is right; by less, it shows something else.
const WORSE: Range<f64> = 1.0..15.0;

/// What photographs and model disagree on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disagreement {
    /// Numbers of the training views whose errors are like no other's, worst first, with the
    /// PSNR of each, dB.
    pub odd: Vec<(usize, f64)>,
    /// The median PSNR of all training views, dB.
    pub usual: f64,
    /// By how many pixels photographs are shifted as a whole against the model, root mean square;
    /// 0 where they are not.
    pub shift: f64,
    /// By which share near parts of photographs are larger beside far ones than in the model's
    /// pictures, as where the focal length is too long; smaller, below 0; 0 where they are not.
    pub magnification: f64,
    /// Share of what photographs show that lies outside the scene's box and its silhouettes.
    pub outside: f64,
    /// Share of the occupied cells that lie nearer than `near` or farther than `far`, the mean over
    /// the cameras.
    pub cut: f64,
    /// Numbers of the training views that are blurred.
    pub blurred: Vec<usize>,
    /// Numbers of the training views that have noise, with its standard deviation, of 255.
    pub noisy: Vec<(usize, f64)>,
    /// The median noise of the training views, of 255.
    pub usual_noise: f64,
}

impl Finished<'_> {
    /// What photographs and model disagree on; `None` for a field that is still taking shape.
    ///
    /// # Errors
    /// Whatever rendering reports.
    pub fn disagreement(&self) -> Result<Option<Disagreement>, Error> {
        let Trainer { config, source, step, .. } = self.trainer;
        if *step < config.settled() {
            return Ok(None);
        }
        let held = self.trainer.held_out_for_long();
        let errors = self.trainer.errors_of_views(&held);
        let (mut odd, usual) = odd(&errors);
        if *step >= LONG_ENOUGH {
            odd.extend(self.trainer.odd_among(&held, usual));
        }
        let views = self.views(&held, &odd);
        let looks = self.looks(&views)?;
        let noise: Vec<_> = views.par_iter().map(|view| sharpness::noise(source, *view)).collect();
        let (noisy, usual_noise) = sharpness::noisy(&noise);
        let is_worse = |view: usize| WORSE.contains(&(usual - psnr(errors[view].mean)));
        let those = |flags: Vec<bool>| {
            let of = views.iter().zip(flags).enumerate();
            of.filter_map(|(i, (view, flag))| (flag && is_worse(*view)).then_some((i, *view)))
        };
        Ok(Some(Disagreement {
            odd,
            usual,
            shift: poses::shift(&looks),
            magnification: focal::magnification(&looks),
            outside: self.trainer.targets.unseen_share,
            cut: cut::share(&self.model(), source.photographs()),
            // A field that has seen few rays is blurred itself.
            blurred: match config.field.kind().is_costly() {
                true => Vec::new(),
                false => those(sharpness::blurred(&looks)).map(|(_, view)| view).collect(),
            },
            noisy: those(noisy).filter_map(|(i, view)| Some((view, noise[i]?))).collect(),
            usual_noise,
        }))
    }

    /// Views that are looked at, in order: those that are odd, to know why, and others, evenly
    /// spread. Views that were held out had less time to be learnt.
    fn views(&self, held: &HeldOut, odd: &[(usize, f64)]) -> Vec<usize> {
        let cameras = self.trainer.source.photographs();
        let (n, some) = (cameras.len(), cameras.len().min(self.views));
        let spread = (0..some).map(|i| i * n / some);
        let all: BTreeSet<usize> = spread.chain(odd.iter().map(|(view, _)| *view)).collect();
        let is_looked_at = |view: &usize| !held.has(*view) && cameras[*view].width >= LEAST;
        let views: Vec<usize> = all.into_iter().filter(is_looked_at).collect();
        if views.len() < FEWEST { Vec::new() } else { views }
    }

    /// What parts of views look like beside the model's pictures, where these show something.
    fn looks(&self, views: &[usize]) -> Result<Vec<Vec<Products>>, Error> {
        let Trainer { source, backend, .. } = self.trainer;
        let model = self.model();
        let settings =
            Settings { simd: backend.simd(), quality: 1.0, depth: true, ..Settings::default() };
        let looks = |&view: &usize| {
            // As it looks, or light alone: over black, what is transparent says nothing.
            let behind = source.behind(view).unwrap_or([0.0; 3]);
            let mut renderer = Renderer::new(&model, &settings);
            let mut own = Vec::new();
            for patch in patches::patches(&source.cameras()[view]) {
                let (camera, _) = &patch;
                let picture = renderer.render_through(camera, &source.lenses()[view])?;
                let pair = Pair {
                    model: &picture.over(behind),
                    depth: &picture.depth,
                    photo: &patches::crop(source, view, &patch, behind),
                    width: camera.width as usize,
                    center: camera.center.map(f64::from),
                };
                own.extend(pair.products());
            }
            Ok(own)
        };
        views.par_iter().map(looks).collect()
    }
}
