//! A path from photograph to photograph, where these are on no ring.

use std::f32::consts::TAU;

use glam::Vec3;

use super::{AMONG, Photograph, SPACINGS, among, longest_run, pose, spacing_of};

/// Photographs over which poses are smoothed.
const SMOOTH: f32 = 1.0;
/// Poses between two photographs.
const BETWEEN: usize = 8;

/// The longest way along the tree that joins neighbouring photographs, smoothed.
pub(super) struct Trail {
    /// Positions, directions away from what is shown, and what is up in the photographs.
    poses: Vec<[Vec3; 3]>,
    /// How far along the trail each is, from 0 to 1.
    along: Vec<f32>,
}

impl Trail {
    pub(super) fn new(photographs: &[Photograph]) -> Self {
        let reach = spacing_of(photographs);
        let way = longest(&tree(photographs, reach));
        let stops: Vec<[Vec3; 3]> =
            way.iter().map(|i| photographs[*i]).map(|p| [p.position, p.back, p.up]).collect();
        let poses: Vec<[Vec3; 3]> = smoothed(&stops);
        // The longest part of it that is near photographs.
        let near: Vec<bool> =
            poses.iter().map(|[p, back, _]| among(photographs, reach, *p, *back)).collect();
        let longest = longest_run(&near);
        let poses = if longest.is_empty() { poses } else { poses[longest].to_vec() };
        let mut along = vec![0.0];
        for pair in poses.windows(2) {
            let [[p, d, _], [q, e, _]] = [pair[0], pair[1]];
            let step = p.distance(q) / reach.max(f32::MIN_POSITIVE) + d.angle_between(e);
            along.push(along.last().unwrap_or(&0.0) + step);
        }
        let whole = along.last().copied().unwrap_or(0.0).max(f32::MIN_POSITIVE);
        along.iter_mut().for_each(|at| *at /= whole);
        Self { poses, along }
    }

    /// After this part of a full turn, to and fro.
    pub(super) fn pose(&self, turn: f32) -> [f32; 16] {
        let at = 0.5 * (1.0 - (turn % TAU).cos());
        let above = self.along.partition_point(|along| *along < at).min(self.along.len() - 1);
        let below = above.saturating_sub(1);
        let step = (self.along[above] - self.along[below]).max(f32::MIN_POSITIVE);
        let part = ((at - self.along[below]) / step).clamp(0.0, 1.0);
        let [position, back, up] =
            [0, 1, 2].map(|i| self.poses[below][i].lerp(self.poses[above][i], part));
        pose(position, back.normalize_or(Vec3::Z), up)
    }
}

/// How far two photographs are from each other, in usual distances and radians.
fn away(a: &Photograph, b: &Photograph, reach: f32) -> f32 {
    a.position.distance(b.position) / reach.max(f32::MIN_POSITIVE) + a.back.angle_between(b.back)
}

/// The neighbours of each photograph in the tree of the shortest ways (Prim 1957), without ways
/// whose middle is away from photographs.
fn tree(photographs: &[Photograph], reach: f32) -> Vec<Vec<(usize, f32)>> {
    let n = photographs.len();
    let mut neighbours = vec![Vec::new(); n];
    let mut nearest = vec![(f32::MAX, 0); n];
    let mut is_in = vec![false; n];
    let mut last = 0;
    is_in[0] = true;
    for _ in 1..n {
        for i in (0..n).filter(|i| !is_in[*i]) {
            let cost = away(&photographs[last], &photographs[i], reach);
            if cost < nearest[i].0 {
                nearest[i] = (cost, last);
            }
        }
        let next = (0..n).filter(|i| !is_in[*i]);
        let Some(next) = next.min_by(|a, b| nearest[*a].0.total_cmp(&nearest[*b].0)) else { break };
        let (cost, from) = nearest[next];
        let (a, b) = (&photographs[next], &photographs[from]);
        if a.position.distance(b.position) <= 2.0 * SPACINGS * reach
            && a.back.angle_between(b.back) <= 2.0 * AMONG
        {
            neighbours[next].push((from, cost));
            neighbours[from].push((next, cost));
        }
        is_in[next] = true;
        last = next;
    }
    neighbours
}

/// The longest way in a forest.
fn longest(neighbours: &[Vec<(usize, f32)>]) -> Vec<usize> {
    let from = |begin: usize| {
        // Place, the place before it, and how far it is.
        let mut reached = vec![(begin, begin, 0.0)];
        let mut i = 0;
        while i < reached.len() {
            let (here, before, far) = reached[i];
            let onward = neighbours[here].iter().filter(|(next, _)| *next != before);
            reached.extend(onward.map(|(next, cost)| (*next, here, far + cost)));
            i += 1;
        }
        reached
    };
    let far =
        |reached: &[(usize, usize, f32)]| reached.iter().fold(0.0, |far: f32, r| far.max(r.2));
    let all = (0..neighbours.len()).map(from);
    let Some(reached) = all.max_by(|a, b| far(a).total_cmp(&far(b))) else { return vec![0] };
    let begin = reached[0].0;
    let last = reached.iter().max_by(|a, b| a.2.total_cmp(&b.2));
    let mut way = vec![last.map_or(begin, |(place, ..)| *place)];
    while let Some(here) = way.last().copied().filter(|here| *here != begin) {
        let before = reached.iter().find(|(place, ..)| *place == here);
        way.push(before.map_or(begin, |(_, before, _)| *before));
    }
    way
}

/// Poses between these, each a mean of those around it.
fn smoothed(stops: &[[Vec3; 3]]) -> Vec<[Vec3; 3]> {
    let last = stops.len() as isize - 1;
    let n = (stops.len() - 1) * BETWEEN + 1;
    let pose = |i: usize| {
        let (at, mut sum, mut total) = (i as f32 / BETWEEN as f32, [Vec3::ZERO; 3], 0.0);
        let middle = at.round() as isize;
        for k in middle - 3..=middle + 3 {
            let weight = (-0.5 * ((k as f32 - at) / SMOOTH).powi(2)).exp();
            let stop = stops[k.clamp(0, last) as usize];
            sum = [0, 1, 2].map(|i| sum[i] + weight * stop[i]);
            total += weight;
        }
        let [position, back, up] = sum.map(|sum| sum / total);
        [position, back.normalize_or(Vec3::Z), up]
    };
    (0..n).map(pose).collect()
}
