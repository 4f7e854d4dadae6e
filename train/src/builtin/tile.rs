//! The pixels of a small square, and what can be seen in it.

use super::contents::{Contents, nearest};
use super::medium::{self, Passage};
use super::render::ray;
use super::shading::{SAMPLES, shade};
use super::shapes::{Hit, Shape};
use super::sky::sky;
use glam::{DVec3, DVec4};
use pocketnerf_core::Camera;
use std::borrow::Cow;

/// Where a pixel is sampled: 16 points of which no two share a row or a column
/// of a 16 × 16 grid. The first four do the same for a 4 × 4 grid.
const PATTERN: [[u8; 2]; SAMPLES] = [
    [1, 4],
    [7, 13],
    [8, 2],
    [14, 11],
    [0, 0],
    [2, 8],
    [3, 12],
    [4, 1],
    [5, 5],
    [6, 9],
    [9, 6],
    [10, 10],
    [11, 14],
    [12, 3],
    [13, 7],
    [15, 15],
];
/// Four samples whose colours lie closer than this stand for all sixteen.
const SPREAD: f64 = 0.02;

/// With more bodies than this, each pixel has a list of its own: fewer are sooner tried. The
/// frozen still life has fewer: a list would lose the pixel of `Contents::along_axes`.
const MANY: usize = 24;

/// A square of pixels and what can be seen in it.
pub(super) struct Tile<'a> {
    contents: &'a Contents,
    camera: &'a Camera,
    /// Indices of the bodies.
    bodies: Vec<usize>,
    /// Indices of the media.
    media: Vec<usize>,
    /// Whether something thin is among the bodies: four samples could all miss it.
    has_thin: bool,
}

/// All rays of a rectangle of a picture, and some more.
struct Cone {
    origin: DVec3,
    axis: DVec3,
    /// Of the angle between axis and side.
    cosine: f64,
    sine: f64,
}

/// What a ray meets.
struct Met {
    /// The first body.
    first: Option<(usize, Hit)>,
    /// What lies before it, in order.
    layers: Vec<Passage>,
}

impl<'a> Tile<'a> {
    /// The pixels from `low` up to `high`.
    pub(super) fn new(
        contents: &'a Contents,
        camera: &'a Camera,
        low: [usize; 2],
        high: [usize; 2],
    ) -> Self {
        let cone = Cone::new(camera, low.map(|x| x as f64), high.map(|x| x as f64));
        let Contents { bodies: all, media, .. } = contents;
        let bodies: Vec<_> = (0..all.len()).filter(|&i| cone.meets(&all[i].shape)).collect();
        let media = (0..media.len()).filter(|&i| cone.meets_ball(media[i].bound())).collect();
        let has_thin = bodies.iter().any(|&i| all[i].surface.is_thin());
        Self { contents, camera, bodies, media, has_thin }
    }

    /// Whether nothing can be seen in it.
    pub(super) fn is_empty(&self) -> bool {
        self.bodies.is_empty() && self.media.is_empty() && !self.contents.has_sky
    }

    /// Colour and depth of pixel (`x`, `y`).
    pub(super) fn pixel(&self, x: usize, y: usize) -> ([u8; 4], f32) {
        let (x, y) = (x as f64, y as f64);
        let all = &self.contents.bodies;
        let near = self.near(x, y);
        let (origin, direction) = self.ray(x + 0.5, y + 0.5);
        let centre = self.meet(&near, (origin, direction));

        let mut sum = DVec4::ZERO;
        let mut alike = !self.has_thin;
        let mut range = [DVec4::INFINITY, DVec4::NEG_INFINITY];
        let mut taken = 0;
        for (i, [dx, dy]) in PATTERN.iter().enumerate() {
            if i == 4 && alike && (range[1] - range[0]).max_element() < SPREAD {
                break;
            }
            let offset = |d: u8| (f64::from(d) + 0.5) / SAMPLES as f64;
            let (_, direction) = self.ray(x + offset(*dx), y + offset(*dy));
            let met = self.meet(&near, (origin, direction));
            let colour = self.colour(&met, (origin, direction), i);
            range = [range[0].min(colour), range[1].max(colour)];
            sum += colour;
            alike &= met.first.is_none_or(|(i, _)| !all[i].surface.is_fine());
            alike &= met.what() == centre.what();
            taken += 1;
        }
        let alpha = sum.w;
        if alpha == 0.0 {
            return ([0; 4], centre.depth());
        }
        let quantised = |x: f64| (x * 255.0 + 0.5) as u8;
        let [r, g, b] = (sum.truncate() / alpha).to_array().map(quantised);
        ([r, g, b, quantised(alpha / f64::from(taken))], centre.depth())
    }

    /// The ray through an image point.
    fn ray(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let (origin, direction) = ray(self.camera, x, y);
        (origin, self.contents.off_axes(direction))
    }

    /// Indices of the bodies that may be seen in a pixel.
    fn near(&self, x: f64, y: f64) -> Cow<'_, [usize]> {
        if self.bodies.len() <= MANY {
            return Cow::Borrowed(&self.bodies);
        }
        let cone = Cone::new(self.camera, [x, y], [x + 1.0, y + 1.0]);
        let meets = |&i: &usize| cone.meets(&self.contents.bodies[i].shape);
        self.bodies.iter().copied().filter(meets).collect()
    }

    /// What a ray meets, of the bodies `near` it.
    fn meet(&self, near: &[usize], (origin, direction): (DVec3, DVec3)) -> Met {
        let Contents { bodies, media, .. } = self.contents;
        let first = nearest(bodies, near.iter().copied(), origin, direction);
        let until = first.map_or(f64::INFINITY, |(_, hit)| hit.t);
        let through = |&i: &usize| media[i].passage(origin, direction, until);
        let mut layers: Vec<_> = self.media.iter().filter_map(through).collect();
        medium::sort(&mut layers);
        Met { first, layers }
    }

    /// Premultiplied colour, and opacity; `sample` chooses the lamp's point.
    fn colour(&self, met: &Met, (origin, direction): (DVec3, DVec3), sample: usize) -> DVec4 {
        let behind = match met.first {
            Some((body, hit)) => (shade(self.contents, body, hit, origin, direction, sample), 1.0),
            None if self.contents.has_sky => (sky(direction), 1.0),
            None => (DVec3::ZERO, 0.0),
        };
        let (colour, alpha) = medium::composite(&met.layers, behind);
        colour.extend(alpha)
    }
}

impl Met {
    /// Which body, and how many layers before it.
    fn what(&self) -> (Option<usize>, usize) {
        (self.first.map(|(body, _)| body), self.layers.len())
    }

    /// Where transmittance falls to one half.
    fn depth(&self) -> f32 {
        let surface = || self.first.map(|(_, hit)| hit.t);
        medium::half_way(&self.layers).or_else(surface).map_or(f32::INFINITY, |t| t as f32)
    }
}

impl Cone {
    /// Around the image points from `low` to `high`, pixels.
    fn new(camera: &Camera, low: [f64; 2], high: [f64; 2]) -> Self {
        let middle = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
        let (origin, axis) = ray(camera, middle[0], middle[1]);
        // A corner's cosine, the smallest of all.
        let cosine = [[low[0], low[1]], [high[0], low[1]], [low[0], high[1]], [high[0], high[1]]]
            .iter()
            .map(|c| ray(camera, c[0], c[1]).1.dot(axis))
            .fold(1.0, f64::min);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        Self { origin, axis, cosine, sine }
    }

    /// Whether one of the balls around a solid reaches into it.
    fn meets(&self, shape: &Shape) -> bool {
        (0..shape.parts()).any(|part| self.meets_ball(shape.bound(part)))
    }

    fn meets_ball(&self, (center, radius): (DVec3, f64)) -> bool {
        let towards = center - self.origin;
        let distance = towards.length();
        if distance <= radius {
            return true;
        }
        let ball_sine = radius / distance;
        let ball_cosine = (1.0 - ball_sine * ball_sine).sqrt();
        let limit = self.cosine * ball_cosine - self.sine * ball_sine;
        towards.dot(self.axis) >= distance * limit
    }
}
