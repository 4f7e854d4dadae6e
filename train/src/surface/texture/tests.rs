use glam::{Vec2, Vec3};

use super::pack::GUTTER;
use super::{Texture, TooManyCharts, bake};
use crate::random::Random;
use crate::surface::Mesh;
use crate::surface::shapes::{ball, mesh, strip};

/// Red, green and blue grow with x, y and z.
fn analytic(p: Vec3) -> Vec3 {
    127.5 * (p + 1.0)
}

fn baked(mesh: &Mesh, size: u32) -> Texture {
    bake(mesh, size, |p, _| Some(analytic(p)), |_| {}).unwrap()
}

fn texels(texture: &Texture, triangle: usize) -> [Vec2; 3] {
    let place = |corner: u32| Vec2::from(texture.corners[corner as usize].uv);
    texture.triangles[triangle].map(|corner| place(corner) * texture.size as f32)
}

/// What a bilinear filter gives.
fn sample(texture: &Texture, texels: Vec2) -> Vec3 {
    let size = texture.size as usize;
    let at = |x: f32, y: f32| {
        let [x, y] = [x, y].map(|x| (x.max(0.0) as usize).min(size - 1));
        let rgb: [u8; 3] = texture.rgb[3 * (y * size + x)..][..3].try_into().unwrap();
        Vec3::from(rgb.map(f32::from))
    };
    let first = (texels - 0.5).floor();
    let share = texels - 0.5 - first;
    let row = |y: f32| at(first.x, y).lerp(at(first.x + 1.0, y), share.x);
    row(first.y).lerp(row(first.y + 1.0), share.y)
}

/// The chart of each triangle: those that share a corner are in one.
fn charts(texture: &Texture) -> Vec<u32> {
    let mut of: Vec<u32> = (0..texture.corners.len() as u32).collect();
    loop {
        let before = of.clone();
        for corners in texture.triangles.iter().map(|t| t.map(|corner| corner as usize)) {
            let least = corners.map(|corner| of[corner]).into_iter().min().unwrap();
            corners.iter().for_each(|corner| of[*corner] = least);
        }
        if of == before {
            return texture.triangles.iter().map(|t| of[t[0] as usize]).collect();
        }
    }
}

/// Every triangle lies in the image, none covers another, and charts keep apart from each other.
fn check_layout(mesh: &Mesh, texture: &Texture) {
    let size = texture.size as usize;
    assert!(texture.corners.iter().flat_map(|c| c.uv).all(|x| (0.0..=1.0).contains(&x)));
    for (corners, vertices) in texture.triangles.iter().zip(&mesh.triangles) {
        assert_eq!(corners.map(|corner| texture.corners[corner as usize].vertex), *vertices);
    }
    let charts = charts(texture);
    let mut distinct = charts.clone();
    distinct.sort_unstable();
    distinct.dedup();
    assert_eq!(distinct.len(), texture.charts);
    let mut shown: Vec<Option<u32>> = vec![None; size * size];
    for (triangle, chart) in charts.iter().enumerate() {
        let [a, b, c] = texels(texture, triangle);
        // Seen from outside, y down.
        let area = (b - a).perp_dot(c - a);
        assert!(area < 0.0, "triangle {triangle} is turned over: {area}");
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        for y in low.y as usize..(high.y as usize + 1).min(size) {
            for x in low.x as usize..(high.x as usize + 1).min(size) {
                let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let inside = |from: Vec2, to: Vec2| {
                    (to - from).perp_dot(p - from) < -0.02 * (to - from).length()
                };
                if inside(a, b) && inside(b, c) && inside(c, a) {
                    let before = shown[y * size + x].replace(*chart);
                    assert_eq!(before, None, "two triangles at {x}, {y}");
                }
            }
        }
    }
    let gutter = 2 * GUTTER as usize;
    for i in (0..size * size).filter(|i| shown[*i].is_some()) {
        let (x, y) = (i % size, i / size);
        for near in y..(y + gutter).min(size) {
            let row = &shown[near * size..][x.saturating_sub(gutter - 1)..(x + gutter).min(size)];
            assert!(row.iter().flatten().all(|chart| Some(*chart) == shown[i]), "at {x}, {y}");
        }
    }
}

#[test]
fn a_texture_has_the_colours_of_the_surface() {
    let mesh = ball(3);
    let texture = baked(&mesh, 256);
    check_layout(&mesh, &texture);
    // A ball faces each axis once.
    assert_eq!(texture.charts, 6);
    assert!(texture.used > 0.4, "{}", texture.used);
    // A texel is about 0.02 wide: 2.5 levels.
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(*triangle);
        let places = texels(&texture, number);
        let middle = sample(&texture, (places[0] + places[1] + places[2]) / 3.0);
        let off = (middle - analytic((a + b + c) / 3.0)).abs().max_element();
        assert!(off < 3.0, "{off}");
        // At seams the filter reads what lies beyond them.
        for (place, corner) in places.into_iter().zip([a, b, c]) {
            let off = (sample(&texture, place) - analytic(corner)).abs().max_element();
            assert!(off < 5.0, "{off}");
        }
    }
}

#[test]
fn few_triangles_keep_fine_colours_in_a_texture() {
    let stripes = |p: Vec3| Vec3::splat(127.5 + 127.5 * (20.0 * p.z).sin());
    let mut mesh = ball(2);
    for (color, p) in mesh.colors.iter_mut().zip(&mesh.positions) {
        *color = stripes(Vec3::from(*p)).to_array().map(|c| c as u8);
    }
    let texture = bake(&mesh, 512, |p, _| Some(stripes(p)), |_| {}).unwrap();
    let mut random = Random::new(0, [0; 3]);
    let (mut of_texture, mut of_vertices) = (0.0, 0.0);
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        let (u, v) = (random.next_f32(), random.next_f32());
        let shares = [1.0 - u.max(v), u.min(v), (u - v).abs()];
        let mean = |of: [Vec3; 3]| (0..3).map(|i| shares[i] * of[i]).sum::<Vec3>();
        let truth = stripes(mean(mesh.corners(*triangle)));
        let colors = triangle.map(|vertex| Vec3::from(mesh.colors[vertex as usize].map(f32::from)));
        let place = mean(texels(&texture, number).map(|p| p.extend(0.0))).truncate();
        of_texture += (sample(&texture, place) - truth).x.abs();
        of_vertices += (mean(colors) - truth).x.abs();
    }
    assert!(of_texture < 0.1 * of_vertices, "{of_texture} {of_vertices}");
}

#[test]
fn what_winds_over_itself_is_cut() {
    // A ramp that turns twice around z: from above, each turn covers the other.
    let mesh = strip(64, 2, |along, across| {
        let turned = Vec2::from_angle(-along / 64.0 * 2.0 * std::f32::consts::TAU);
        ((1.0 + 0.25 * across) * turned).extend(0.01 * along)
    });
    let texture = baked(&mesh, 256);
    check_layout(&mesh, &texture);
    assert!((2..=4).contains(&texture.charts), "{}", texture.charts);
}

#[test]
fn texels_that_no_camera_sees_are_filled() {
    let mut mesh = strip(4, 4, |x, y| Vec3::new(y, x, 0.0) / 4.0);
    mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
    mesh.colors.fill([0, 255, 0]);
    let red = Vec3::new(255.0, 0.0, 0.0);
    let texture = bake(&mesh, 256, |p, _| (p.x < 0.5).then_some(red), |_| {}).unwrap();
    check_layout(&mesh, &texture);
    let at = |x: f32, y: f32| sample(&texture, place(&mesh, &texture, x, y)).to_array();
    // What is near has its neighbours' colour, 16 of about 250 texels far; the rest its vertices'.
    assert_eq!([at(0.2, 0.5), at(0.52, 0.5)], [red.to_array(); 2]);
    assert_eq!(at(0.7, 0.5), [0.0, 255.0, 0.0]);
    // Nothing is left over, in gutters neither.
    let is_filled = |[r, g, b]: &[u8; 3]| *b == 0 && u16::from(*r) + u16::from(*g) >= 254;
    assert!(texture.rgb.as_chunks::<3>().0.iter().all(is_filled));
}

/// Where a flat square shows a point.
fn place(mesh: &Mesh, texture: &Texture, x: f32, y: f32) -> Vec2 {
    let corner = |x: f32, y: f32| {
        let is_here =
            |corner: &&super::Corner| mesh.positions[corner.vertex as usize] == [x, y, 0.0];
        Vec2::from(texture.corners.iter().find(is_here).unwrap().uv) * texture.size as f32
    };
    let origin = corner(0.0, 0.0);
    origin + x * (corner(1.0, 0.0) - origin) + y * (corner(0.0, 1.0) - origin)
}

#[test]
fn more_charts_than_there_is_room_for() {
    // Apart from each other, each takes a texel and its gutters: 5x5 of 256x256, 51 rows of 51.
    let apart = |n: u32| {
        let places: Vec<Vec3> = (0..3 * n)
            .map(|i| {
                Vec3::new((i / 3) as f32, (i % 3 == 1) as u32 as f32, (i % 3 == 2) as u32 as f32)
            })
            .collect();
        let triangles = (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        mesh(&places, &vec![Vec3::X; places.len()], triangles)
    };
    let nothing = |_: Vec3, _: Vec3| None;
    let refused = bake(&apart(2_602), 256, nothing, |_| {}).unwrap_err();
    assert_eq!(refused, TooManyCharts { charts: 2_602, size: 256 });
    assert_eq!(
        refused.to_string(),
        "2602 charts do not fit into a texture of 256x256 texels; give a larger one, or fewer triangles"
    );
    let texture = bake(&apart(500), 256, nothing, |_| {}).unwrap();
    assert_eq!(texture.charts, 500);
    // All that is known of them is their vertices' grey.
    assert!(texture.rgb.iter().all(|c| *c == 128));
}
