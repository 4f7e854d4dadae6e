//! A path around what photographs look at, or around a room.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use super::{
    Photograph, SPACINGS, among, back, longest_run, median_of_nearest, meeting, pose, position,
    spacing_of,
};

/// An angle around the scene without photographs from which on the path turns back, radians.
const OPEN: f32 = PI / 3.0;
/// Steps of the path on which its elevation is chosen ...
const STEPS: usize = 72;
/// ... out of so many.
const ELEVATIONS: usize = 37;
/// What it costs to rise by an angle from step to step, beside the same angle to the nearest
/// photograph, squared.
const RISE: f32 = 3.0;
/// What it costs to be away from the usual elevation of photographs by an angle. Steep rings are
/// short, so that photographs are near wherever one is.
const STEEPER: f32 = 0.03;
/// Steps over which the elevation is smoothed.
const SMOOTH: f32 = 2.0;
/// Angles between which photographs count as near to a pose, radians.
const NEAR: [f32; 2] = [0.04, 0.15];
/// The least part of a path that is worth going to and fro instead of the whole.
const WORTH: usize = STEPS / 2;
/// So much further from photographs a path may be that goes all the way around.
const AROUND: f32 = 1.25;
/// Looks at each step whether photographs are near.
const LOOKS: usize = 4;
/// Directions that are so steep have no azimuth to speak of, cosine of the elevation.
const STEEP: f32 = 0.3;

/// Cameras all around, or part of the way around: what they look at, or, in a room, themselves.
pub(super) struct Ring {
    photographs: Vec<Photograph>,
    up: Vec3,
    /// Two directions across it, at azimuths of 0 and a quarter turn.
    across: [Vec3; 2],
    /// What the photographs look at, if there is such a point.
    target: Option<Vec3>,
    /// The direction of each photograph: from what it shows to where it was taken.
    directions: Vec<Vec3>,
    /// The usual angle from one to the next, within [`NEAR`].
    near: f32,
    /// The first azimuth, and the angle from there to the last.
    first: f32,
    whole: f32,
    is_open: bool,
    /// The elevation at each step from the first azimuth to the last.
    elevations: Vec<f32>,
    /// The steps between which the path goes to and fro, unless it goes around.
    between: Option<[f32; 2]>,
}

impl Ring {
    /// `None` where most of it would be away from photographs.
    pub(super) fn new(photographs: Vec<Photograph>, up: Vec3) -> Option<Self> {
        let across = up.any_orthonormal_pair();
        // From there all of them, but for a few, look at it.
        let is_before = |target: Vec3| {
            photographs.iter().filter(|p| p.back.dot(p.position - target) > 0.0).count()
        };
        let target =
            meeting(&photographs).filter(|target| 10 * is_before(*target) >= 9 * photographs.len());
        let direction = |p: &Photograph| match target {
            Some(target) => (p.position - target).normalize_or(p.back),
            None => p.back,
        };
        let directions: Vec<Vec3> = photographs.iter().map(direction).collect();
        let across = [across.0, across.1];
        let mut ring = Self {
            photographs,
            up,
            across,
            target,
            near: usual_angle(&directions).clamp(NEAR[0], NEAR[1]),
            directions,
            first: 0.0,
            whole: TAU,
            is_open: false,
            elevations: Vec::new(),
            between: None,
        };
        ring.find_ends();
        ring.elevations = ring.found_elevations();
        ring.find_between().then_some(ring)
    }

    /// Finds the longest part of the path that stays among photographs: where these leave a gap, or
    /// move on by a stride, it ends. False where it is too short.
    fn find_between(&mut self) -> bool {
        let spacing = spacing_of(&self.photographs);
        let among = |looks: usize, spacing: f32| -> Vec<bool> {
            let is_among = |look: usize| {
                let pose = self.at((look % (LOOKS * STEPS)) as f32 / LOOKS as f32);
                among(&self.photographs, spacing, position(&pose), back(&pose))
            };
            (0..looks).map(is_among).collect()
        };
        if !self.is_open && !among(LOOKS * STEPS, AROUND * spacing).contains(&false) {
            return true;
        }
        // A ring has parts that go past its first step.
        let looks = if self.is_open { LOOKS * (STEPS - 1) + 1 } else { 2 * LOOKS * STEPS };
        let longest = longest_run(&among(looks, spacing));
        let at = |look: usize| look as f32 / LOOKS as f32;
        self.between = Some([at(longest.start), at(longest.end.saturating_sub(1))]);
        longest.len() >= LOOKS * WORTH
    }

    /// The direction at an azimuth and an elevation.
    fn direction(&self, azimuth: f32, elevation: f32) -> Vec3 {
        let [x, y] = self.across;
        let (sin, cos) = azimuth.sin_cos();
        elevation.cos() * (cos * x + sin * y) + elevation.sin() * self.up
    }

    /// From the end of the widest angle without photographs, if it is wide, to its beginning.
    fn find_ends(&mut self) {
        let flat = |d: &Vec3| Vec2::from(self.across.map(|axis| axis.dot(*d)));
        let flat = self.directions.iter().map(flat).filter(|d| d.length() > STEEP);
        let mut azimuths: Vec<f32> = flat.map(|d| d.y.atan2(d.x)).collect();
        azimuths.sort_by(f32::total_cmp);
        let next = azimuths.iter().skip(1).copied().chain(azimuths.first().map(|a| a + TAU));
        let gaps = azimuths.iter().zip(next).map(|(here, next)| (next - here, next));
        if let Some((gap, end)) = gaps.max_by(|a, b| a.0.total_cmp(&b.0))
            && gap > OPEN
        {
            (self.first, self.whole, self.is_open) = (end, TAU - gap, true);
        }
    }

    /// The elevations at which the path is nearest to photographs, without much up and down: the
    /// cheapest way from step to step.
    fn found_elevations(&self) -> Vec<f32> {
        let own = self.directions.iter().map(|d| d.dot(self.up).clamp(-1.0, 1.0).asin());
        let mut own: Vec<f32> = own.collect();
        own.sort_by(f32::total_cmp);
        let [low, usual, high] = [0, own.len() / 2, own.len() - 1].map(|i| own[i]);
        let at = |j: usize| low + (high - low) * j as f32 / (ELEVATIONS - 1) as f32;
        let rise = (high - low) / (ELEVATIONS - 1) as f32;
        let limit = SPACINGS * usual_angle(&self.directions).max(1e-3);
        let away = |step: usize, j: usize| {
            let from = self.direction(self.azimuth(step as f32), at(j));
            let nearest = self.directions.iter().map(|d| d.dot(from)).fold(-1.0, f32::max);
            let away = nearest.min(1.0).acos();
            // Beyond the limit the path would end.
            let beyond = 1.0 + (away / limit).powi(6);
            away.powi(2) * beyond + STEEPER * (at(j) - usual).powi(2)
        };
        // A ring is gone around twice, and the second time counts: it ends where it begins.
        let rounds = if self.is_open { 1 } else { 3 };
        let mut costs = [0.0; ELEVATIONS];
        let mut came_from = Vec::with_capacity(rounds * STEPS);
        for step in 0..rounds * STEPS {
            let mut here = [(0.0, 0); ELEVATIONS];
            for (j, here) in here.iter_mut().enumerate() {
                let cost =
                    |from: usize| costs[from] + RISE * (rise * from.abs_diff(j) as f32).powi(2);
                let from = (0..ELEVATIONS).min_by(|a, b| cost(*a).total_cmp(&cost(*b)));
                let from = from.unwrap_or(j);
                *here = (cost(from) + away(step % STEPS, j), from);
            }
            costs = here.map(|(cost, _)| cost);
            came_from.push(here.map(|(_, from)| from));
        }
        let last = (0..ELEVATIONS).min_by(|a, b| costs[*a].total_cmp(&costs[*b]));
        let mut j = last.unwrap_or(0);
        let mut found = vec![0.0; rounds * STEPS];
        for (step, from) in came_from.iter().enumerate().rev() {
            found[step] = at(j);
            j = from[j];
        }
        // The middle round, which has others on both sides.
        let found = if self.is_open { found } else { found[STEPS..2 * STEPS].to_vec() };
        self.smoothed(&found)
    }

    fn smoothed(&self, values: &[f32]) -> Vec<f32> {
        let at = |i: isize| match self.is_open {
            true => values[i.clamp(0, STEPS as isize - 1) as usize],
            false => values[i.rem_euclid(STEPS as isize) as usize],
        };
        let reach = 3 * SMOOTH as isize;
        let weight = |k: isize| (-0.5 * (k as f32 / SMOOTH).powi(2)).exp();
        let total: f32 = (-reach..=reach).map(weight).sum();
        let sum = |i: isize| (-reach..=reach).map(|k| weight(k) * at(i + k)).sum::<f32>();
        (0..STEPS as isize).map(|i| sum(i) / total).collect()
    }

    /// The azimuth of a step.
    fn azimuth(&self, step: f32) -> f32 {
        let last = if self.is_open { STEPS - 1 } else { STEPS };
        self.first + self.whole * step / last as f32
    }

    /// The elevation there.
    fn elevation(&self, step: f32) -> f32 {
        let (below, part) = (step.floor(), step - step.floor());
        let at = |step: usize| match self.is_open {
            true => self.elevations[step.min(STEPS - 1)],
            false => self.elevations[step % STEPS],
        };
        let [below, above] = [below as usize, below as usize + 1].map(at);
        below + part * (above - below)
    }

    /// After this part of a full turn.
    pub(super) fn pose(&self, turn: f32) -> [f32; 16] {
        self.at(match self.between {
            Some([from, to]) => from + 0.5 * (1.0 - turn.cos()) * (to - from),
            None => turn / TAU * STEPS as f32,
        })
    }

    /// At a step.
    fn at(&self, step: f32) -> [f32; 16] {
        let direction = self.direction(self.azimuth(step), self.elevation(step));
        // Photographs from about there.
        let weight =
            |d: &Vec3| (-d.angle_between(direction).powi(2) / (2.0 * self.near.powi(2))).exp();
        let nearest = self.directions.iter().map(weight).fold(0.0, f32::max).max(1e-30);
        let weights: Vec<f32> = self.directions.iter().map(|d| weight(d) / nearest).collect();
        let total: f32 = weights.iter().sum();
        let weighed = |of: &dyn Fn(&Photograph) -> Vec3| {
            let pairs = self.photographs.iter().zip(&weights);
            pairs.map(|(photograph, weight)| *weight * of(photograph)).sum::<Vec3>() / total
        };
        match self.target {
            Some(target) => {
                let distance = weighed(&|p| Vec3::splat(p.position.distance(target))).x;
                pose(target + distance * direction, direction, self.up)
            }
            None => pose(weighed(&|p| p.position), direction, self.up),
        }
    }
}

/// The median angle to the nearest other direction.
fn usual_angle(directions: &[Vec3]) -> f32 {
    median_of_nearest(directions, |a, b| a.angle_between(b))
}
