//! What each texel shows.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::Texture;
use super::flat::bounds;
use super::spread::{Texel, UNKNOWN, known, spread};
use crate::surface::Mesh;

/// Texels of no triangle.
const NONE: u32 = u32::MAX;
/// Rows that are baked at once.
const BAND: usize = 64;
/// Texels that no camera sees take the colour of their neighbours in the chart, so many texels far.
const SPREAD: usize = 16;

/// Fills the image, gutters and all, and says how much of it shows the surface.
pub(super) fn colors(
    texture: &mut Texture,
    mesh: &Mesh,
    color: impl Fn(Vec3, Vec3) -> Option<Vec3> + Sync,
    mut each: impl FnMut(usize),
) {
    let size = texture.size as usize;
    let owners = owners(texture);
    let mut texels = vec![UNKNOWN; owners.len()];
    let bands = texels.chunks_mut(BAND * size).zip(owners.chunks(BAND * size));
    for (band, (texels, owners)) in bands.enumerate() {
        texels.par_iter_mut().zip(owners).enumerate().for_each(|(i, (texel, owner))| {
            if *owner != NONE {
                let center = center(band * BAND * size + i, size);
                let shares = shares(texture, *owner, center);
                let corners = mesh.triangles[*owner as usize].map(|vertex| vertex as usize);
                let mean = |of: [Vec3; 3]| (0..3).map(|i| shares[i] * of[i]).sum::<Vec3>();
                let position = mean(corners.map(|vertex| mesh.positions[vertex].into()));
                let normal = mean(corners.map(|vertex| mesh.normals[vertex].into()));
                if let Some(color) = color(position, normal.normalize_or_zero()) {
                    *texel = known(color);
                }
            }
        });
        each(((band + 1) * BAND).min(size));
    }
    spread(&mut texels, size, SPREAD, |i| owners[i] != NONE);
    texels.par_iter_mut().zip(&owners).enumerate().for_each(|(i, (texel, owner))| {
        if *texel == UNKNOWN && *owner != NONE {
            let shares = shares(texture, *owner, center(i, size));
            let colors = mesh.triangles[*owner as usize].map(|v| mesh.colors[v as usize]);
            let sum = |i: usize| shares[i] * Vec3::from(colors[i].map(f32::from));
            *texel = known((0..3).map(sum).sum());
        }
    });
    let used = owners.iter().filter(|owner| **owner != NONE).count();
    texture.used = used as f64 / owners.len() as f64;
    spread(&mut texels, size, usize::MAX, |_| true);
    texture.rgb = texels.iter().flat_map(|[r, g, b, _]: &Texel| [*r, *g, *b]).collect();
}

fn center(texel: usize, size: usize) -> Vec2 {
    Vec2::new((texel % size) as f32 + 0.5, (texel / size) as f32 + 0.5)
}

/// The corners of a triangle, texels.
fn place(texture: &Texture, triangle: [u32; 3]) -> [Vec2; 3] {
    triangle.map(|corner| Vec2::from(texture.corners[corner as usize].uv) * texture.size as f32)
}

/// The triangle that each texel shows: the one in which its centre lies. Triangles between centres
/// have the texel in which their own middle lies, if no other has it.
fn owners(texture: &Texture) -> Vec<u32> {
    let size = texture.size as usize;
    let mut owners = vec![NONE; size * size];
    for (number, triangle) in (0..).zip(&texture.triangles) {
        let [a, b, c] = place(texture, *triangle);
        let [low, high] = bounds(&[a, b, c]).map(|p| p.round().to_array().map(|x| x as usize));
        for i in (low[1]..high[1]).flat_map(|y| (low[0]..high[0]).map(move |x| y * size + x)) {
            let p = center(i, size);
            let sides = [(a, b), (b, c), (c, a)].map(|(p0, p1)| (p1 - p0).perp_dot(p - p0));
            // Seen from outside, y down, corners are in clockwise order as numbers have it.
            if owners[i] == NONE && sides.iter().all(|side| *side <= 0.0) {
                owners[i] = number;
            }
        }
    }
    for (number, triangle) in (0..).zip(&texture.triangles) {
        let [a, b, c] = place(texture, *triangle);
        let [x, y] = ((a + b + c) / 3.0).to_array().map(|x| x as usize);
        let owner = &mut owners[y * size + x];
        if *owner == NONE {
            *owner = number;
        }
    }
    owners
}

/// The shares of a triangle's corners at a point: inside of it, barycentric coordinates.
fn shares(texture: &Texture, triangle: u32, p: Vec2) -> [f32; 3] {
    let [a, b, c] = place(texture, texture.triangles[triangle as usize]);
    let shares = [(b, c), (c, a), (a, b)].map(|(p0, p1)| (p1 - p0).perp_dot(p - p0).min(0.0));
    let sum: f32 = shares.iter().sum();
    if sum < 0.0 { shares.map(|share| share / sum) } else { [1.0 / 3.0; 3] }
}
