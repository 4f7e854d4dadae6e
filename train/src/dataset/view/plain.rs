//! Photographs before a plain background, as of products on white: the background is empty.
//!
//! Opaque photographs do not say where the object ends. Where all around the edge of the pictures
//! is one colour, what of that colour is connected with the edge is taken for empty. What clearly
//! has another colour is the object. Of all else, such as outlines, holes and white parts on white,
//! nothing is claimed. Claims may be wrong in some views, and training takes them as such.

use std::collections::VecDeque;

use rayon::prelude::*;

use crate::dataset::{Dataset, View};

/// Pixels from the edge that tell the colour.
const EDGE: usize = 2;
/// Deviation from the colour that a plain background has at most, of 255: noise, and the traces
/// of JPEG.
const MOST: u8 = 16;
/// Deviation that is allowed in any case.
const LEAST: u8 = 2;
/// Share of a view's edge that must have the colour; the object may reach over the rest.
const OF_EDGE: f64 = 0.9;
/// Share of the views that must be like this, and agree.
const OF_VIEWS: f64 = 0.9;
/// How far the colours of two views may be apart, of 255: exposures differ.
const APART: u8 = 24;
/// Connected pixels of other colours that are no more than this are noise.
const SPECK: usize = 4;

/// Alpha of a pixel of which nothing is claimed.
pub(crate) const UNCLAIMED: u8 = 254;
/// What differs from the background by so many times its deviation is the object.
const CLEARLY: u8 = 3;

/// The edge of a view.
#[derive(Clone, Copy, Debug)]
struct Edge {
    color: [u8; 3],
    /// Deviation that nearly all of the edge keeps to.
    tolerance: u8,
    is_plain: bool,
}

impl Dataset {
    /// Cuts out what opaque photographs show, where their background is plain: alpha becomes 0
    /// where the background is, 255 where the object is, and 254 where either may be; colours stay
    /// as they are, and [`View::behind`] has the view's own background. Gives that of all, sRGB; `None`, and
    /// nothing changes, where the background is not plain, and where it has not the colour
    /// `expected`.
    pub fn cut_out(&mut self, expected: Option<[f32; 3]>) -> Option<[f32; 3]> {
        if self.has_alpha || self.forward_facing || self.views.is_empty() {
            return None;
        }
        let edges: Vec<Edge> = self.views.par_iter().map(Edge::of).collect();
        let plain: Vec<&Edge> = edges.iter().filter(|edge| edge.is_plain).collect();
        let middle = [0, 1, 2].map(|c| median(plain.iter().map(|edge| edge.color[c])));
        let like = |color: &[u8; 3]| off(color, &middle) <= APART;
        let agree = plain.iter().filter(|edge| like(&edge.color)).count();
        if (agree as f64) < OF_VIEWS * self.views.len() as f64 {
            return None;
        }
        let found = middle.map(|value| f32::from(value) / 255.0);
        let apart = f32::from(APART) / 255.0;
        if expected.is_some_and(|color| (0..3).any(|c| (color[c] - found[c]).abs() > apart)) {
            return None;
        }
        let usual = Edge {
            color: middle,
            tolerance: median(plain.iter().map(|edge| edge.tolerance)),
            is_plain: true,
        };
        self.views.par_iter_mut().zip(&edges).for_each(|(view, edge)| {
            let own = edge.is_plain && like(&edge.color);
            view.cut_out(if own { edge } else { &usual });
        });
        (self.has_alpha, self.background) = (true, Some(found));
        Some(found)
    }
}

impl Edge {
    fn of(view: &View) -> Self {
        let pixels: Vec<[u8; 3]> = edge(view).map(|i| rgb(view, i)).collect();
        let color = [0, 1, 2].map(|c| median(pixels.iter().map(|pixel| pixel[c])));
        let mut offs: Vec<u8> = pixels.iter().map(|pixel| off(pixel, &color)).collect();
        offs.retain(|off| *off <= MOST);
        offs.sort_unstable();
        let is_plain = !pixels.is_empty() && offs.len() as f64 >= OF_EDGE * pixels.len() as f64;
        // Nearly all: what is left of the object's shadow must not widen it.
        let most = offs.get(offs.len().saturating_sub(1 + offs.len() / 50));
        let tolerance = most.map_or(LEAST, |most| most.saturating_add(LEAST).min(MOST));
        Self { color, tolerance, is_plain }
    }
}

impl View {
    /// Takes what is connected with the edge and has its colour for the background.
    fn cut_out(&mut self, behind: &Edge) {
        let (width, height) = (self.camera.width as usize, self.camera.height as usize);
        let has_color = |i: usize| off(&rgb(self, i), &behind.color) <= behind.tolerance;
        let mut empty = vec![false; width * height];
        let from: Vec<usize> = edge(self).filter(|i| has_color(*i)).collect();
        fill(from, &mut empty, |i| sides(i, width, height), has_color);
        let mut seen = empty.clone();
        for i in 0..seen.len() {
            if !seen[i] {
                let speck = fill(vec![i], &mut seen, |i| around(i, width, height), |_| true);
                if speck.len() <= SPECK {
                    speck.into_iter().for_each(|i| empty[i] = true);
                }
            }
        }
        for (i, is_empty) in empty.iter().enumerate() {
            let beside = || around(i, width, height).flat_map(|j| around(j, width, height));
            let clearly = CLEARLY.saturating_mul(behind.tolerance);
            let is_object = || off(&rgb(self, i), &behind.color) > clearly;
            self.rgba[4 * i + 3] = match is_empty {
                true => 0,
                false if is_object() && beside().all(|j| !empty[j]) => 255,
                false => UNCLAIMED,
            };
        }
        self.behind = Some(behind.color.map(|value| f32::from(value) / 255.0));
    }
}

/// Numbers of the pixels at the edge of a view that count.
fn edge(view: &View) -> impl Iterator<Item = usize> {
    let (width, height) = (view.camera.width as usize, view.camera.height as usize);
    let (inner_x, inner_y) = (EDGE..width.saturating_sub(EDGE), EDGE..height.saturating_sub(EDGE));
    let pixels = (0..height).flat_map(move |y| (0..width).map(move |x| [x, y]));
    pixels
        .filter(move |[x, y]| !(inner_x.contains(x) && inner_y.contains(y)))
        .map(move |[x, y]| y * width + x)
        .filter(|i| view.mask.as_ref().is_none_or(|mask| mask[*i] != 0))
}

fn rgb(view: &View, i: usize) -> [u8; 3] {
    [0, 1, 2].map(|c| view.rgba[4 * i + c])
}

/// The largest difference of a channel.
fn off(a: &[u8; 3], b: &[u8; 3]) -> u8 {
    (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0)
}

fn median(values: impl Iterator<Item = u8>) -> u8 {
    let mut values: Vec<u8> = values.collect();
    values.sort_unstable();
    values.get(values.len() / 2).copied().unwrap_or(0)
}

/// Marks what is reached from some pixels through those that `counts`, and gives it.
fn fill<N: IntoIterator<Item = usize>>(
    from: Vec<usize>,
    marks: &mut [bool],
    neighbours: impl Fn(usize) -> N,
    counts: impl Fn(usize) -> bool,
) -> Vec<usize> {
    from.iter().for_each(|i| marks[*i] = true);
    let (mut next, mut reached) = (VecDeque::from(from.clone()), from);
    while let Some(i) = next.pop_front() {
        for neighbour in neighbours(i) {
            if !marks[neighbour] && counts(neighbour) {
                marks[neighbour] = true;
                reached.push(neighbour);
                next.push_back(neighbour);
            }
        }
    }
    reached
}

/// The pixels that share a side with one.
fn sides(i: usize, width: usize, height: usize) -> impl Iterator<Item = usize> {
    around(i, width, height).filter(move |j| i % width == j % width || i / width == j / width)
}

/// The pixels that touch one.
fn around(i: usize, width: usize, height: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (i % width, i / width);
    let along = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
    let rows = along(y, height);
    rows.flat_map(move |v| along(x, width).map(move |u| v * width + u)).filter(move |j| *j != i)
}

#[cfg(test)]
mod tests {
    use pocketnerf_core::Camera;

    use super::*;
    use crate::builtin::Scene;
    use crate::dataset::Split;

    /// Pictures of 20x20 pixels of `at(view, x, y)`.
    fn dataset(at: impl Fn(usize, usize, usize) -> [u8; 3]) -> Dataset {
        let pose = Camera::look_at([4.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let view = |v: usize| {
            let pixels = (0..400).flat_map(|i| {
                let [r, g, b] = at(v, i % 20, i / 20);
                [r, g, b, 255]
            });
            View::new("", Camera::from_fov_x(20, 20, 0.7, pose), pixels.collect())
        };
        Dataset::new("", "", Split::Train, (0..10).map(view).collect())
    }

    /// A frame on white with noise; a speck beside it.
    fn framed(_: usize, x: usize, y: usize) -> [u8; 3] {
        let (inside, hole) = (4..16, 8..12);
        match (inside.contains(&x) && inside.contains(&y), hole.contains(&x) && hole.contains(&y)) {
            (true, false) => [40, 60, 200],
            _ if [x, y] == [2, 17] => [100; 3],
            _ => [253 + ((x + y) % 3) as u8; 3],
        }
    }

    #[test]
    fn what_is_around_the_object_becomes_transparent() {
        let mut dataset = dataset(framed);
        let found = dataset.cut_out(None).unwrap();
        assert_eq!(dataset.background, Some(found));
        assert!(dataset.has_alpha && found.iter().all(|c| (c - 254.0 / 255.0).abs() < 1e-6));
        for view in &dataset.views {
            assert_eq!(view.behind, Some(found));
            for (i, pixel) in view.rgba.chunks_exact(4).enumerate() {
                // The frame is four pixels wide, the outer two may be its outline; the hole has
                // the background's colour.
                let (x, y) = (i % 20, i / 20);
                let at = |first: usize, end: usize| {
                    (first..end).contains(&x) && (first..end).contains(&y)
                };
                let expected = match (at(4, 16), at(6, 14), at(8, 12)) {
                    (false, ..) => 0,
                    (_, true, false) => 255,
                    _ => UNCLAIMED,
                };
                assert_eq!(pixel[3], expected, "{x} {y}");
                assert_eq!(pixel[..3], framed(0, i % 20, i / 20));
            }
        }
    }

    #[test]
    fn what_is_not_plain_stays_as_it_is() {
        let unchanged = |mut dataset: Dataset, expected| {
            let before = dataset.fingerprint();
            assert_eq!(dataset.cut_out(expected), None);
            assert_eq!(dataset.fingerprint(), before);
            assert!(!dataset.has_alpha);
        };
        // A slope; a different colour in each view; another colour than is expected.
        unchanged(dataset(|_, x, y| [(5 * x + 3 * y) as u8; 3]), None);
        unchanged(dataset(|v, _, _| [25 * v as u8; 3]), None);
        unchanged(dataset(framed), Some([0.0; 3]));
        unchanged(Scene::Room.dataset(Split::Train, 8), None);
    }
}
