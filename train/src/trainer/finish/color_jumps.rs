//! Colours that jump between the training views.
//!
//! A colour network that has learnt a highlight may show it from directions that no photograph
//! has, where there is none: a unit that is silent for all training directions of a point
//! switches on between two of them. Training does not see that, and held-out views only if one
//! of them looks from there. What a model risks can be measured without any photograph.

use pocketnerf_core::render::render_rays;
use pocketnerf_core::{Error, Model, Probe, Ray, RenderOptions, SimdLevel, Tuning};
use rayon::prelude::*;

use crate::random::Random;
use crate::trainer::pixels::neighbours::{FEWEST, reach, turn};
use crate::trainer::pixels::rays::RaySource;

/// Rays that are looked at.
const RAYS: usize = 1 << 17;
/// Rays of a task.
const TASK: usize = 1 << 10;
/// Distinguishes these random numbers from others of the same seed.
const STREAM: u64 = 6;
/// Rays of less opacity meet no surface.
const OPAQUE: f32 = 0.9;
/// Change of a channel that is a jump.
const JUMP: f32 = 0.4;

/// Share of the surface points seen by training rays whose colour jumps when their direction
/// turns to one between the training views. `None` for models without a density a length, and
/// where there are too few cameras or points to tell.
pub fn share(
    model: &Model<'_>,
    source: &RaySource,
    simd: SimdLevel,
    seed: u64,
) -> Result<Option<f64>, Error> {
    if model.space.scene_box().is_none() || source.cameras().len() < FEWEST {
        return Ok(None);
    }
    let tasks = (0..RAYS / TASK).into_par_iter();
    let counts =
        tasks.map(|task| count(model, source, simd, Random::new(seed, [STREAM, task as u64, 0])));
    let [jumps, points] = counts.try_reduce(|| [0; 2], |a, b| Ok([a[0] + b[0], a[1] + b[1]]))?;
    Ok((points > 0).then(|| jumps as f64 / points as f64))
}

/// Jumps and points of a task.
fn count(
    model: &Model<'_>,
    source: &RaySource,
    simd: SimdLevel,
    mut random: Random,
) -> Result<[usize; 2], Error> {
    let options = RenderOptions::new(model, simd, Tuning::FAST);
    let mut scratch = vec![0.0; options.scratch_len()];
    let rays: Vec<Ray> = (0..TASK).map(|_| source.draw_anywhere(false, &mut random).ray).collect();
    let (mut rgba, mut depth) = (vec![0.0; 4 * TASK], vec![0.0; TASK]);
    render_rays(model, &rays, &options, &mut scratch, &mut rgba, Some(&mut depth))?;
    let (mut points, mut directions, mut turned) = (Vec::new(), Vec::new(), Vec::new());
    for ((ray, rgba), depth) in rays.iter().zip(rgba.as_chunks::<4>().0).zip(depth) {
        if rgba[3] > OPAQUE {
            let (origin, direction) =
                (glam::Vec3::from(ray.origin), glam::Vec3::from(ray.direction));
            let direction = direction.normalize();
            let point = origin + depth * direction;
            points.push(point.to_array());
            directions.push(direction.to_array());
            let reach = reach(source.cameras(), point, direction);
            turned.push(turn(direction, reach, &mut random).to_array());
        }
    }
    let probe = Probe::new(model, simd, Tuning::FAST)?;
    let mut colors = [directions, turned].into_iter().map(|directions| {
        let mut out = vec![[0.0; 4]; points.len()];
        probe.radiance(&points, &directions, &mut scratch, &mut out).map(|()| out)
    });
    let (Some(seen), Some(between)) = (colors.next(), colors.next()) else { return Ok([0; 2]) };
    let (seen, between) = (seen?, between?);
    let jumps = |(a, b): &(&[f32; 4], &[f32; 4])| (0..3).any(|c| (a[c] - b[c]).abs() > JUMP);
    let jumps = seen.iter().zip(&between).filter(jumps).count();
    Ok([jumps, points.len()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use crate::dataset::Split;
    use crate::trainer::{StepSettings, TrainConfig, Trainer};

    #[test]
    fn a_sharp_edge_in_direction_is_found() {
        let mut config = TrainConfig::hash_grid();
        let field = config.field.hash_grid_mut().unwrap();
        (field.grid.n_levels, field.grid.log2_hashmap_size) = (4, 12);
        (field.density_hidden, field.color_hidden) = (vec![16], vec![]);
        config.aabb = Some([[-1.4; 3], [1.4; 3]]);
        (config.samples_per_step, config.occupancy_resolution) = (4096, 32);
        let simd = SimdLevel::detect();
        let mut trainer =
            Trainer::with_prepass(builtin::dataset(Split::Train, 8), config, simd).unwrap();
        for _ in 0..300 {
            trainer.step(&StepSettings { update_occupancy: true, ..StepSettings::PLAIN });
        }
        let found = |trainer: &Trainer| share(&trainer.model(), &trainer.source, simd, 1).unwrap();
        assert_eq!(found(&trainer), Some(0.0));
        // Red is 0 on one side of x = 0 and 1 on the other: the third harmonic is -0.49 x, and
        // the network's one layer ends with its row of weights for that and the rest.
        let mut state = trainer.backend.download().clone();
        let parameters = &mut state.field_mut().parameters;
        let colors = parameters.len() - 3;
        parameters[colors - 3 * (16 - 3)] = 1e4;
        trainer.backend.upload(state);
        // Directions within half a radian of that edge cross it, some of them.
        let share = found(&trainer).unwrap();
        assert!((0.005..0.2).contains(&share), "{share}");
    }
}
