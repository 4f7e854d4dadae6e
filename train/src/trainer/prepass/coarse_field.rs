//! A small field, trained for a second, shows how large the scene is.
//!
//! Silhouettes leave room that no camera looks into, below a table that all of
//! them see from above. The finer the box, the finer the grid that fills it.

use pocketnerf_core::{Camera, Ray, SimdLevel, Space};
use rayon::prelude::*;

use super::visual_hull::VisualHull;
use super::{Deadline, Prepared, PrepassError, carved};
use crate::trainer::pixels::rays::{Pixel, RaySource};
use crate::trainer::{StepSettings, TrainConfig, Trainer};

/// Steps of the small field: by then empty space is known to be empty.
const STEPS: u32 = 256;
/// Steps after which its surfaces are known.
const LONGER: u32 = 768;
/// Cells of its occupancy along an axis.
pub(super) const RESOLUTION: u32 = 64;
/// Density of what is there, 1 / side of the box. The field begins with 1.
const SIGMA: f32 = 20.0;
/// Samples of its steps at most ...
const SAMPLES: usize = 1 << 13;
/// ... and at least: one for so many pixels of all photographs. Thumbnails say no more if they are
/// looked at again and again.
const FEWEST_SAMPLES: usize = 1 << 11;
const PIXELS_A_SAMPLE: usize = 2;
/// A box is worth another if its longest side is this much shorter.
const WORTH: f32 = 0.97;
/// Every so many pixels must be explained by the box. A prime, so that all
/// columns have their turn.
const PIXELS_APART: usize = 7;
/// Points at which a ray looks for the nearest way into the box.
const POINTS: u32 = 64;

/// The part of `around` that holds the scene, and the source back.
pub(crate) fn tighten(
    around: Space,
    source: RaySource,
    hull: &VisualHull,
    config: &TrainConfig,
    resources: (SimdLevel, Deadline),
) -> Result<(Space, RaySource), PrepassError> {
    let small = small(config, &source);
    let small = carved(source, Some(hull), around, small);
    let trainer = trained(small, resources, STEPS)?;
    let found = occupied(&trainer, SIGMA);
    let source = trainer.source;
    let Some([min, max]) = found else { return Ok((around, source)) };
    let [min, max] = explaining(&source, around, min, max);
    let space = Space::Box { min, max };
    let worth = space.validate().is_ok() && side(space) < WORTH * side(around);
    Ok((if worth { space } else { around }, source))
}

/// Which of the candidates may hold something, and the source back: what the small field
/// occupies, and its neighbours. For a field that is costly to evaluate.
pub(super) fn cells(
    prepared: Prepared,
    hull: Option<&VisualHull>,
    resources: (SimdLevel, Deadline),
) -> Result<(Vec<u32>, RaySource), PrepassError> {
    let Prepared { source, space, mut candidates, config, .. } = prepared;
    let small = small(&config, &source);
    let trainer = trained(carved(source, hull, space, small), resources, LONGER)?;
    let (grown, n) = (trainer.grid.grown(), config.occupancy_resolution);
    let at = |c: u32| (c as f32 + 0.5) / n as f32;
    candidates.retain(|cell| grown.at([at(cell % n), at(cell / n % n), at(cell / (n * n))]));
    Ok((candidates, trainer.source))
}

/// The small field after so many steps.
fn trained(
    small: Prepared,
    (simd, deadline): (SimdLevel, Deadline),
    steps: u32,
) -> Result<Trainer, PrepassError> {
    let mut trainer = Trainer::from_prepared(small, simd)?;
    for step in 0..steps {
        deadline.check()?;
        step_at(&mut trainer, step as f32 / steps as f32);
    }
    // Another two looks at every cell.
    for _ in 0..8 {
        trainer.update_occupancy();
    }
    Ok(trainer)
}

/// A step of a small field, after this share of its run.
pub(super) fn step_at(trainer: &mut Trainer, progress: f32) {
    trainer.step(&StepSettings {
        rate: (progress * 16.0).min(1.0) * (1.0 - 0.9 * progress),
        decay: 0.0,
        smoothing: 0.0,
        step_scale: 1.0,
        kept: 0.3,
        update_occupancy: true,
        average: false,
        between_views: false,
        spread: 0.0,
        progress,
    });
}

fn side(space: Space) -> f32 {
    1.0 / space.unit_map().scale
}

/// The same scene with a field that learns its outline in no time.
pub(super) fn small(config: &TrainConfig, source: &RaySource) -> TrainConfig {
    let pixels: usize = source.images().iter().map(|rgba| rgba.len() / 4).sum();
    TrainConfig {
        field: config.field.kind().coarse(),
        occupancy_resolution: RESOLUTION,
        samples_per_side: 128.0,
        samples_per_step: (pixels / PIXELS_A_SAMPLE).clamp(FEWEST_SAMPLES, SAMPLES),
        batch_rays: None,
        network_rate: TrainConfig::hash_grid().network_rate,
        smooth_surfaces: 0.0,
        clear_fog: false,
        refine_poses: false,
        ..config.clone()
    }
}

/// The corners of what the field occupies and a cell more on every side.
fn occupied(trainer: &Trainer, sigma: f32) -> Option<[[f32; 3]; 2]> {
    let map = trainer.space.unit_map();
    let n = RESOLUTION;
    let (mut low, mut high) = ([n; 3], [0; 3]);
    for cell in trainer.grid.denser_than(sigma * map.scale) {
        let cell = [cell % n, cell / n % n, cell / (n * n)];
        for a in 0..3 {
            low[a] = low[a].min(cell[a]);
            high[a] = high[a].max(cell[a] + 1);
        }
    }
    let [min, max] = trainer.space.bounds();
    let at = |a: usize, cell: u32| map.min[a] + cell as f32 / n as f32 / map.scale;
    (low[0] < high[0]).then(|| {
        [
            [0, 1, 2].map(|a| at(a, low[a].saturating_sub(1)).max(min[a])),
            [0, 1, 2].map(|a| at(a, high[a] + 1).min(max[a])),
        ]
    })
}

/// The box grown until every ray through an opaque pixel meets it: a thin part
/// may have been missed, but not by the photographs.
fn explaining(
    source: &RaySource,
    around: Space,
    mut min: [f32; 3],
    mut max: [f32; 3],
) -> [[f32; 3]; 2] {
    let meets =
        |ray: &Ray, min, max| Space::Box { min, max }.intersect(ray, 0.0, f32::MAX).is_some();
    let missing = |(view, (camera, rgba)): (usize, (&Camera, &Vec<u8>))| -> Vec<Ray> {
        let width = camera.width as usize;
        let opaque = (0..rgba.len() / 4).step_by(PIXELS_APART).filter(|i| rgba[4 * i + 3] >= 128);
        opaque
            .filter(|i| source.counts(view, *i))
            .map(|i| {
                let (x, y) = ((i % width) as u32, (i / width) as u32);
                source.through(Pixel { view: view as u32, x, y })
            })
            .filter(|ray| !meets(ray, min, max))
            .collect()
    };
    let views = source.cameras().par_iter().zip(source.images()).enumerate();
    let missing: Vec<Vec<Ray>> = views.map(missing).collect();
    for ray in missing.iter().flatten() {
        if meets(ray, min, max) {
            continue;
        }
        let Some([t0, t1]) = around.intersect(ray, 0.0, f32::MAX) else { continue };
        let point = |i: u32| {
            let t = t0 + (t1 - t0) * i as f32 / (POINTS - 1) as f32;
            [0, 1, 2].map(|a| ray.origin[a] + t * ray.direction[a])
        };
        let away =
            |p: &[f32; 3]| (0..3).map(|a| (min[a] - p[a]).max(p[a] - max[a])).fold(0.0, f32::max);
        let nearest = (0..POINTS).map(point).min_by(|p, q| away(p).total_cmp(&away(q)));
        for (a, p) in nearest.into_iter().flatten().enumerate() {
            min[a] = min[a].min(p);
            max[a] = max[a].max(p);
        }
    }
    [min, max]
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::SimdLevel;

    use super::*;
    use crate::builtin;
    use crate::dataset::{Split, View};
    use crate::trainer::pixels::rays::Backdrop;

    /// No camera looks under the board of the built-in scene; its silhouettes
    /// allow a depth of 2.
    #[test]
    fn the_box_ends_where_the_scene_does() {
        let dataset = builtin::dataset(Split::Train, 8);
        let simd = SimdLevel::detect();
        let trainer = Trainer::with_prepass(dataset, TrainConfig::hash_grid(), simd).unwrap();
        let Space::Box { min, max } = trainer.model().space else { unreachable!() };
        println!("{min:?} {max:?}");
        // The board, and the highest flower.
        for a in 0..2 {
            assert!(min[a] <= -0.84 && max[a] >= 0.84);
        }
        assert!(min[2] <= -0.72 && max[2] >= 0.95);
        assert!((0..3).all(|a| max[a] - min[a] < 2.1));
        assert_eq!(trainer.config().aabb, Some([min, max]));
    }

    #[test]
    fn an_opaque_pixel_makes_the_box_grow() {
        // From z = 4 down, 90 degrees wide, 8x8 pixels. Pixel (3, 4), the 35th and one
        // of those that are looked at, goes left by 0.125 a unit of depth and down by
        // as much; the box lies to the right.
        let pose = Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0]);
        let camera = Camera::from_fov_x(8, 8, core::f32::consts::FRAC_PI_2, pose);
        let mut rgba = vec![0; 4 * 64];
        rgba[4 * 35 + 3] = 255;
        let view = View::new("", camera, rgba);
        let source = RaySource::new(vec![view], Backdrop::Random);
        let around = Space::Box { min: [-4.0; 3], max: [4.0; 3] };
        let (min, max) = ([0.5, -0.1, -0.1], [0.7, 0.1, 0.1]);
        let [low, high] = explaining(&source, around, min, max);
        let ray = camera.ray(3.5, 4.5);
        assert!(Space::Box { min: low, max: high }.intersect(&ray, 0.0, 99.0).is_some());
        assert!((0..3).all(|a| low[a] <= min[a] && high[a] >= max[a]));
        assert!(low != min);
        // What is met already asks for nothing.
        assert_eq!(explaining(&source, around, low, high), [low, high]);
    }
}
