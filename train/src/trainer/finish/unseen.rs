//! Cells that no photograph sees: they become empty.
//!
//! Training never samples what surfaces hide from all its cameras, so whatever the field has there
//! is made up, and other cameras may see it: fog below a table that is photographed from above.
//! Plenoxels (Fridovich-Keil et al. 2022, section 3.4) keep the cells that weigh something in a
//! training ray; here light that reaches them is enough, because fog and glass weigh little.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use fearless_simd::dispatch;
use pocketnerf_core::march::Marcher;
use pocketnerf_core::{Camera, Error};
use rayon::prelude::*;

use crate::pool::Pool;
use crate::random::Random;
use crate::trainer::Trainer;
use crate::trainer::occupancy::cells::Packed;
use crate::trainer::pixels::rays::{Pixel, TrainingRay};
use crate::trainer::step::group::{Group, Job, Worker};

/// Rays of all photographs together at most, about.
const RAYS: usize = 1 << 21;
/// A rehearsal takes one ray in so many, about.
const REHEARSED: usize = 64;
/// Rays of a task.
const TASK: usize = 1 << 12;
/// Distinguishes these random numbers from others of the same seed.
const STREAM: u64 = 8;
/// A sample is seen that so much of the light of a ray reaches.
const LIGHT: f32 = 0.1;

/// A point of a view.
#[derive(Clone, Copy, Debug)]
struct Point {
    pixel: Pixel,
    /// Pixels from the left and the top.
    at: [f32; 2],
}

impl Trainer {
    /// Whether photographs leave much unseen that is better empty: they are few, and show what is
    /// behind the scene. From 50 on nothing is gained, and in a room a hole is worse than a
    /// wall that is made up.
    pub(super) fn hides_much(&self) -> bool {
        let is_costly = self.config.field.kind().is_costly();
        self.source.has_few_views() && self.has_silhouettes && !is_costly
    }

    /// Those of a finished model's cells that a photograph sees, by cells as wide as training's.
    ///
    /// # Errors
    /// When the SIMD level is not there.
    pub(super) fn seen_cells(&self, cells: Packed) -> Result<Packed, Error> {
        let points = self.points(RAYS);
        let n = self.config.occupancy_resolution;
        let seen = self.seen_by(&points, &cells)?;
        let view = cells.view();
        let wider = view.resolution() / n;
        let is_seen = |[x, y, z]: [u32; 3]| {
            let [x, y, z] = [x, y, z].map(|c| c / wider);
            seen[(x + n * (y + n * z)) as usize].load(Ordering::Relaxed)
        };
        Ok(cells.only(is_seen))
    }

    /// Seconds that this would take now, from a few of the rays; 0 where it is not done.
    ///
    /// # Errors
    /// As [`seen_cells`](Self::seen_cells).
    pub(super) fn rehearse_seen_cells(&self, cells: &Packed) -> Result<f64, Error> {
        if !self.hides_much() {
            return Ok(0.0);
        }
        let clock = Instant::now();
        let all = self.points(RAYS).len() as f64;
        let listed = clock.elapsed().as_secs_f64();
        let few = self.points(RAYS / REHEARSED);
        let clock = Instant::now();
        self.seen_by(&few, cells)?;
        Ok(listed + clock.elapsed().as_secs_f64() * all / few.len().max(1) as f64)
    }

    /// Points of the pixels that may be drawn, about two to a cell along both sides, but at most
    /// about so many of all. A pixel that is wider than a cell sees all that lies in it.
    fn points(&self, most: usize) -> Vec<Point> {
        let cameras = self.source.cameras();
        let [min, max] = self.space.bounds().map(glam::Vec3::from);
        let side = 1.0 / (self.space.unit_map().scale * self.config.occupancy_resolution as f32);
        // Pixels from one point to the next.
        let apart = |camera: &Camera| {
            let distance = (0.5 * (min + max)).distance(camera.position().into());
            0.5 * side * camera.focal[0] / distance.max(side)
        };
        let of =
            |c: &Camera| f64::from(c.width) * f64::from(c.height) / f64::from(apart(c)).powi(2);
        let all = self.visibility.share() * cameras.iter().map(of).sum::<f64>();
        let rarer = (all / most as f64).sqrt().max(1.0) as f32;
        let of_view = |(view, camera): (usize, &Camera)| {
            let apart = rarer * apart(camera);
            let every = apart.round().max(1.0) as u32;
            let within = apart.recip().round().max(1.0) as u32;
            let along = move |pixels: u32| (every / 2..pixels).step_by(every as usize);
            let pixels = along(camera.height)
                .flat_map(move |y| along(camera.width).map(move |x| (x, y)))
                .map(move |(x, y)| Pixel { view: view as u32, x, y });
            let at = move |c: u32, i: u32| c as f32 + (i as f32 + 0.5) / within as f32;
            let points = pixels.filter(|pixel| self.visibility.draws(*pixel)).flat_map(|pixel| {
                let parts = (0..within).flat_map(move |j| (0..within).map(move |i| [i, j]));
                parts.map(move |[i, j]| Point { pixel, at: [at(pixel.x, i), at(pixel.y, j)] })
            });
            points.collect::<Vec<_>>()
        };
        cameras.par_iter().enumerate().flat_map_iter(of_view).collect()
    }

    /// Which of training's cells the light of the rays through these points reaches.
    fn seen_by(&self, points: &[Point], cells: &Packed) -> Result<Vec<AtomicBool>, Error> {
        let (field, level) = (self.backend.field(), self.backend.simd().token()?);
        let n = self.config.occupancy_resolution;
        let seen: Vec<AtomicBool> = (0..n.pow(3)).map(|_| AtomicBool::new(false)).collect();
        let sampling = self.sampling;
        let job = Job {
            marcher: Marcher::from_parts(Some(cells.view()), self.space, sampling, true),
            step: sampling.step,
            // Longer ones would miss cells.
            coarse_step_below: 0.0,
            roulette: 0.0,
            hierarchical: None,
            space: self.space,
            reach: [sampling.near, sampling.far],
            terms: &[],
            cameras: None,
            few_cameras: None,
            smooth_surfaces: 0.0,
            slow_below: None,
            n_photographs: u32::MAX,
            evened_out: 0,
            poses: None,
            stopwatch: None,
        };
        let memory = || (Group::default(), Worker::new(field.limits()));
        let buffers = Pool::default();
        points.par_chunks(TASK).enumerate().for_each(|(task, points)| {
            let mut buffer = buffers.lease(memory);
            let (group, worker) = &mut *buffer;
            let mut random = Random::new(self.seed, [STREAM, task as u64, 0]);
            let ray = |point: &Point| TrainingRay {
                ray: self.source.through_point(point.pixel.view, point.at),
                ..self.source.ray(point.pixel, [0; 4], (0, 1.0), &mut random)
            };
            group.rays.clear();
            group.rays.extend(points.iter().map(ray));
            dispatch!(level, simd => group.march(simd, &field, &job, worker));
            let along = |unit: f32| ((unit * n as f32) as u32).min(n - 1);
            for record in group.lit(LIGHT) {
                let [x, y, z] = record.point.map(along);
                seen[(x + n * (y + n * z)) as usize].store(true, Ordering::Relaxed);
            }
        });
        Ok(seen)
    }
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::{Model, Probe, SimdLevel, Tuning};

    use super::*;
    use crate::builtin;
    use crate::dataset::Split;
    use crate::trainer::{StepSettings, TrainConfig};

    #[test]
    fn what_is_emptied_is_dark_from_all_cameras() {
        let mut config = TrainConfig::hash_grid();
        let grid = &mut config.field.hash_grid_mut().unwrap().grid;
        (grid.n_levels, grid.log2_hashmap_size) = (4, 12);
        config.aabb = Some([[-1.4; 3], [1.4; 3]]);
        (config.samples_per_step, config.occupancy_resolution) = (4096, 32);
        let simd = SimdLevel::detect();
        let mut dataset = builtin::dataset(Split::Train, 8);
        dataset.thin(12);
        let mut trainer = Trainer::with_prepass(dataset, config, simd).unwrap();
        assert!(trainer.hides_much());
        let settings = StepSettings { update_occupancy: true, ..StepSettings::PLAIN };
        (0..300).for_each(|_| _ = trainer.step(&settings));
        let all = trainer.grid.occupied().clone();
        let some = trainer.seen_cells(all.clone()).unwrap();
        // How much light passes from each camera to the middle of each cell, as core finds it.
        let model = Model { occupancy: Some(all.view()), ..trainer.model() };
        let probe = Probe::new(&model, simd, Tuning::FAST).unwrap();
        let mut scratch = vec![0.0; probe.scratch_len()];
        let (n, map) = (32, model.space.unit_map());
        let mut light = |cell: [u32; 3]| {
            let middle =
                |axis: usize| map.min[axis] + (cell[axis] as f32 + 0.5) / (n as f32 * map.scale);
            let to = [0, 1, 2].map(middle);
            let cameras = trainer.source.cameras().iter();
            let segments: Vec<_> = cameras.map(|camera| [camera.position(), to]).collect();
            let mut out = vec![0.0; segments.len()];
            probe.segment_transmittance(&segments, &mut scratch, &mut out).unwrap();
            out.into_iter().fold(0.0, f32::max)
        };
        let cells = (0..n * n * n).map(|i| [i % n, i / n % n, i / (n * n)]);
        let (mut kept, mut emptied) = (Vec::new(), Vec::new());
        for cell in cells.filter(|[x, y, z]| all.view().cell(*x, *y, *z)) {
            let [x, y, z] = cell;
            let side = if some.view().cell(x, y, z) { &mut kept } else { &mut emptied };
            side.push(light(cell));
        }
        let lit = |side: &[f32]| {
            side.iter().filter(|light| **light > LIGHT).count() as f64 / side.len() as f64
        };
        println!(
            "{} kept, {:.3} lit; {} emptied, {:.3} lit",
            kept.len(),
            lit(&kept),
            emptied.len(),
            lit(&emptied)
        );
        assert!(emptied.len() > 100 && kept.len() > 1000);
        // A cell's face may be lit where its middle is not, but hardly the reverse.
        assert!(lit(&emptied) < 0.02 && lit(&kept) > 0.5);
        // Many photographs, or none with silhouettes, leave all as it is.
        trainer.has_silhouettes = false;
        assert!(!trainer.hides_much());
    }
}
