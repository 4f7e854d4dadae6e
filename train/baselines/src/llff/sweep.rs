//! Where surfaces may be, before the first step: planes are swept through the scene, and where
//! photographs agree on a plane, it is opaque (Collins 1996).

use rayon::prelude::*;

use super::planes::{Planes, spot};
use crate::photographs::Photograph;

/// Pixels around one that are compared with it, to each side.
const WINDOW: usize = 2;
/// Mean squared difference of colours that tells two planes apart.
const DIFFERENCE: f32 = 2e-4;
/// What is not seen by another photograph differs by this.
const UNKNOWN: f32 = 0.02;
/// Opacities begin between this and 1 less than this: a step can move them.
const MARGIN: f32 = 0.002;

/// Colours and opacities of all planes of a photograph.
pub(super) fn sweep(
    planes: &Planes,
    own: &Photograph,
    others: &[&Photograph],
) -> Vec<Vec<[f32; 4]>> {
    let [width, height] = planes.size();
    let colors: Vec<[f32; 3]> = (0..width * height).map(|pixel| own.color(pixel)).collect();
    let costs: Vec<Vec<f32>> = (0..planes.depths.len())
        .into_par_iter()
        .map(|k| {
            let cost = |pixel: usize| {
                let point = planes.point(k, pixel % width, pixel / width);
                disagreement(&colors[pixel], point, others)
            };
            blurred(&(0..width * height).map(cost).collect::<Vec<_>>(), width)
        })
        .collect();
    let n = costs.len();
    let mut values = vec![vec![[0.0; 4]; width * height]; n];
    for (pixel, [r, g, b]) in colors.into_iter().enumerate() {
        let least = costs.iter().map(|cost| cost[pixel]).fold(f32::INFINITY, f32::min);
        let share = |k: usize| (-(costs[k][pixel] - least) / DIFFERENCE).exp();
        // Shares of the light become opacities, from the last plane to the first.
        let mut rest = 0.0;
        for k in (0..n).rev() {
            rest += share(k);
            // Where nothing is left behind, neither is there anything here.
            let opacity = (share(k) / rest.max(f32::MIN_POSITIVE)).clamp(MARGIN, 1.0 - MARGIN);
            values[k][pixel] = [r, g, b, if k + 1 == n { 1.0 } else { opacity }];
        }
    }
    values
}

/// How much photographs differ from a colour at a point: the half of them that differs least,
/// because others may not see it.
fn disagreement(color: &[f32; 3], point: [f32; 3], others: &[&Photograph]) -> f32 {
    let mut found: Vec<f32> = others
        .iter()
        .map(|other| {
            let size = [other.camera.width as usize, other.camera.height as usize];
            let at = other.lens.project(&other.camera, point);
            let spot = at.and_then(|[x, y]| spot([x - 0.5, y - 0.5], size));
            spot.map_or(UNKNOWN, |spot| {
                let mut seen = [0.0; 3];
                for (pixel, part) in spot.pixels(size[0]) {
                    let color = other.color(pixel);
                    (0..3).for_each(|c| seen[c] += part * color[c]);
                }
                (0..3).map(|c| (seen[c] - color[c]).powi(2)).sum::<f32>() / 3.0
            })
        })
        .collect();
    found.sort_by(f32::total_cmp);
    let half = found.len().div_ceil(2).max(1);
    found.iter().take(half).sum::<f32>() / half as f32
}

/// Means over windows, along rows and then along columns.
pub(super) fn blurred(values: &[f32], width: usize) -> Vec<f32> {
    let height = values.len() / width;
    let mean = |n: usize, at: usize, value: &dyn Fn(usize) -> f32| {
        let window = at.saturating_sub(WINDOW)..(at + WINDOW + 1).min(n);
        let count = window.len() as f32;
        window.map(value).sum::<f32>() / count
    };
    let rows: Vec<f32> = (0..values.len())
        .map(|i| mean(width, i % width, &|x| values[i / width * width + x]))
        .collect();
    (0..values.len()).map(|i| mean(height, i / width, &|y| rows[y * width + i % width])).collect()
}
