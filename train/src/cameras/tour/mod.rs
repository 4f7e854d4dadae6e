//! A path that stays where photographs were taken: what lies elsewhere was hardly seen.

mod ellipse;
mod ring;
#[cfg(test)]
mod tests;
mod trail;

use std::f32::consts::TAU;

use glam::{Mat4, Vec3};

use super::{Pace, nearest_to_axes};
use ellipse::Ellipse;
use ring::Ring;
use trail::Trail;

/// Photographs that look in one direction, within about 20 degrees: the least length of their mean
/// axis.
const FORWARD: f32 = 0.97;
/// The least angle between the mean of what is up in photographs and an axis that is not up, cosine.
const UPRIGHT: f32 = 0.8;
/// A pose is among photographs if there is one within this angle of its axis, radians ...
const AMONG: f32 = 0.31;
/// ... and within so many usual distances from one to the next.
const SPACINGS: f32 = 1.2;

/// `n` poses (camera-to-world, at least one) of a smooth path that ends where it begins, among
/// photographs with these poses. Around what they look at, at the elevations and distances at which
/// they were taken; to and fro where they leave a side out; an ellipse where all of them look in
/// one direction; to and fro from photograph to photograph where they have no such order. `None` for fewer than three photographs.
#[must_use]
pub fn tour(photographs: &[[f32; 16]], n: usize, pace: Pace) -> Option<Vec<[f32; 16]>> {
    let photographs: Vec<Photograph> = photographs.iter().map(Photograph::new).collect();
    if photographs.len() < 3 {
        return None;
    }
    let up = up(&photographs)?;
    let turn = |i: usize| TAU * pace.at(i as f32 / n as f32);
    let back = mean(&photographs, |photograph| photograph.back);
    if back.length() > FORWARD {
        let ellipse = Ellipse::new(&photographs, back.normalize(), up);
        return Some((0..n).map(|i| ellipse.pose(turn(i))).collect());
    }
    if let Some(ring) = Ring::new(photographs.clone(), up) {
        return Some((0..n).map(|i| ring.pose(turn(i))).collect());
    }
    let trail = Trail::new(&photographs);
    Some((0..n).map(|i| trail.pose(turn(i))).collect())
}

/// A pose, in vectors.
#[derive(Clone, Copy)]
struct Photograph {
    position: Vec3,
    /// Away from what it shows.
    back: Vec3,
    up: Vec3,
}

impl Photograph {
    fn new(pose: &[f32; 16]) -> Self {
        let column = |c: usize| Vec3::new(pose[c], pose[4 + c], pose[8 + c]);
        Self {
            position: column(3),
            back: column(2).normalize_or_zero(),
            up: column(1).normalize_or_zero(),
        }
    }
}

fn mean(photographs: &[Photograph], of: impl Fn(&Photograph) -> Vec3) -> Vec3 {
    photographs.iter().map(of).sum::<Vec3>() / photographs.len() as f32
}

/// What is up in most photographs; the axis nearest to that, where it is near: cameras that look
/// down from one side lean.
fn up(photographs: &[Photograph]) -> Option<Vec3> {
    let mean = mean(photographs, |photograph| photograph.up).try_normalize()?;
    let axis = Vec3::AXES[mean.abs().max_position()];
    let axis = axis * mean.dot(axis).signum();
    Some(if mean.dot(axis) > UPRIGHT { axis } else { mean })
}

/// A pose that looks along `-back`, upright.
fn pose(position: Vec3, back: Vec3, up: Vec3) -> [f32; 16] {
    let right = up.cross(back).normalize_or(up.any_orthonormal_vector());
    let up = back.cross(right);
    let columns = [right.extend(0.0), up.extend(0.0), back.extend(0.0), position.extend(1.0)];
    let [a, b, c, d] = columns;
    Mat4::from_cols(a, b, c, d).transpose().to_cols_array()
}

/// The point that the photographs look at.
fn meeting(photographs: &[Photograph]) -> Option<Vec3> {
    let pose = |p: &Photograph| pose(p.position, p.back, p.up);
    let poses: Vec<[f32; 16]> = photographs.iter().map(pose).collect();
    nearest_to_axes(&poses).map(|point| point.as_vec3())
}

fn position(pose: &[f32; 16]) -> Vec3 {
    Vec3::new(pose[3], pose[7], pose[11])
}

fn back(pose: &[f32; 16]) -> Vec3 {
    Vec3::new(pose[2], pose[6], pose[10])
}

/// Whether a pose is near a photograph, where these are usually this far apart.
fn among(photographs: &[Photograph], spacing: f32, position: Vec3, back: Vec3) -> bool {
    photographs.iter().any(|photograph| {
        photograph.position.distance(position) <= SPACINGS * spacing
            && photograph.back.angle_between(back) <= AMONG
    })
}

/// The median distance of a photograph to the nearest other one.
fn spacing_of(photographs: &[Photograph]) -> f32 {
    let positions: Vec<Vec3> = photographs.iter().map(|p| p.position).collect();
    median_of_nearest(&positions, |a, b| a.distance(b))
}

fn median_of_nearest(all: &[Vec3], away: impl Fn(Vec3, Vec3) -> f32) -> f32 {
    let nearest = |i: usize| {
        let others = all.iter().enumerate().filter(|(j, _)| *j != i);
        others.map(|(_, other)| away(*other, all[i])).fold(f32::MAX, f32::min)
    };
    let mut nearest: Vec<f32> = (0..all.len()).map(nearest).collect();
    nearest.sort_by(f32::total_cmp);
    nearest[nearest.len() / 2]
}

/// The longest run of what is true.
fn longest_run(values: &[bool]) -> std::ops::Range<usize> {
    let (mut longest, mut begun) = (0..0, 0);
    for (i, is_true) in values.iter().chain([&false]).enumerate() {
        if !is_true {
            if i - begun > longest.len() {
                longest = begun..i;
            }
            begun = i + 1;
        }
    }
    longest
}
