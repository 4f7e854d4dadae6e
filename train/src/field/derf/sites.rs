//! Where heads are: a Voronoi diagram that is learnt before the heads are.
//!
//! A filled cell x belongs to head n by `w_n(x) = softmax(-sharpness * |x - site_n|)` (Rebain et
//! al. 2021, "DeRF"), which is differentiable. Sites follow the gradient of two
//! terms: how unequal the heads' shares of all cells are, and how far cells are from their sites.
//! While they learn, the diagram becomes as sharp as it is rendered.

use pocketnerf_core::Occupancy;

/// Cells that are looked at, at most.
const MOST_CELLS: usize = 4096;
/// Steps.
const STEPS: u32 = 300;
/// Sharpness at first and at last, 1 / unit length.
const SHARPNESS: [f32; 2] = [8.0, 200.0];
/// Length of a step at first; it ends at a tenth.
const RATE: f32 = 0.01;
/// What unequal shares count beside distances.
const BALANCE: f32 = 4.0;

/// The sites of so many heads in what is filled, unit coordinates; the same for the same cells.
pub(super) fn learnt(cells: &Occupancy<'_>, n_heads: usize) -> Vec<[f32; 3]> {
    let cells = filled(cells);
    let mut sites = spread(&cells, n_heads);
    let mut square = vec![[0.0f32; 3]; n_heads];
    for step in 0..STEPS {
        let done = step as f32 / STEPS as f32;
        let sharpness = SHARPNESS[0] * (SHARPNESS[1] / SHARPNESS[0]).powf(done);
        let gradient = gradient(&cells, &sites, sharpness);
        let rate = RATE * 0.1f32.powf(done);
        for ((site, square), gradient) in sites.iter_mut().zip(&mut square).zip(gradient) {
            for axis in 0..3 {
                let g = gradient[axis];
                square[axis] = if step == 0 { g * g } else { 0.9 * square[axis] + 0.1 * g * g };
                let next = site[axis] - rate * g / (square[axis].sqrt() + 1e-8);
                site[axis] = next.clamp(0.0, 1.0);
            }
        }
    }
    sites
}

/// Centres of filled cells, evenly chosen; where nothing is filled, the middle.
fn filled(cells: &Occupancy<'_>) -> Vec<[f32; 3]> {
    let n = cells.resolution();
    let places = (0..n).flat_map(|z| (0..n).flat_map(move |y| (0..n).map(move |x| [x, y, z])));
    let filled: Vec<_> = places.filter(|[x, y, z]| cells.cell(*x, *y, *z)).collect();
    let step = filled.len().div_ceil(MOST_CELLS).max(1);
    let center = |cell: [u32; 3]| cell.map(|c| (c as f32 + 0.5) / n as f32);
    let chosen: Vec<_> = filled.into_iter().step_by(step).map(center).collect();
    if chosen.is_empty() { vec![[0.5; 3]] } else { chosen }
}

/// Sites far from one another: each in the cell that is farthest from those before it.
fn spread(cells: &[[f32; 3]], n: usize) -> Vec<[f32; 3]> {
    let mut sites = vec![cells[cells.len() / 2]];
    let mut nearest = vec![f32::INFINITY; cells.len()];
    while sites.len() < n {
        let last = sites[sites.len() - 1];
        for (nearest, cell) in nearest.iter_mut().zip(cells) {
            *nearest = nearest.min(distance(*cell, last));
        }
        let farthest = (0..cells.len()).fold(0, |a, b| if nearest[b] > nearest[a] { b } else { a });
        sites.push(cells[farthest]);
    }
    sites
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f32>().sqrt()
}

/// Each cell's shares in the heads.
fn shares(cell: [f32; 3], sites: &[[f32; 3]], sharpness: f32, to: &mut [f32]) {
    let mut most = f32::NEG_INFINITY;
    for (to, site) in to.iter_mut().zip(sites) {
        *to = -sharpness * distance(cell, *site);
        most = most.max(*to);
    }
    to.iter_mut().for_each(|share| *share = (*share - most).exp());
    let sum: f32 = to.iter().sum();
    to.iter_mut().for_each(|share| *share /= sum);
}

/// `BALANCE * heads * sum of (share - 1/heads)² + mean over cells of sum of w_n |x - site_n|`.
#[cfg(test)]
fn loss(cells: &[[f32; 3]], sites: &[[f32; 3]], sharpness: f32) -> f64 {
    let (n, mut own) = (sites.len(), vec![0.0; sites.len()]);
    let (mut total, mut far) = (vec![0.0f64; n], 0.0);
    for cell in cells {
        shares(*cell, sites, sharpness, &mut own);
        for ((total, w), site) in total.iter_mut().zip(&own).zip(sites) {
            *total += f64::from(*w) / cells.len() as f64;
            far += f64::from(w * distance(*cell, *site)) / cells.len() as f64;
        }
    }
    let uneven: f64 = total.iter().map(|share| (share - 1.0 / n as f64).powi(2)).sum();
    f64::from(BALANCE) * n as f64 * uneven + far
}

/// The gradient of that loss with respect to the sites.
fn gradient(cells: &[[f32; 3]], sites: &[[f32; 3]], sharpness: f32) -> Vec<[f32; 3]> {
    let n = sites.len();
    let mut all = vec![0.0; n * cells.len()];
    let mut total = vec![0.0f32; n];
    for (own, cell) in all.chunks_exact_mut(n).zip(cells) {
        shares(*cell, sites, sharpness, own);
        total.iter_mut().zip(&*own).for_each(|(total, w)| *total += w / cells.len() as f32);
    }
    let worth: Vec<f32> =
        total.iter().map(|t| 2.0 * BALANCE * n as f32 * (t - 1.0 / n as f32)).collect();
    let mut gradient = vec![[0.0; 3]; n];
    for (own, cell) in all.chunks_exact(n).zip(cells) {
        let far = |head: usize| distance(*cell, sites[head]);
        // What a share of each head adds, less the mean over the heads: the softmax's derivative.
        let mean: f32 = (0..n).map(|h| own[h] * (worth[h] + far(h))).sum();
        for head in 0..n {
            let by_logit = own[head] * (worth[head] + far(head) - mean);
            let by_distance = own[head] - sharpness * by_logit;
            let length = far(head).max(1e-6);
            for axis in 0..3 {
                let towards = (sites[head][axis] - cell[axis]) / length;
                gradient[head][axis] += by_distance * towards / cells.len() as f32;
            }
        }
    }
    gradient
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::trainer::pack;

    fn points(n: usize, seed: u64) -> Vec<[f32; 3]> {
        let mut random = Random::new(seed, [0; 3]);
        (0..n).map(|_| [0; 3].map(|_: i32| random.next_f32())).collect()
    }

    #[test]
    fn gradient_is_the_difference() {
        let (cells, sites) = (points(40, 1), points(3, 2));
        for sharpness in [2.0, 8.0] {
            let found = gradient(&cells, &sites, sharpness);
            for i in 0..9 {
                let at = |by: f32| {
                    let mut moved = sites.clone();
                    moved[i / 3][i % 3] += by;
                    loss(&cells, &moved, sharpness)
                };
                let expected = (at(2e-3) - at(-2e-3)) / 4e-3;
                let found = f64::from(found[i / 3][i % 3]);
                assert!(
                    (found - expected).abs() < 2e-3 + 0.01 * expected.abs(),
                    "{found} {expected}"
                );
            }
        }
    }

    /// Two bodies of unequal size: every head has its share. A body that is small and lies apart
    /// may be a head's alone.
    #[test]
    fn heads_share_what_is_filled() {
        let n = 32;
        let cells = (0..n * n * n).filter(|cell| {
            let [x, y, z] = [cell % n, cell / n % n, cell / (n * n)];
            (x < 6 && y < 6 && z < 6) || (x >= 16 && (8..28).contains(&y) && z >= 12)
        });
        let (coarse, fine) = pack(n, cells).unwrap();
        let occupancy = Occupancy::new(n, 1, &coarse, &fine).unwrap();
        for n_heads in [1, 2, 4, 8, 16] {
            let sites = learnt(&occupancy, n_heads);
            assert_eq!(sites, learnt(&occupancy, n_heads));
            let mut counts = vec![0; n_heads];
            let cells = filled(&occupancy);
            for cell in &cells {
                let nearest = (0..n_heads).min_by(|a, b| {
                    distance(*cell, sites[*a]).total_cmp(&distance(*cell, sites[*b]))
                });
                counts[nearest.unwrap()] += 1;
            }
            let even = cells.len() / n_heads;
            assert!(counts.iter().all(|n| (even / 5..=2 * even).contains(n)), "{counts:?}");
        }
    }
}
