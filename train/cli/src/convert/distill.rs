//! Pictures of a model, to train another one on.

use pocketnerf_core::field::Shading;
use pocketnerf_core::{Camera, ColorSpace, Display, Error, Space, math, pixel};
use pocketnerf_train::dataset::{Dataset, Split, View};
use pocketnerf_train::lens::Lens;
use pocketnerf_train::picture::Painter;
use pocketnerf_train::trainer::{Length, TrainConfig};

/// Most bytes of cells and metadata beside tables and networks.
const CELLS: usize = 400_000;
/// log2 of the fewest entries per grid level.
const LEAST_TABLE: u32 = 10;
/// Views to train on if no cameras are given.
const VIEWS: usize = 100;
/// Views from which a distilled model and its source are compared.
const OTHERS: usize = 7;
/// Cameras of the source that are enough to see all of a scene; every eighth is held out.
const ENOUGH: usize = 24;
/// Their width and height.
const SIDE: u32 = 256;
/// Their horizontal field of view, radians, for views from outside.
const FOV_X: f32 = 0.7;
/// Azimuth between one view and the next: the golden angle spreads them evenly.
const TURN: f32 = 2.399_963_2;

/// Cameras to train on, and others to compare on: the source's own, if they are enough to see
/// all of the scene; else those and more like them; without any, some at `distance` all around.
/// `None` for forward-facing scenes of which too few are known.
#[must_use]
pub fn cameras(space: &Space, own: &[Camera], distance: f32) -> Option<[Vec<Camera>; 2]> {
    if own.len() >= ENOUGH {
        return Some(held_out(own));
    }
    let around = |count| match own {
        [] => all_around(space, distance, count),
        own => all_around_like(space, own, count),
    };
    Some([[own, &around(VIEWS)?].concat(), around(OTHERS)?])
}

/// `count` cameras evenly all around a box, at `distance` from its middle, or farther if
/// needed to see all of it; `None` for other spaces, whose cameras are known.
fn all_around(space: &Space, distance: f32, count: usize) -> Option<Vec<Camera>> {
    let [min, max] = space.scene_box()?;
    let radius = 0.5 * (0..3).map(|a| (max[a] - min[a]).powi(2)).sum::<f32>().sqrt();
    let distance = distance.max(radius / (0.5 * FOV_X).sin());
    Some(around(space.center(), distance, FOV_X, count))
}

/// `count` cameras evenly all around a box, with the mean distance and field of view of
/// `others`; `None` if there are none, and for other spaces.
fn all_around_like(space: &Space, others: &[Camera], count: usize) -> Option<Vec<Camera>> {
    space.scene_box()?;
    let center = space.center();
    let distance = |camera: &Camera| {
        let p = camera.position();
        (0..3).map(|a| (p[a] - center[a]).powi(2)).sum::<f32>().sqrt()
    };
    let fov_x = |camera: &Camera| 2.0 * (0.5 * camera.width as f32 / camera.focal[0]).atan();
    let mean =
        |of: &dyn Fn(&Camera) -> f32| others.iter().map(of).sum::<f32>() / others.len() as f32;
    (!others.is_empty()).then(|| around(center, mean(&distance), mean(&fov_x), count))
}

fn around(center: [f32; 3], distance: f32, fov_x: f32, count: usize) -> Vec<Camera> {
    let camera = |i: usize| {
        let z = 1.0 - (2 * i + 1) as f32 / count as f32;
        let ring = (1.0 - z * z).sqrt();
        let (sin, cos) = math::sin_cos(i as f32 * TURN);
        let away = [ring * cos, ring * sin, z];
        let eye = [0, 1, 2].map(|a| center[a] + distance * away[a]);
        let pose = Camera::look_at(eye, center, [0.0, 0.0, 1.0]);
        Camera::from_fov_x(SIDE, SIDE, fov_x, pose)
    };
    (0..count).map(camera).collect()
}

/// Cameras to train on, and every eighth, held out; downscaled to the size of our own views.
fn held_out(cameras: &[Camera]) -> [Vec<Camera>; 2] {
    let small =
        |camera: &Camera| camera.downscaled(camera.width.max(camera.height).div_ceil(2 * SIDE));
    let numbered = || cameras.iter().enumerate();
    let of = |held: bool| {
        numbered().filter(|(i, _)| (i % 8 == 0) == held).map(|(_, camera)| small(camera)).collect()
    };
    [of(false), of(true)]
}

/// Takes pictures for these cameras, to train on: transparent if the space is a box, else over the
/// background. In sRGB, as images are.
///
/// # Errors
/// Whatever rendering reports.
pub fn views(
    painter: &mut dyn Painter,
    (space, display): (&Space, &Display),
    cameras: &[Camera],
    mut rendered: impl FnMut(usize),
) -> Result<Dataset, Error> {
    let transparent = space.scene_box().is_some();
    let mut views = Vec::new();
    for (i, camera) in cameras.iter().enumerate() {
        let picture = painter.paint(camera, &Lens::Pinhole)?;
        let rgba = match transparent {
            true => straight(&picture.rgba, display.color_space),
            false => opaque(&picture.rgba, display),
        };
        views.push(View::new(format!("view {i}"), *camera, rgba));
        rendered(i + 1);
    }
    let dataset = Dataset::new("distilled", "rendered", Split::Train, views);
    Ok(Dataset { background: Some(display.srgb_background()), ..dataset })
}

/// Settings to train a hash grid on such views whose file has at most `bytes`; `None` if no
/// grid is that small.
#[must_use]
pub fn config(
    space: &Space,
    shading: Shading,
    bytes: usize,
    length: Length,
) -> Option<TrainConfig> {
    let mut config = TrainConfig::hash_grid().for_length(length);
    config.field.hash_grid_mut()?.shading = shading;
    match *space {
        Space::Ndc(ndc) => config.ndc = Some(ndc),
        Space::Contracted(contracted) => config = config.contracted(contracted, length),
        ref space => config.aabb = space.scene_box(),
    }
    loop {
        let layout = config.field.kind().layout();
        let [tables, all] = [layout.networks_start(), layout.len()];
        // Smaller cells take an eighth of the parameters at most.
        if all + all / 8 + (all - tables) + CELLS <= bytes {
            return Some(config);
        }
        let grid = &mut config.field.hash_grid_mut()?.grid;
        if grid.log2_hashmap_size <= LEAST_TABLE {
            return None;
        }
        grid.log2_hashmap_size -= 1;
    }
}

/// RGBA, not premultiplied.
fn straight(rgba: &[f32], space: ColorSpace) -> Vec<u8> {
    let pixels = rgba.as_chunks::<4>().0.iter();
    pixels.flat_map(|rgba| pixel::rgba8(pixel::straight(*rgba), space)).collect()
}

/// RGBA over the background.
fn opaque(rgba: &[f32], display: &Display) -> Vec<u8> {
    let pixels = rgba.as_chunks::<4>().0.iter().map(|rgba| display.rgb8(*rgba));
    pixels.flat_map(|[r, g, b]| [r, g, b, 255]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_all_around() {
        let space = Space::Box { min: [1.0, -1.0, -1.0], max: [3.0, 1.0, 1.0] };
        let cameras = all_around(&space, 0.0, 50).unwrap();
        // Half the diagonal fills the view: √3 / sin 0.35.
        let far = 3.0f32.sqrt() / 0.35f32.sin();
        let mut mean = [0.0; 3];
        for camera in &cameras {
            let p = camera.position();
            let distance = ((p[0] - 2.0).powi(2) + p[1].powi(2) + p[2].powi(2)).sqrt();
            assert!((distance - far).abs() < 1e-3);
            let axis = camera.axis();
            assert!((p[0] + far * axis[0] - 2.0).abs() < 1e-3);
            (0..3).for_each(|a| mean[a] += p[a] / 50.0);
        }
        assert!((mean[0] - 2.0).abs() < 0.1 && mean[1].abs() < 0.1 && mean[2].abs() < 0.1);
        assert_eq!(all_around(&space, 9.0, 1).unwrap().len(), 1);
        // Those like some are as far away, and see as much.
        let like = all_around_like(&space, &cameras[..5], 20).unwrap();
        assert_eq!(like.len(), 20);
        let p = like[15].position();
        let distance = ((p[0] - 2.0).powi(2) + p[1].powi(2) + p[2].powi(2)).sqrt();
        assert!((distance - far).abs() < 1e-3);
        assert!((like[15].focal[0] - cameras[0].focal[0]).abs() < 1e-2);
        assert!(all_around_like(&space, &[], 20).is_none());
    }

    #[test]
    fn no_camera_is_trained_on_and_compared_on() {
        let space = Space::Box { min: [-1.0; 3], max: [1.0; 3] };
        let all = all_around(&space, 4.0, 40).unwrap();
        for (own, expected) in [(0, [100, 7]), (5, [105, 7]), (23, [123, 7]), (40, [35, 5])] {
            let own = &all[..own];
            let [trained, compared] = cameras(&space, own, 4.0).unwrap();
            assert_eq!([trained.len(), compared.len()], expected);
            assert!(compared.iter().all(|camera| !trained.contains(camera)));
            // All of a few are worth training on.
            assert!(own.len() >= ENOUGH || trained[..own.len()] == *own);
        }
        let (min, max) = ([-1.0; 3], [1.0; 3]);
        let forward =
            Space::Ndc(pocketnerf_core::space::Ndc { near: 1.0, slope: [1.0; 2], min, max });
        assert!(cameras(&forward, &all[..5], 4.0).is_none());
    }
}
