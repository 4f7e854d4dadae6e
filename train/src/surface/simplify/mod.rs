//! Fewer triangles: edges are collapsed, first those whose collapse moves the surface least
//! (Garland and Heckbert, "Surface simplification using quadric error metrics", 1997).

mod quadric;
#[cfg(test)]
mod tests;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{DVec3, Vec3};

use super::mesh::Mesh;
use quadric::Quadric;

/// An edge and its cost: the bits of a positive number have its order. The last number says what
/// its ends were like then.
type Candidate = Reverse<(u64, [u32; 2], u32)>;

/// A triangle turns by no more than 78 degrees: the cosine.
const TURN: f64 = 0.2;
/// The border of an open surface counts so many times as much as what lies beside it.
const BORDER: f64 = 10.0;

impl Mesh {
    /// Leaves at most so many triangles, or as few as can be: no part vanishes, no hole closes,
    /// no triangle turns over, and what is closed stays closed. Vertices move to where they are
    /// nearest to the surface that was there, and keep the normal and the colour of one there.
    pub fn simplify(&mut self, triangles: usize) {
        if self.triangles.len() <= triangles {
            return;
        }
        let mut net = Net::of(self);
        while net.left > triangles && net.collapse_all(triangles) {}
        self.positions = net.places.iter().map(|p| p.as_vec3().to_array()).collect();
        self.triangles = net.triangles.into_iter().filter(|triangle| *triangle != GONE).collect();
        self.drop_unused();
    }
}

/// A triangle that is no more.
const GONE: [u32; 3] = [u32::MAX; 3];

/// Triangles, and which of them are at each vertex.
struct Net {
    places: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    around: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    /// How often each vertex has changed.
    changes: Vec<u32>,
    /// Triangles that are left.
    left: usize,
}

impl Net {
    fn of(mesh: &Mesh) -> Self {
        let places: Vec<DVec3> = mesh.positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
        let mut around = vec![Vec::new(); places.len()];
        for (number, triangle) in (0..).zip(&mesh.triangles) {
            triangle.iter().for_each(|vertex| around[*vertex as usize].push(number));
        }
        let (n, triangles) = (places.len(), mesh.triangles.clone());
        let (quadrics, changes, left) = (vec![Quadric::NONE; n], vec![0; n], triangles.len());
        let mut net = Self { places, triangles, around, quadrics, changes, left };
        for triangle in mesh.triangles.iter().copied() {
            let [a, b, c] = net.corners(triangle);
            let across = (b - a).cross(c - a);
            net.hold(&triangle, Quadric::plane(a, across, 0.5 * across.length()));
            for i in 0..3 {
                let edge = [triangle[i], triangle[(i + 1) % 3]];
                if net.sharing(edge).count() == 1 {
                    let [from, to] = edge.map(|vertex| net.places[vertex as usize]);
                    let (along, weight) = (to - from, BORDER * from.distance_squared(to));
                    net.hold(&edge, Quadric::plane(from, along.cross(across), weight));
                }
            }
        }
        net
    }

    fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|vertex| self.places[vertex as usize])
    }

    fn hold(&mut self, vertices: &[u32], quadric: Quadric) {
        vertices.iter().for_each(|vertex| self.quadrics[*vertex as usize] += quadric);
    }

    /// The triangles on an edge.
    fn sharing(&self, [a, b]: [u32; 2]) -> impl Iterator<Item = u32> {
        let has = move |number: &u32| self.triangles[*number as usize].contains(&b);
        self.around[a as usize].iter().copied().filter(has)
    }

    /// The vertices around one, each with the number of triangles on the edge to it.
    fn ring(&self, vertex: u32) -> Vec<(u32, usize)> {
        let triangles = self.around[vertex as usize].iter();
        let mut ring: Vec<u32> =
            triangles.flat_map(|number| self.triangles[*number as usize]).collect();
        ring.retain(|other| *other != vertex);
        ring.sort_unstable();
        ring.chunk_by(|a, b| a == b).map(|same| (same[0], same.len())).collect()
    }

    /// Where an edge would be drawn together, and what that costs.
    fn cost(&self, [a, b]: [u32; 2]) -> (DVec3, f64) {
        let [from, to] = [a, b].map(|vertex| self.places[vertex as usize]);
        let mut quadric = self.quadrics[a as usize];
        quadric += self.quadrics[b as usize];
        quadric.least(from.midpoint(to), from.distance_squared(to))
    }

    fn candidate(&self, edge: [u32; 2]) -> Candidate {
        Reverse((self.cost(edge).1.to_bits(), edge, self.state(edge)))
    }

    fn state(&self, [a, b]: [u32; 2]) -> u32 {
        self.changes[a as usize] + self.changes[b as usize]
    }

    /// Collapses edges, cheapest first, until no more triangles are left than asked for, or no edge;
    /// whether there was one.
    fn collapse_all(&mut self, most: usize) -> bool {
        let net = &*self;
        let edges = |vertex: u32| {
            let later = net.ring(vertex).into_iter().filter(move |(other, _)| vertex < *other);
            later.map(move |(other, _)| net.candidate([vertex, other]))
        };
        let mut heap: BinaryHeap<Candidate> =
            (0..net.places.len() as u32).flat_map(edges).collect();
        let before = self.left;
        while self.left > most {
            let Some(Reverse((_, edge, state))) = heap.pop() else { break };
            // A vertex that is gone has changed.
            if state == self.state(edge) && self.collapse(edge) {
                let ring = self.ring(edge[0]);
                heap.extend(ring.iter().map(|(other, _)| self.candidate([edge[0], *other])));
            }
        }
        self.left < before
    }

    /// Draws an edge together, to its first vertex, if the surface stays what it is.
    fn collapse(&mut self, [a, b]: [u32; 2]) -> bool {
        let place = self.cost([a, b]).0;
        let shared: Vec<u32> = self.sharing([a, b]).collect();
        if !self.keeps_shape([a, b], &shared) || self.turns_over([a, b], place) {
            return false;
        }
        for number in &shared {
            let triangle = std::mem::replace(&mut self.triangles[*number as usize], GONE);
            for vertex in triangle {
                self.around[vertex as usize].retain(|other| other != number);
            }
        }
        self.left -= shared.len();
        let moved = std::mem::take(&mut self.around[b as usize]);
        for number in &moved {
            let corners = &mut self.triangles[*number as usize];
            corners.iter_mut().filter(|vertex| **vertex == b).for_each(|vertex| *vertex = a);
        }
        self.around[a as usize].extend(moved);
        self.places[a as usize] = place;
        let quadric = self.quadrics[b as usize];
        self.quadrics[a as usize] += quadric;
        self.changes[a as usize] += 1;
        self.changes[b as usize] += 1;
        true
    }

    /// Whether the surface is the same but for the edge's triangles: what is around both ends is around
    /// the edge (Dey et al., "Topology preserving edge contraction", 1999).
    fn keeps_shape(&self, [a, b]: [u32; 2], shared: &[u32]) -> bool {
        let [ring, other] = [a, b].map(|vertex| self.ring(vertex));
        let is_simple = |ring: &[(u32, usize)]| ring.iter().all(|(_, n)| *n <= 2);
        let is_border = |ring: &[(u32, usize)]| ring.iter().any(|(_, n)| *n == 1);
        let both = ring.iter().filter(|(x, _)| other.iter().any(|(y, _)| x == y)).count();
        let is_across = shared.len() == 2 && is_border(&ring) && is_border(&other);
        if both != shared.len() || is_across || !is_simple(&ring) || !is_simple(&other) {
            return false;
        }
        let rest = |vertex: u32| {
            self.around[vertex as usize].iter().filter(|number| !shared.contains(number))
        };
        // Of a tetrahedron and of a triangle nothing would be left.
        let far = |number: &u32, vertex: u32| {
            let mut far =
                self.triangles[*number as usize].map(|v| if v == vertex { u32::MAX } else { v });
            far.sort_unstable();
            far
        };
        rest(a).chain(rest(b)).next().is_some()
            && rest(b).all(|number| rest(a).all(|of_a| far(number, b) != far(of_a, a)))
    }

    /// Whether a triangle at either end would turn over, or nearly.
    fn turns_over(&self, edge: [u32; 2], place: DVec3) -> bool {
        edge.iter().flat_map(|vertex| &self.around[*vertex as usize]).any(|number| {
            let triangle = self.triangles[*number as usize];
            if edge.iter().all(|vertex| triangle.contains(vertex)) {
                return false;
            }
            let across = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
            let before = self.corners(triangle);
            let mut after = before;
            let ends = after.iter_mut().zip(triangle).filter(|(_, vertex)| edge.contains(vertex));
            ends.for_each(|(corner, _)| *corner = place);
            let (before, after) = (across(before), across(after));
            before.dot(after) < TURN * before.length() * after.length() || after == DVec3::ZERO
        })
    }
}
