//! Triangles in a plane, and whether they cover one another.

use std::collections::HashMap;

use glam::{IVec2, Vec2};

/// A triangle of a chart.
pub(super) type Flat = [Vec2; 3];

/// A triangle is looked for in cells of a grid that has at most so many along a side.
const CELLS: f32 = 256.0;
/// Neighbours may cover one another by this share of an edge: rounding.
const SLACK: f32 = 1e-3;

/// Smallest and largest corner of the box around points.
pub(super) fn bounds<'a>(points: impl IntoIterator<Item = &'a Vec2>) -> [Vec2; 2] {
    let nothing = [Vec2::INFINITY, Vec2::NEG_INFINITY];
    points.into_iter().fold(nothing, |[low, high], p| [low.min(*p), high.max(*p)])
}

/// Triangles of charts, found by where they lie.
#[derive(Debug)]
pub(super) struct Cover {
    cell: f32,
    slack: f32,
    placed: Vec<Flat>,
    /// Numbers of triangles, by chart and cell.
    cells: HashMap<(usize, IVec2), Vec<u32>>,
}

impl Cover {
    /// For triangles with edges of this length, about, of a body of this extent.
    pub(super) fn new(edge: f32, extent: f32) -> Self {
        let cell = (2.0 * edge).max(extent / CELLS).max(f32::MIN_POSITIVE);
        Self { cell, slack: SLACK * edge, placed: Vec::new(), cells: HashMap::new() }
    }

    /// Adds a triangle to a chart, unless it would cover others there; whether it was added.
    pub(super) fn add(&mut self, chart: usize, triangle: Flat) -> bool {
        let [low, high] = bounds(&triangle).map(|p| (p / self.cell).floor().as_ivec2());
        let cells = (low.y..=high.y).flat_map(|y| (low.x..=high.x).map(move |x| IVec2::new(x, y)));
        let covers = cells.clone().any(|cell| {
            let there = self.cells.get(&(chart, cell));
            there
                .into_iter()
                .flatten()
                .any(|other| overlap(&triangle, &self.placed[*other as usize], self.slack))
        });
        if !covers {
            let number = self.placed.len() as u32;
            self.placed.push(triangle);
            cells.for_each(|cell| self.cells.entry((chart, cell)).or_default().push(number));
        }
        !covers
    }
}

/// Whether triangles cover one another by more than `slack`: no edge of either has them on two
/// sides of a line along it (separating axes).
fn overlap(a: &Flat, b: &Flat, slack: f32) -> bool {
    let edges = [a, b].into_iter().flat_map(|t| [t[1] - t[0], t[2] - t[1], t[0] - t[2]]);
    edges.filter_map(|edge| edge.perp().try_normalize()).all(|across| {
        let range = |triangle: &Flat| {
            let [p, q, r] = triangle.map(|corner| corner.dot(across));
            [p.min(q).min(r), p.max(q).max(r)]
        };
        let ([low, high], [from, to]) = (range(a), range(b));
        low.max(from) + slack < high.min(to)
    })
}
