//! A small picture by the GPU, beside the same one by the CPU: drivers have faults.

use std::cmp::Ordering;

use pocketnerf_core::render::Detail;
use pocketnerf_core::{Camera, Model, RenderOptions, Space, Tile, render_tile};

use super::{Error, Renderer};

/// Pixels along a side of the picture.
const SIDE: u32 = 8;
/// Pictures are as like as that, dB: single samples at the walls of cells may differ, what is
/// miscomputed differs by 20 dB and less.
const LEAST: f32 = 40.0;

/// Compares them from the first place from which anything is seen.
pub(super) fn compare(
    renderer: &mut Renderer,
    model: &Model<'_>,
    options: &RenderOptions,
) -> Result<(), Error> {
    let options = RenderOptions { detail: Detail::FINEST, ..*options };
    let tile = Tile { x: 0, y: 0, width: SIDE, height: SIDE };
    let mut scratch = vec![0.0; options.scratch_len()];
    let mut expected = vec![0.0; 4 * tile.pixels()];
    for camera in cameras(&model.space) {
        render_tile(model, &camera, tile, &options, &mut scratch, &mut expected, None)?;
        let found = &renderer.render(&camera)?.rgba;
        let psnr = psnr(found, &expected);
        // NaN is not enough.
        if !matches!(psnr.partial_cmp(&LEAST), Some(Ordering::Greater)) {
            return Err(Error::Miscomputes(psnr, LEAST));
        }
        if expected.iter().any(|v| *v > 0.01) {
            break;
        }
    }
    Ok(())
}

/// From outside, and from the middle; where there is no outside, inwards, then outwards.
fn cameras(space: &Space) -> Vec<Camera> {
    let center = space.center();
    let camera = |eye: [f32; 3], target, fov| {
        Camera::from_fov_x(SIDE, SIDE, fov, Camera::look_at(eye, target, [0.0, 0.0, 1.0]))
    };
    let at = |share: f32, half: [f32; 3]| {
        [0, 1, 2].map(|a| center[a] + share * [1.0, 0.8, 0.6][a] * half[a])
    };
    if space.is_bent() {
        let at = |share: f32| at(share, [space.viewing_distance(); 3]);
        let [inwards, outwards] = [camera(at(0.9), center, 1.2), camera(center, at(-1.0), 1.5)];
        return vec![inwards, outwards, camera(center, at(1.0), 1.5)];
    }
    let Some([min, max]) = space.scene_box() else {
        // Normalised device coordinates: what looks forwards from the origin.
        let pose = Camera::look_at([0.0; 3], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]);
        return vec![Camera::from_fov_x(SIDE, SIDE, 1.0, pose)];
    };
    let half = [0, 1, 2].map(|a| 0.5 * (max[a] - min[a]));
    let at = |share: f32| at(share, half);
    vec![camera(at(2.5), center, 0.8), camera(at(1.2), center, 1.2), camera(center, at(-1.0), 1.5)]
}

/// PSNR of values from 0 to 1, dB; infinite where they are the same.
fn psnr(found: &[f32], expected: &[f32]) -> f32 {
    let squares = found.iter().zip(expected).map(|(a, b)| f64::from(a - b).powi(2));
    (-10.0 * (squares.sum::<f64>() / expected.len() as f64).log10()) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever space the still life is put into, a camera sees some of it.
    #[test]
    fn something_is_seen() {
        use pocketnerf_core::space::{Contracted, Ndc};
        use pocketnerf_core::{SimdLevel, Tuning};

        let bytes = include_bytes!("../../../../embed-demo/still-life.pnerf");
        let bytes = pocketnerf_formats::unpacked(bytes).unwrap();
        let file = pocketnerf_formats::open(&bytes).unwrap();
        let [min, max] = [[-1.0; 3], [1.0; 3]];
        let contracted = |center, radius| Space::Contracted(Contracted { center, radius });
        for space in [
            file.model.space,
            Space::Ndc(Ndc { near: 0.5, slope: [1.0; 2], min, max }),
            contracted([0.0; 3], 1.0),
            contracted([100.0, -30.0, 7.0], 25.0),
        ] {
            let model = Model { space, ..file.model };
            let options = RenderOptions::new(&model, SimdLevel::detect(), Tuning::FAST);
            let mut scratch = vec![0.0; options.scratch_len()];
            let tile = Tile { x: 0, y: 0, width: SIDE, height: SIDE };
            let mut rgba = vec![0.0; 4 * tile.pixels()];
            let is_seen = cameras(&space).iter().any(|camera| {
                let (scratch, rgba) = (&mut scratch, &mut rgba);
                render_tile(&model, camera, tile, &options, scratch, rgba, None).unwrap();
                rgba.iter().any(|v| *v > 0.01)
            });
            assert!(is_seen, "{space:?}");
        }
    }

    #[test]
    fn psnr_by_hand() {
        assert_eq!(psnr(&[0.1, 0.5], &[0.1, 0.4]).round(), 23.0);
        assert_eq!(psnr(&[0.5], &[0.5]), f32::INFINITY);
    }
}
