//! Charts in a square.
//!
//! Each is dropped onto the horizon of those below, where least room stays empty (Lévy et al.,
//! "Least squares conformal maps for automatic texture atlas generation", 2002, section 4).

use std::cmp::Reverse;

use glam::Vec2;
use rayon::prelude::*;

use super::flat::{Flat, bounds};

/// Texels around a chart that are its own: between two charts there are twice as many.
pub(super) const GUTTER: u32 = 2;
/// Columns of a horizon, at most.
const COLUMNS: u32 = 1024;
/// Texels become wider by this factor until all charts fit.
const WIDER: f32 = 1.3;
/// And are found to its root, taken so many times.
const ROOTS: u32 = 4;

/// Where charts lie.
#[derive(Debug)]
pub(super) struct Packed {
    /// The width of a texel, scene units.
    pub(super) texel: f32,
    /// Where the smallest corner of the box around each chart is, texels.
    pub(super) origins: Vec<Vec2>,
}

/// Texels are about as small as they may be; `None` where charts of a texel each do not fit.
pub(super) fn pack(charts: &[Vec<Flat>], size: u32) -> Option<Packed> {
    let extents: Vec<Vec2> = charts.iter().map(|chart| bounds(chart.as_flattened())[1]).collect();
    let largest = extents.iter().map(|extent| extent.max_element()).fold(0.0, f32::max);
    let area = |[a, b, c]: &Flat| 0.5 * (b - a).perp_dot(c - a).abs();
    let area: f32 = charts.iter().flatten().map(area).sum();
    let lay = |texel: f32| {
        let grid = Grid { texel, size, cell: (size / COLUMNS).max(1) };
        Some(Packed { texel, origins: grid.lay(charts, &extents)? })
    };
    let mut texel = (area.sqrt() / size as f32).max(f32::MIN_POSITIVE);
    let mut packed = loop {
        if let Some(packed) = lay(texel) {
            break packed;
        }
        if texel > largest {
            return None;
        }
        texel *= WIDER;
    };
    let mut factor = WIDER;
    for _ in 0..ROOTS {
        factor = factor.sqrt();
        packed = lay(packed.texel / factor).unwrap_or(packed);
    }
    Some(packed)
}

/// A square of texels, in cells of a few.
#[derive(Clone, Copy, Debug)]
struct Grid {
    /// The width of a texel, scene units.
    texel: f32,
    /// Texels along a side.
    size: u32,
    /// Texels along a side of a cell.
    cell: u32,
}

/// What a chart takes of each column of cells, gutters included: the first cell, and the one after
/// the last.
type Columns = Vec<[u32; 2]>;

impl Grid {
    fn lay(&self, charts: &[Vec<Flat>], extents: &[Vec2]) -> Option<Vec<Vec2>> {
        let side = self.size / self.cell;
        let widest = (side * self.cell - 2 * GUTTER) as f32 * self.texel;
        if extents.iter().any(|extent| extent.max_element() > widest) {
            return None;
        }
        let columns = |(chart, extent): (&Vec<Flat>, &Vec2)| self.columns(chart, *extent);
        let columns: Vec<Columns> = charts.par_iter().zip(extents).map(columns).collect();
        let height = |chart: usize| columns[chart].iter().map(|[_, end]| *end).max().unwrap_or(0);
        let mut order: Vec<usize> = (0..charts.len()).collect();
        order.sort_by_key(|chart| Reverse(height(*chart)));
        let mut horizon = vec![0; side as usize];
        let mut origins = vec![Vec2::ZERO; charts.len()];
        for chart in order {
            let [x, y] = lowest(&horizon, &columns[chart], height(chart), side)?;
            let taken = horizon[x as usize..].iter_mut().zip(&columns[chart]);
            taken.for_each(|(horizon, [_, end])| *horizon = y + end);
            origins[chart] = [x, y].map(|cells| (cells * self.cell + GUTTER) as f32).into();
        }
        Some(origins)
    }

    fn columns(&self, chart: &[Flat], extent: Vec2) -> Columns {
        let (gutter, cell) = (GUTTER as f32 * self.texel, self.cell as f32 * self.texel);
        let n = ((extent.x + 2.0 * gutter) / cell).floor() as usize + 1;
        let mut columns = vec![[u32::MAX, 0]; n];
        for triangle in chart {
            // Cells begin a gutter before the chart.
            let [low, high] = bounds(triangle);
            let first = (low.x / cell) as usize;
            let last = ((high.x + 2.0 * gutter) / cell) as usize;
            let taken = columns.iter_mut().enumerate().take(last + 1).skip(first);
            for (number, [first, end]) in taken {
                let from = number as f32 * cell - 2.0 * gutter;
                let [low, high] = heights(triangle, from, from + cell + 2.0 * gutter);
                *first = (*first).min((low / cell) as u32);
                *end = (*end).max(((high + 2.0 * gutter) / cell) as u32 + 1);
            }
        }
        columns
    }
}

/// The smallest and the largest y of a triangle between two x.
fn heights(triangle: &Flat, from: f32, to: f32) -> [f32; 2] {
    let [left, right] = bounds(triangle).map(|p| p.x);
    let (from, to) = (from.min(right), to.max(left));
    let [mut low, mut high] = [f32::INFINITY, f32::NEG_INFINITY];
    for (p, q) in [(0, 1), (1, 2), (2, 0)].map(|(p, q)| (triangle[p], triangle[q])) {
        let (p, q) = if p.x <= q.x { (p, q) } else { (q, p) };
        if q.x < from || p.x > to {
            continue;
        }
        let along = |x: f32| ((x - p.x) / (q.x - p.x)).clamp(0.0, 1.0);
        let ends = if p.x < q.x { [along(from), along(to)] } else { [0.0, 1.0] };
        for y in ends.map(|share| p.y + share * (q.y - p.y)) {
            (low, high) = (low.min(y), high.max(y));
        }
    }
    [low, high]
}

/// Where a chart ends lowest, and leaves least room empty below it.
fn lowest(horizon: &[u32], chart: &[[u32; 2]], height: u32, side: u32) -> Option<[u32; 2]> {
    let mut best: Option<([u32; 2], [u32; 2])> = None;
    for (x, below) in (0..).zip(horizon.windows(chart.len())) {
        let over =
            below.iter().zip(chart).map(|(horizon, [first, _])| horizon.saturating_sub(*first));
        let y = over.max().unwrap_or(0);
        if y + height > best.map_or(side, |(cost, _)| cost[0] + height) {
            continue;
        }
        let empty = below.iter().zip(chart).map(|(horizon, [first, _])| y + first - horizon);
        let cost = [y, empty.sum()];
        if best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, [x, y]));
        }
    }
    best.map(|(_, place)| place)
}
