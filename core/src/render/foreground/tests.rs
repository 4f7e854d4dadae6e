extern crate std;
use std::vec;
use std::vec::Vec;

use fearless_simd::dispatch;

use super::*;
use crate::SimdLevel;
use crate::march::{LANES, Marcher, RayPacket};
use crate::reference::testing::{SceneBuilder, kinds};
use crate::render::source::{Pixels, Source};

/// A model in [-1, 1]³ with these cells.
fn model<'a>(occupancy: Occupancy<'a>) -> Model<'a> {
    let mut scene = SceneBuilder::new(&kinds()[0], [0.0; 3], [0.0; 3]);
    scene.sampling.step = 0.01;
    (scene.sampling.near, scene.sampling.far) = (0.0, 100.0);
    Model { occupancy: Some(occupancy), ..scene.build() }
}

/// One occupied cell of 16³: (8, 8, 8), at [0, 1/8]³ of the scene.
fn one_cell() -> (Vec<u8>, Vec<u8>) {
    let (mut coarse, mut fine) = (vec![0; 16], vec![0; 64]);
    (coarse[14], fine[0]) = (1, 1);
    (coarse, fine)
}

/// 4 units away along z, 64 pixels wide, a focal length of 64 pixels.
fn in_front() -> Camera {
    let pose = Camera::look_at([0.0, 0.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0]);
    let camera = Camera::from_fov_x(64, 64, 1.0, pose);
    Camera { focal: [64.0; 2], ..camera }
}

const WHOLE: Tile = Tile { x: 0, y: 0, width: 64, height: 64 };

#[test]
fn one_cell_by_hand() {
    let (coarse, fine) = one_cell();
    let model = model(Occupancy::new(16, 1, &coarse, &fine).unwrap());
    let mut memory = [0.0; 256];
    let foreground = Foreground::of(&model, &in_front(), WHOLE, 1, &mut memory);
    assert!(foreground.is_known());
    assert_eq!(foreground.axis, [0.0, 0.0, -1.0]);
    // Cast is half a block, [0, 1/2]³, whose nearest face is 3.5 units away: pixels 32
    // to 32 + 64 / 7 = 41.1 to the right, as many upwards, and a little more: squares
    // of four pixels from 28 to 43 and from 20 to 31.
    for y in 0..64 {
        for x in 0..64 {
            let depth = foreground.depth([x, y]);
            if (28..44).contains(&x) && (20..32).contains(&y) {
                assert!((3.49..3.5).contains(&depth), "{x} {y}: {depth}");
            } else {
                assert_eq!(depth, f32::INFINITY, "{x} {y}");
            }
        }
    }
    // From the other side, nothing is in front of the camera.
    let pose = Camera::look_at([0.0, 0.0, 4.0], [0.0, 0.0, 8.0], [0.0, 1.0, 0.0]);
    let away = Camera { camera_to_world: pose, ..in_front() };
    let foreground = Foreground::of(&model, &away, WHOLE, 1, &mut memory);
    assert!(foreground.is_known() && foreground.depths.iter().all(|d| *d == f32::INFINITY));
}

#[test]
fn where_nothing_is_known_anything_may_be() {
    let (coarse, fine) = one_cell();
    let model = model(Occupancy::new(16, 1, &coarse, &fine).unwrap());
    let camera = in_front();
    let mut memory = [7.0; 256];
    let mut unknown = |model: &Model<'_>, camera: &Camera, tile, spacing| {
        let foreground = Foreground::of(model, camera, tile, spacing, &mut memory);
        assert!(!foreground.is_known() && foreground.depth([3, 5]) == 0.0);
    };
    unknown(&Model { occupancy: None, ..model }, &camera, WHOLE, 1);
    unknown(&model, &camera, Tile { height: 31, ..WHOLE }, 1);
    unknown(&model, &camera, WHOLE, 2);
    // Poses and lenses without a picture.
    for scale in [0.0, 1e-30, f32::NAN, f32::INFINITY] {
        let pose = camera.camera_to_world.map(|v| v * scale);
        unknown(&model, &Camera { camera_to_world: pose, ..camera }, WHOLE, 1);
    }
    unknown(&model, &Camera { focal: [f32::NAN; 2], ..camera }, WHOLE, 1);
    unknown(&model, &Camera { center: [f32::INFINITY; 2], ..camera }, WHOLE, 1);
}

/// Deterministic, 0 to 1.
fn random(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*state >> 8) as f32 / (1 << 24) as f32
}

/// Some blocks with some cells.
fn random_cells(state: &mut u32, resolution: u32) -> (Vec<u8>, Vec<u8>) {
    let mut coarse = vec![0u8; (resolution / BLOCK).pow(3) as usize * 2];
    let mut fine = Vec::new();
    for block in coarse.as_chunks_mut::<2>().0 {
        if random(state) < 0.03 {
            fine.push([0u8; BLOCK_BYTES].map(|_| 1u8 << ((random(state) * 7.99) as u32)));
            *block = (fine.len() as u16).to_le_bytes();
        }
    }
    (coarse, fine.into_flattened())
}

/// Near and far, within the scene and far from it, of every focal length.
fn random_camera(state: &mut u32) -> Camera {
    let mut around = |size: f32| [0; 3].map(|_| (random(state) * 2.0 - 1.0) * size);
    let (eye, target, up) = (around(1.0), around(0.7), around(1.0));
    let distance = [0.3, 1.0, 4.0, 30.0, 3000.0][(random(state) * 4.99) as usize];
    let mut pose = Camera::look_at(eye.map(|e| e * distance), target, up);
    // Not all poses are rotations.
    let scale = [1.0, 1.0, 0.01, 50.0][(random(state) * 3.99) as usize];
    for row in pose.chunks_mut(4) {
        row[..3].iter_mut().for_each(|v| *v *= scale);
        row[1] *= 1.0 + 0.3 * random(state);
    }
    let focal = 30.0 * (1.0 + distance) * (0.2 + random(state));
    let mirrored = if random(state) < 0.2 { -1.0 } else { 1.0 };
    Camera {
        width: 200,
        height: 150,
        focal: [focal * mirrored, focal * (0.7 + random(state))],
        center: [random(state) * 200.0, random(state) * 150.0],
        camera_to_world: pose,
    }
}

#[test]
fn no_sample_lies_in_front_of_it() {
    let mut state = 3;
    let (mut moved, mut nothing, mut found) = (0, 0, 0);
    for case in 0..240 {
        let resolution = [16, 40, 64, 128][case % 4];
        let (coarse, fine) = random_cells(&mut state, resolution);
        let occupancy = Occupancy::new(resolution, 1, &coarse, &fine).unwrap();
        let mut table = vec![0; occupancy.table_len()];
        occupancy.write_table(&mut table).unwrap();
        let tabled = occupancy.with_table(&table).unwrap();
        let mut model = model(if case % 3 == 0 { occupancy } else { tabled });
        model.sampling.far = 4000.0;
        let camera = random_camera(&mut state);
        let [x, y] = [0, 0].map(|_| (random(&mut state) * 120.0) as u32);
        let tile = Tile { x, y, width: 40 + x % 60, height: 64 };
        let mut memory = vec![0.0; [16, 200, 512][case % 3]];
        let foreground = Foreground::of(&model, &camera, tile, 1, &mut memory);
        assert!(foreground.is_known());
        let (source, marcher) = (Pixels { camera: &camera, tile }, Marcher::new(&model, true));
        let numbers: Vec<u32> = (0..tile.width * tile.height).step_by(5).collect();
        for numbers in numbers.chunks_exact(LANES) {
            let depths: [f32; LANES] = core::array::from_fn(|lane| {
                foreground.depth([numbers[lane] % tile.width, numbers[lane] / tile.width])
            });
            dispatch!(SimdLevel::detect().token().unwrap(), simd => {
                let mut packet = RayPacket::EMPTY;
                source.fill(simd, numbers, &mut packet);
                marcher.enter(simd, &mut packet);
                let mut with = packet;
                marcher.begin_at(simd, &mut with, &depths, foreground.axis);
                for (from, to) in packet.next.iter().zip(&with.next) {
                    moved += usize::from(to > from);
                }
                marcher.seek(simd, &mut packet);
                marcher.seek(simd, &mut with);
                for (lane, depth) in depths.into_iter().enumerate() {
                    let first = |packet: &RayPacket| {
                        (packet.next[lane] < packet.end[lane]).then_some(packet.next[lane])
                    };
                    assert_eq!(first(&with), first(&packet), "case {case} pixel {}", numbers[lane]);
                    nothing += usize::from(depth == f32::INFINITY);
                    found += usize::from(first(&packet).is_some());
                }
            });
        }
    }
    assert!(found > 5000 && moved > 5000 && nothing > 5000, "{found} {moved} {nothing}");
}
