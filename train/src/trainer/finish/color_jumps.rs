//! Colours that jump between the training views.
//!
//! A colour network that has learnt a highlight may show it from directions that no photograph
//! has, where there is none: a unit that is silent for all training directions of a point
//! switches on between two of them. Training does not see that, and held-out views only if one
//! of them looks from there. What a model risks can be measured without any photograph.

use pocketnerf_core::render::render_rays;
use pocketnerf_core::{Error, Model, Probe, Ray, RenderOptions, SimdLevel, Tuning};
use rayon::prelude::*;

use crate::random::{Random, normal};
use crate::trainer::pixels::rays::RaySource;

/// Rays that are looked at.
const RAYS: usize = 1 << 17;
/// Rays of a task.
const TASK: usize = 1 << 10;
/// Distinguishes these random numbers from others of the same seed.
const STREAM: u64 = 6;
/// Rays of less opacity meet no surface.
const OPAQUE: f32 = 0.9;
/// Directions turn within the angle to the camera that is so many-th nearest, seen from the
/// point: such directions lie between training views.
const NEIGHBOUR: usize = 4;
/// They turn by no more than this, radians.
const MOST: f32 = 0.5;
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
    if model.space.scene_box().is_none() || source.cameras().len() <= NEIGHBOUR {
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
            turned.push(turn(direction, reach(source, point, direction), &mut random).to_array());
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

/// The angle within which a direction may turn at a point.
fn reach(source: &RaySource, point: glam::Vec3, direction: glam::Vec3) -> f32 {
    let cosine = |camera: &pocketnerf_core::Camera| {
        direction.dot((point - glam::Vec3::from(camera.position())).normalize_or_zero())
    };
    let mut cosines: Vec<f32> = source.cameras().iter().map(cosine).collect();
    // The first is the ray's own camera.
    let (_, nth, _) = cosines.select_nth_unstable_by(NEIGHBOUR, |a, b| b.total_cmp(a));
    nth.clamp(-1.0, 1.0).acos().min(MOST)
}

/// A direction turned any way by up to an angle.
fn turn(direction: glam::Vec3, reach: f32, random: &mut Random) -> glam::Vec3 {
    let any = glam::Vec3::new(normal(random), normal(random), normal(random));
    let across = any.reject_from_normalized(direction).normalize_or_zero();
    let angle = reach * random.next_f32();
    (direction * angle.cos() + across * angle.sin()).normalize()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use pocketnerf_core::Camera;

    use super::*;
    use crate::builtin;
    use crate::dataset::{Split, View};
    use crate::trainer::pixels::rays::Backdrop;
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

    #[test]
    fn directions_turn_as_far_as_neighbours_are() {
        // Cameras at 0, 10, 20, 30, 40 and 50 degrees around the origin.
        let at = |degrees: f32| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let pose = Camera::look_at([4.0 * cos, 4.0 * sin, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
            View::new("", Camera::from_fov_x(2, 2, 0.7, pose), vec![255; 16])
        };
        let views = (0..6).map(|i| at(10.0 * i as f32)).collect();
        let source = RaySource::new(views, Backdrop::Random);
        let towards =
            |degrees: f32| -Vec3::new(degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0);
        // Of the first, the fourth nearest is 40 degrees away, which is too far; of the third 20.
        assert_eq!(reach(&source, Vec3::ZERO, towards(0.0)), MOST);
        let middle = reach(&source, Vec3::ZERO, towards(20.0));
        assert!((middle.to_degrees() - 20.0).abs() < 0.1, "{middle}");
        let mut random = Random::new(1, [0; 3]);
        for _ in 0..100 {
            let turned = turn(Vec3::X, 0.3, &mut random);
            assert!(turned.is_normalized() && turned.angle_between(Vec3::X) < 0.3 + 1e-3);
        }
    }
}
