//! Charts: triangles side by side that face the same axis.

use std::collections::VecDeque;

use glam::{Vec2, Vec3};

use super::flat::{Cover, Flat, bounds};
use crate::surface::Mesh;

/// Instead of a triangle.
const NONE: u32 = u32::MAX;
/// A triangle may face an axis if this is the cosine between them, or more.
const LEAST: f32 = 0.4;
/// How often triangles take the axis of those around them.
const ROUNDS: usize = 4;

/// The axes ±x, ±y and ±z: two numbers each, the positive one first.
type Axis = usize;

/// Triangles that lie side by side when projected along an axis.
#[derive(Debug)]
pub(super) struct Chart {
    axis: Axis,
    /// Numbers of triangles of the mesh.
    pub(super) triangles: Vec<u32>,
    /// The smallest corner of the box around them, projected.
    pub(super) min: Vec2,
}

impl Chart {
    /// A point projected along the axis, seen from outside: x to the right and y down.
    pub(super) fn flat(&self, p: Vec3) -> Vec2 {
        flat(self.axis, p)
    }

    /// Its triangles, projected, the smallest corner of the box around them at 0.
    pub(super) fn outline(&self, mesh: &Mesh) -> Vec<Flat> {
        let corners = |triangle: &u32| mesh.corners(mesh.triangles[*triangle as usize]);
        let flat = |corners: [Vec3; 3]| corners.map(|corner| self.flat(corner) - self.min);
        self.triangles.iter().map(|triangle| flat(corners(triangle))).collect()
    }
}

fn flat(axis: Axis, p: Vec3) -> Vec2 {
    Vec2::new(sign(axis) * p[(axis / 2 + 1) % 3], -p[(axis / 2 + 2) % 3])
}

/// How much a direction points along an axis.
fn along(axis: Axis, direction: Vec3) -> f32 {
    sign(axis) * direction[axis / 2]
}

fn sign(axis: Axis) -> f32 {
    if axis.is_multiple_of(2) { 1.0 } else { -1.0 }
}

fn nearest(direction: Vec3) -> Axis {
    let dimension = direction.abs().max_position();
    2 * dimension + usize::from(direction[dimension] < 0.0)
}

/// Cuts a mesh into charts. Each grows from a triangle to its neighbours, as long as they face the
/// same axis and cover none of it.
pub(super) fn of(mesh: &Mesh) -> Vec<Chart> {
    let neighbours = neighbours(&mesh.triangles);
    let axes = axes(mesh, &neighbours);
    let [low, high] = mesh.bounds().unwrap_or_default().map(Vec3::from);
    let edges = mesh.triangles.iter().map(|triangle| {
        let [a, b, _] = mesh.corners(*triangle);
        a.distance(b)
    });
    let edge = edges.sum::<f32>() / mesh.triangles.len().max(1) as f32;
    let mut cover = Cover::new(edge, (high - low).max_element());
    let mut taken = vec![false; mesh.triangles.len()];
    let mut charts = Vec::new();
    let mut queue = VecDeque::new();
    for first in 0..mesh.triangles.len() {
        let axis = axes[first];
        let mut chart = Chart { axis, triangles: Vec::new(), min: Vec2::INFINITY };
        queue.push_back(first);
        while let Some(triangle) = queue.pop_front() {
            if taken[triangle] || axes[triangle] != axis {
                continue;
            }
            let place = mesh.corners(mesh.triangles[triangle]).map(|corner| flat(axis, corner));
            if !cover.add(charts.len(), place) {
                continue;
            }
            taken[triangle] = true;
            chart.triangles.push(triangle as u32);
            chart.min = chart.min.min(bounds(&place)[0]);
            let around = neighbours[triangle].iter().filter(|other| **other != NONE);
            queue.extend(around.map(|other| *other as usize));
        }
        if !chart.triangles.is_empty() {
            charts.push(chart);
        }
    }
    charts
}

/// The triangles on the other side of each one's edges, where there is just one.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
    for (number, [a, b, c]) in (0..).step_by(3).zip(triangles) {
        let sides = [[*a, *b], [*b, *c], [*c, *a]].map(|[a, b]| [a.min(b), a.max(b)]);
        edges.extend(sides.into_iter().zip(number..));
    }
    edges.sort_unstable();
    let mut neighbours = vec![[NONE; 3]; triangles.len()];
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [(_, one), (_, other)] = same {
            neighbours.as_flattened_mut()[*one as usize] = other / 3;
            neighbours.as_flattened_mut()[*other as usize] = one / 3;
        }
    }
    neighbours
}

/// The axis that each triangle faces: that of the normals at its corners, which change less from
/// one to the next; and then that of most around it. Fewer charts have fewer seams.
fn axes(mesh: &Mesh, neighbours: &[[u32; 3]]) -> Vec<Axis> {
    let normal = |triangle: &[u32; 3]| {
        let [a, b, c] = mesh.corners(*triangle);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let normals: Vec<Vec3> = mesh.triangles.iter().map(normal).collect();
    let smooth = |triangle: &[u32; 3]| -> Vec3 {
        triangle.iter().map(|vertex| Vec3::from(mesh.normals[*vertex as usize])).sum()
    };
    let choose = |(triangle, normal): (&[u32; 3], &Vec3)| {
        let axis = nearest(smooth(triangle));
        if along(axis, *normal) >= LEAST { axis } else { nearest(*normal) }
    };
    let mut axes: Vec<Axis> = mesh.triangles.iter().zip(&normals).map(choose).collect();
    for _ in 0..ROUNDS {
        let around = |three: &[u32; 3]| three.map(|other| axes.get(other as usize).copied());
        let most = |[a, b, c]: [Option<Axis>; 3]| {
            if a == b || a == c {
                a
            } else if b == c {
                b
            } else {
                None
            }
        };
        let next = neighbours.iter().zip(&axes).zip(&normals).map(|((three, axis), normal)| {
            most(around(three)).filter(|most| along(*most, *normal) >= LEAST).unwrap_or(*axis)
        });
        axes = next.collect();
    }
    axes
}
