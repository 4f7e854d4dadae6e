//! Colours of a mesh: what cameras see of each vertex.

use glam::Vec3;
use rayon::prelude::*;

use super::look::Seen;
use super::mesh::Mesh;

/// Vertices that no camera sees take the colour of their neighbours, so many triangles far.
const SPREAD: usize = 16;

/// The mean of what is seen of each vertex, straight views counting most; `near` is how far from
/// it what a camera sees may lie.
pub(super) fn paint(mesh: &mut Mesh, seen: &[Seen], near: f32) {
    let vertices = mesh.positions.par_iter().zip(&mesh.normals);
    let mut colors: Vec<Option<Vec3>> = vertices
        .map(|(position, normal)| color(Vec3::from(*position), Vec3::from(*normal), seen, near))
        .collect();
    for _ in 0..SPREAD {
        if !spread(&mut colors, &mesh.triangles) {
            break;
        }
    }
    mesh.colors = colors
        .into_iter()
        .map(|color| color.unwrap_or(Vec3::splat(127.5)).round().to_array().map(|c| c as u8))
        .collect();
}

/// The mean of what is seen of a point, sRGB from 0 to 255; `None` where no camera sees it.
pub(super) fn color(position: Vec3, normal: Vec3, seen: &[Seen], near: f32) -> Option<Vec3> {
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for seen in seen {
        let way = Vec3::from(seen.camera.position()) - position;
        let (away, facing) = (way.length(), way.normalize_or_zero().dot(normal));
        if facing <= 0.0 {
            continue;
        }
        let Some((depth, pixel)) = seen.towards(position, near) else { continue };
        if (depth - away).abs() <= near {
            let weight = (facing * seen.camera.focal[0] / away).powi(2);
            sum += weight * Vec3::from(seen.color[pixel].map(f32::from));
            weights += weight;
        }
    }
    (weights > 0.0).then(|| sum / weights)
}

/// Colours vertices without a colour as those around; whether any were.
fn spread(colors: &mut [Option<Vec3>], triangles: &[[u32; 3]]) -> bool {
    let mut around = vec![(Vec3::ZERO, 0.0_f32); colors.len()];
    for triangle in triangles {
        let corners = triangle.map(|vertex| vertex as usize);
        if corners.iter().all(|vertex| colors[*vertex].is_some()) {
            continue;
        }
        for color in corners.iter().filter_map(|vertex| colors[*vertex]) {
            for vertex in corners {
                around[vertex].0 += color;
                around[vertex].1 += 1.0;
            }
        }
    }
    let mut any = false;
    for (color, (sum, n)) in colors.iter_mut().zip(around) {
        if color.is_none() && n > 0.0 {
            *color = Some(sum / n);
            any = true;
        }
    }
    any
}
