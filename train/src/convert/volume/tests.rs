use half::f16;
use pocketnerf_core::Ray;
use pocketnerf_formats::import::volume::Svox2;

use super::Volume;
use super::svox2::Voxels;

/// Rays through a cube from 0 to 1 and beside it.
fn rays() -> Vec<Ray> {
    let mut random = crate::random::Random::new(7, [0; 3]);
    let mut ray = || {
        let [a, b] =
            [3.0, 1.2].map(|side| [0, 1, 2].map(|_: i32| 0.5 + side * (random.next_f32() - 0.5)));
        let along = [0, 1, 2].map(|i: usize| b[i] - a[i]);
        let length = along.iter().map(|v| v * v).sum::<f32>().sqrt();
        Ray { origin: a, direction: along.map(|v| v / length) }
    };
    (0..500).map(|_| ray()).collect()
}

fn grid(links: Vec<i32>, sizes: [usize; 3], densities: Vec<f32>) -> Svox2 {
    let harmonics = vec![f16::from_f32(0.5); 3 * densities.len()];
    Svox2 { center: [0.5; 3], radius: [0.5; 3], sizes, links, densities, harmonics, n_harmonics: 1 }
}

fn traced(voxels: &Voxels, rays: &[Ray]) -> (Vec<[f32; 4]>, u64) {
    let mut pixels = vec![[0.0; 4]; rays.len()];
    let samples = voxels.trace(rays, &mut pixels);
    (pixels, samples)
}

#[test]
fn a_grid_of_one_density() {
    let whole = grid((0..64).collect(), [4; 3], vec![3.0; 64]);
    let middle = Ray { origin: [0.4, 0.6, -2.0], direction: [0.0, 0.0, 1.0] };
    let beside = Ray { origin: [1.4, 0.6, -2.0], direction: [0.0, 0.0, 1.0] };
    let (pixels, samples) = traced(&Voxels::new(whole), &[middle, beside]);
    // Half a voxel a step, an eighth of the side: nine samples, both faces among them.
    assert_eq!(samples, 9);
    let opacity = 1.0 - (-9.0f32 * 3.0 / 8.0).exp();
    // A half and a harmonic of 1 / sqrt(4 pi).
    let color = 0.5 + 0.5 * 0.282_094_8;
    for (found, expected) in pixels[0].iter().zip([color, color, color, 1.0]) {
        assert!((found - opacity * expected).abs() < 1e-5, "{pixels:?}");
    }
    assert_eq!(pixels[1], [0.0; 4]);
    // So far away that a step is less than what positions are rounded to.
    let far = Ray { origin: [0.4, 0.6, -1e9], direction: [0.0, 0.0, 1.0] };
    let (pixels, _) = traced(&Voxels::new(grid((0..64).collect(), [4; 3], vec![3.0; 64])), &[far]);
    assert!(pixels[0].iter().all(|value| value.is_finite()));
}

#[test]
fn what_holds_nothing_is_skipped() {
    let sizes = [19, 30, 41];
    let len = sizes.iter().product::<usize>();
    let mut random = crate::random::Random::new(3, [0; 3]);
    let mut links = vec![-1; len];
    let mut densities = Vec::new();
    // A few corners, on faces of blocks and of the grid among them.
    for _ in 0..10 {
        links[random.below(len)] = densities.len() as i32;
        densities.push(40.0);
    }
    for corner in [0, len - 1, (8 * 30 + 8) * 41 + 8, (16 * 30 + 24) * 41 + 40] {
        links[corner] = densities.len() as i32;
        densities.push(40.0);
    }
    let skipping = Voxels::new(grid(links, sizes, densities));
    let mut stepping = Voxels::new(skipping.grid.clone());
    stepping.filled.fill(true);
    let rays = rays();
    let [(some, few), (all, many)] = [&skipping, &stepping].map(|voxels| traced(voxels, &rays));
    assert!(all.iter().filter(|pixel| pixel[3] > 0.1).count() > 5);
    for (some, all) in some.iter().zip(&all) {
        for (some, all) in some.iter().zip(all) {
            assert!((some - all).abs() < 1e-6, "{some} {all}");
        }
    }
    assert!(2 * few < many, "{few} {many}");
}
