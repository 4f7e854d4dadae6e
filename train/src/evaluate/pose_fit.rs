//! The pose from which a model shows a photograph best.
//!
//! Poses that are corrected while a field learns end in a frame of their own, which held-out photographs
//! are not in. So, as Lin et al. 2021 ("BARF") evaluate, six numbers of each are fitted before its
//! picture is compared: by Gauss and Newton's method with Levenberg's and Marquardt's damping, first
//! of blurred pictures, then of sharper ones.

use std::iter::once;

use pocketnerf_core::{Camera, Display, Error};
use serde::Serialize;

use super::least_squares::{NormalEquations, square};
use crate::cameras::EveryFew;
use crate::cameras::mount::{Mount, PER_VIEW};
use crate::dataset::View;
use crate::lens::Lens;
use crate::metrics::{composite_on, median};
use crate::picture::Painter;

/// Pixels of the pictures that are compared, about.
const PIXELS: f64 = 65_536.0;
/// Sides of the blocks of pixels whose means are compared, one after the other: the wider, the
/// farther off may a pose be.
const BLOCKS: [usize; 4] = [8, 4, 2, 1];
/// Steps with blocks of a size at most.
const STEPS: usize = 12;
/// A step that moves what is seen by less, pixels, is the last of these.
const LEAST: f64 = 0.01;
/// The damping is at least this, beside the diagonal of the equations ...
const DAMPING: f64 = 1e-4;
/// ... and grows so many times by so much where a step does not help.
const TRIES: usize = 6;
const HARDER: f64 = 10.0;
/// How far differences reach to both sides for slopes, in blocks: samples along a ray are a little
/// noise, and a one-sided difference leans to its side.
const REACH: f32 = 0.3;
/// Cameras turn about what they see, which that moves less than a shift as large: so many times.
const TURN: f32 = 4.0;

/// By how much the pose of a view was corrected.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PoseCorrection {
    /// Turn of the camera, degrees.
    pub degrees: f64,
    /// How far the camera is moved, scene units.
    pub shift: f64,
}

/// Fits the camera of a view to what `painter` shows: the camera, and what was corrected. `display`
/// has the background, and `ahead` is how far the scene is where the painter renders no depth.
pub(super) fn fit_pose(
    painter: &mut dyn Painter,
    view: &View,
    display: &Display,
    ahead: f32,
) -> Result<(Camera, PoseCorrection), Error> {
    let photograph = Photograph::new(view, display);
    let ahead = photograph.depth(painter)?.unwrap_or(ahead);
    let mount = Mount::new(&view.camera, ahead, ahead);
    let mut own = [0.0; PER_VIEW];
    for block in BLOCKS {
        own = photograph.descend(painter, &mount, block, own)?;
    }
    // Blurred pictures may lead astray; sharp ones judge.
    let given = [0.0; PER_VIEW];
    let mut error = |own| {
        photograph.errors(painter, &photograph.camera(&mount, own), 1).map(|errors| square(&errors))
    };
    if error(&given)? <= error(&own)? {
        own = given;
    }
    let [turn, shift] = mount.size(&own);
    let correction = PoseCorrection { degrees: turn.to_degrees(), shift };
    Ok((mount.camera(&view.camera, &own), correction))
}

/// Every few pixels of a view. Means of what lies between them would not do: pictures have one ray a
/// pixel, and of smaller photographs details that these do not show.
struct Photograph<'v> {
    camera: Camera,
    lens: &'v Lens,
    /// RGB over the background, the model's colour space; `None` where a pixel does not count.
    truth: Vec<Option<[f32; 3]>>,
    background: [f32; 3],
}

impl<'v> Photograph<'v> {
    /// So few that a view of any size takes about as long.
    fn new(view: &'v View, display: &Display) -> Self {
        let whole = &view.camera;
        let few = EveryFew::new(whole, EveryFew::apart(once(whole), PIXELS));
        let all = composite_on(&view.rgba, display.srgb_background());
        let truth = few.pixels().map(|[x, y]| {
            let i = (y * whole.width + x) as usize;
            let counts = view.mask.as_ref().is_none_or(|mask| mask[i] != 0);
            counts.then(|| display.color_space.from_srgb(all.as_chunks::<3>().0[i]))
        });
        let (camera, truth) = (few.camera, truth.collect());
        Self { camera, lens: &view.lens, truth, background: display.background }
    }

    /// Its camera with a correction.
    fn camera(&self, mount: &Mount, own: &[f32; PER_VIEW]) -> Camera {
        mount.camera(&self.camera, own)
    }

    /// The median depth of what the painter shows; `None` where it renders none.
    fn depth(&self, painter: &mut dyn Painter) -> Result<Option<f32>, Error> {
        let picture = painter.paint(&self.camera, self.lens)?;
        let known = picture.depth.iter().filter(|depth| depth.is_finite());
        let depth = median(known.map(|depth| f64::from(*depth)));
        Ok(depth.map(|depth| depth as f32).filter(|depth| *depth > 0.0))
    }

    /// By how much blocks of the picture of a camera are brighter than the truth. Each channel is
    /// multiplied by the factor that is best: how bright a photograph is says nothing of its pose.
    fn errors(
        &self,
        painter: &mut dyn Painter,
        camera: &Camera,
        block: usize,
    ) -> Result<Vec<f32>, Error> {
        let picture = painter.paint(camera, self.lens)?;
        let pixels = picture.rgba.as_chunks::<4>().0.iter().zip(&self.truth).enumerate();
        let pixels = pixels.filter_map(|(i, (rendered, truth))| Some((i, rendered, (*truth)?)));
        let behind = |c: usize, alpha: f32| self.background[c] * (1.0 - alpha);
        let factor = |c: usize| {
            let (mut along, mut square) = (0.0, 0.0);
            for (_, rendered, truth) in pixels.clone() {
                along += f64::from(rendered[c] * (truth[c] - behind(c, rendered[3])));
                square += f64::from(rendered[c] * rendered[c]);
            }
            if along > 0.0 && square > 0.0 { (along / square) as f32 } else { 1.0 }
        };
        let factors = [0, 1, 2].map(factor);
        let [width, height] = [self.camera.width, self.camera.height].map(|n| n as usize);
        let [columns, rows] = [width, height].map(|n| n.div_ceil(block));
        let mut errors = vec![0.0; 3 * columns * rows];
        for (i, rendered, truth) in pixels {
            let at = 3 * (i / width / block * columns + i % width / block);
            for (c, error) in errors[at..at + 3].iter_mut().enumerate() {
                *error += rendered[c] * factors[c] + behind(c, rendered[3]) - truth[c];
            }
        }
        Ok(errors)
    }

    /// The best correction, from one that is near, as blocks of that many pixels a side show it.
    fn descend(
        &self,
        painter: &mut dyn Painter,
        mount: &Mount,
        block: usize,
        mut own: [f32; PER_VIEW],
    ) -> Result<[f32; PER_VIEW], Error> {
        let mut errors =
            |own: &[f32; PER_VIEW]| self.errors(painter, &self.camera(mount, own), block);
        // A shift of 1 is as long as what is seen is far: it moves that by the focal length.
        let pixel = 1.0 / self.camera.focal[0].max(self.camera.focal[1]);
        let shift = REACH * block as f32 * pixel;
        let reach = [TURN * shift, TURN * shift, TURN * shift, shift, shift, shift];
        let (mut here, mut damping) = (errors(&own)?, DAMPING);
        for _ in 0..STEPS {
            let mut slopes = Vec::with_capacity(PER_VIEW);
            for (i, reach) in reach.into_iter().enumerate() {
                let mut beside = |by: f32| {
                    let mut beside = own;
                    beside[i] += by;
                    errors(&beside)
                };
                let (mut slope, less) = (beside(reach)?, beside(-reach)?);
                slope.iter_mut().zip(less).for_each(|(e, less)| *e = (*e - less) / (2.0 * reach));
                slopes.push(slope);
            }
            let equations = NormalEquations::new(&slopes, &here);
            let mut moved = 0.0;
            for _ in 0..TRIES {
                let Some(step) = equations.solve(damping) else { break };
                let next = core::array::from_fn(|i| own[i] - step[i] as f32);
                let found = errors(&next)?;
                if square(&found) < square(&here) {
                    (own, here) = (next, found);
                    damping = (damping / HARDER).max(DAMPING);
                    moved = step.iter().map(|x| x * x).sum::<f64>().sqrt() / f64::from(pixel);
                    break;
                }
                damping *= HARDER;
            }
            if moved < LEAST {
                break;
            }
        }
        Ok(own)
    }
}
