//! The same pictures, to the byte.

use std::ptr::null_mut;

use pocketnerf_c::{
    Alpha, Camera, DepthKind, Format, Image, Memory, OPEN_BORROWED, OPEN_MODEL_COORDINATES,
    OPEN_UNVERIFIED, OPEN_WITHOUT_TABLE, Options, Simd, Stats, Tile, pnrf_render, pnrf_render_tile,
    pnrf_tile, pnrf_tile_count,
};
use pocketnerf_core::reference::render_pixel;
use pocketnerf_core::render::Tiles;
use pocketnerf_core::{
    Camera as CoreCamera, ColorSpace, Display, Model, RenderOptions, SimdLevel, Tuning, pixel,
    render_tile,
};
use pocketnerf_formats::{Precision, open, pack, write};

use crate::{GOLDEN, NOTHING, Open, STILL_LIFE, done, usual_options};

const BACKGROUND: [f32; 3] = [0.25, 0.5, 0.75];

/// Renders as a Rust program would: premultiplied pixels, and distances where wanted, for
/// which more pixels are rendered.
fn picture(
    model: &Model<'_>,
    camera: &CoreCamera,
    quality: f32,
    far: bool,
) -> (Vec<[f32; 4]>, Vec<f32>) {
    let options = RenderOptions {
        detail: model.detail(quality),
        ..RenderOptions::new(model, SimdLevel::detect(), Tuning::FAST)
    };
    let n = (camera.width * camera.height) as usize;
    let (mut all, mut depths) = (vec![[0.0; 4]; n], vec![0.0; n]);
    let mut scratch = vec![0.0; options.scratch_len()];
    for tile in Tiles::new(camera.width, camera.height) {
        let (mut rgba, mut depth) = (vec![0.0; 4 * tile.pixels()], vec![0.0; tile.pixels()]);
        let (to, far) = (&mut rgba, far.then_some(&mut depth[..]));
        render_tile(model, camera, tile, &options, &mut scratch, to, far).unwrap();
        for y in 0..tile.height {
            let at = ((tile.y + y) * camera.width + tile.x) as usize;
            let (row, width) = ((y * tile.width) as usize, tile.width as usize);
            all[at..at + width].copy_from_slice(&rgba.as_chunks().0[row..row + width]);
            depths[at..at + width].copy_from_slice(&depth[row..row + width]);
        }
    }
    (all, depths)
}

fn core_camera(camera: &Camera) -> CoreCamera {
    let Camera { width, height, focal, center, camera_to_world } = *camera;
    CoreCamera { width, height, focal, center, camera_to_world }
}

fn render(model: &Open, camera: &Camera, options: &Options, image: &Image) -> Stats {
    let (mut scratch, mut stats) = (model.scratch(options), Stats::default());
    let (at, length) = (scratch.as_mut_ptr(), scratch.len());
    done(|error| unsafe {
        pnrf_render(model.0, camera, options, image, at, length, &raw mut stats, error)
    });
    stats
}

/// Bytes of an image in this format and alpha, without gaps.
pub(crate) fn bytes_of(model: &Open, camera: &Camera, options: &Options, image: Image) -> Vec<u8> {
    let pixel = if image.format == Format::RgbaF32 as u32 { 16 } else { 4 };
    let mut bytes = vec![0xa5; pixel * (camera.width * camera.height) as usize];
    let image = Image { pixels: bytes.as_mut_ptr().cast(), size: bytes.len(), ..image };
    render(model, camera, options, &image);
    bytes
}

#[test]
fn pictures_are_those_of_the_rust_crates_in_every_format() {
    let golden = open(GOLDEN).unwrap();
    let linear = Display { color_space: ColorSpace::Linear, ..golden.model.display };
    let linear = Model { display: linear, ..golden.model };
    let linear = write(&linear, &golden.about, Precision::F16).unwrap();
    for (bytes, size) in [(GOLDEN, [61, 47]), (STILL_LIFE, [150, 130]), (&linear, [61, 47])] {
        let (model, file) = (Open::new(bytes, 0), open(bytes).unwrap());
        let camera = model.camera(size[0], size[1]);
        let in_model = file.about.scene.camera_to_model(&core_camera(&camera));
        for quality in [0.5, 1.0] {
            let options = Options { quality, ..usual_options() };
            let (rgba, _) = picture(&file.model, &in_model, quality, false);
            assert!(rgba.iter().any(|p| p[3] > 0.5));
            // What is behind, by hand: 0.25, 0.5 and 0.75 of 255, and the same as linear light.
            let behind = match file.model.display.color_space {
                ColorSpace::Linear => [137, 188, 225, 255],
                _ => [64, 128, 191, 255],
            };
            let empty = rgba.iter().position(|p| p[3] == 0.0).unwrap();
            for alpha in [Alpha::Background, Alpha::Premultiplied, Alpha::Straight] {
                let shown = |p: &[f32; 4]| match alpha {
                    Alpha::Background => {
                        let [r, g, b] = pixel::over(*p, BACKGROUND);
                        [r, g, b, 1.0]
                    }
                    Alpha::Premultiplied => *p,
                    Alpha::Straight => pixel::straight(*p),
                };
                let shown: Vec<[f32; 4]> = rgba.iter().map(shown).collect();
                let image = |format: Format| Image {
                    format: format as u32,
                    alpha: alpha as u32,
                    background: BACKGROUND,
                    ..NOTHING
                };
                let found = |format| bytes_of(&model, &camera, &options, image(format));
                let space = file.model.display.color_space;
                let expected: Vec<u8> =
                    shown.iter().flat_map(|p| pixel::rgba8(*p, space)).collect();
                assert!(found(Format::Rgba8) == expected, "{alpha:?}");
                if alpha == Alpha::Background {
                    assert_eq!(expected.as_chunks().0[empty], behind);
                }
                let turned = found(Format::Bgra8);
                let back = turned.as_chunks().0.iter().flat_map(|[b, g, r, a]| [*r, *g, *b, *a]);
                assert!(back.eq(expected), "{alpha:?}");
                let expected = shown.as_flattened().iter().flat_map(|v| v.to_ne_bytes());
                assert!(found(Format::RgbaF32).into_iter().eq(expected), "{alpha:?}");
            }
        }
    }
}

#[test]
fn depths_are_in_the_callers_units_along_rays_or_the_axis() {
    let (model, file) = (Open::new(GOLDEN, 0), open(GOLDEN).unwrap());
    let camera = model.camera(61, 47);
    let core = core_camera(&camera);
    let in_model = file.about.scene.camera_to_model(&core);
    let (_, expected) = picture(&file.model, &in_model, 0.5, true);
    let depths = |kind: DepthKind| {
        let mut depths = vec![-1.0f32; 61 * 47];
        let image = Image {
            depth: depths.as_mut_ptr(),
            depth_size: 4 * depths.len(),
            depth_kind: kind as u32,
            ..NOTHING
        };
        render(&model, &camera, &usual_options(), &image);
        depths
    };
    let (found, along) = (depths(DepthKind::Distance), depths(DepthKind::Z));
    let seen = expected.iter().filter(|depth| depth.is_finite()).count();
    assert!((100..61 * 47).contains(&seen), "{seen}");
    for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
        assert_eq!(*found, expected * file.about.scene.scale, "pixel {i}");
        let (d, axis) =
            (core.ray((i % 61) as f32 + 0.5, (i / 61) as f32 + 0.5).direction, core.axis());
        let cosine = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
        let close = (along[i] - found * cosine).abs() < 1e-5 * found;
        assert!(close || (along[i].is_infinite() && found.is_infinite()), "pixel {i}");
    }
}

#[test]
fn coordinates_of_photographs_and_of_the_model_show_the_same() {
    let [theirs, own] = [0, OPEN_MODEL_COORDINATES].map(|flags| Open::new(GOLDEN, flags));
    let usual = usual_options();
    let [theirs, own] =
        [&theirs, &own].map(|model| bytes_of(model, &model.camera(61, 47), &usual, NOTHING));
    let off = theirs.iter().zip(&own).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    // Poses are rounded on their way; where a ray just meets a cell, that may show.
    assert!(off < 20, "{off}");
}

#[test]
fn tiles_and_memory_without_a_table_make_the_same_picture() {
    let model = Open::new(STILL_LIFE, 0);
    let (camera, usual) = (model.camera(150, 130), usual_options());
    let expected = bytes_of(&model, &camera, &usual, NOTHING);
    let bare = Open::new(STILL_LIFE, OPEN_WITHOUT_TABLE);
    assert!(bytes_of(&bare, &camera, &usual, NOTHING) == expected);

    let mut found = vec![0; expected.len()];
    let image = Image { pixels: found.as_mut_ptr().cast(), size: found.len(), ..NOTHING };
    let mut scratch = model.scratch(&usual);
    let n = unsafe { pnrf_tile_count(150, 130, &usual) };
    let mut pixels = 0;
    for number in (0..n).rev() {
        let (at, length) = (scratch.as_mut_ptr(), scratch.len());
        done(|error| unsafe {
            pnrf_render_tile(
                model.0,
                &camera,
                &usual,
                number,
                &image,
                at,
                length,
                null_mut(),
                error,
            )
        });
        let mut tile = Tile { x: 0, y: 0, width: 0, height: 0 };
        done(|error| unsafe { pnrf_tile(150, 130, &usual, number, &raw mut tile, error) });
        pixels += tile.width * tile.height;
    }
    assert_eq!(pixels, 150 * 130);
    assert!(found == expected);
}

#[test]
fn rows_may_lie_anywhere_and_upside_down() {
    let model = Open::new(STILL_LIFE, 0);
    let (camera, usual) = (model.camera(40, 30), usual_options());
    let expected = bytes_of(&model, &camera, &usual, NOTHING);
    let stride = 4 * 40 + 13;
    let mut found = vec![0xa5u8; 3 + stride * 30];
    let image = Image {
        pixels: unsafe { found.as_mut_ptr().add(3) }.cast(),
        size: found.len() - 3,
        stride,
        bottom_up: 1,
        ..NOTHING
    };
    render(&model, &camera, &usual, &image);
    for (row, expected) in found[3..].chunks(stride).rev().zip(expected.chunks(4 * 40)) {
        assert!(row[..4 * 40] == *expected);
        assert!(row[4 * 40..].iter().all(|byte| *byte == 0xa5));
    }
}

#[test]
fn every_simd_level_and_memory_is_within_50_db_of_the_oracle() {
    let levels = [
        (Simd::Portable, SimdLevel::Portable),
        (Simd::Sse42, SimdLevel::Sse42),
        (Simd::Avx2, SimdLevel::Avx2),
        (Simd::Avx512, SimdLevel::Avx512),
        (Simd::Neon, SimdLevel::Neon),
    ];
    for (bytes, size) in [(GOLDEN, [61, 47]), (STILL_LIFE, [60, 45])] {
        let (model, file) = (Open::new(bytes, 0), open(bytes).unwrap());
        let camera = model.camera(size[0], size[1]);
        let in_model = file.about.scene.camera_to_model(&core_camera(&camera));
        let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        let truth: Vec<f32> = pixels
            .flat_map(|(x, y)| render_pixel(&file.model, &in_model, x, y).unwrap().over(BACKGROUND))
            .collect();
        for (code, _) in levels.iter().filter(|(_, level)| level.is_available()) {
            for memory in [Memory::Fast, Memory::Small] {
                let options = Options {
                    simd: *code as u32,
                    memory: memory as u32,
                    quality: 1.0,
                    ..usual_options()
                };
                let image =
                    Image { format: Format::RgbaF32 as u32, background: BACKGROUND, ..NOTHING };
                let found = bytes_of(&model, &camera, &options, image);
                let found = found.as_chunks().0.iter().map(|bytes| f32::from_ne_bytes(*bytes));
                let found: Vec<f32> = found.collect();
                let rgb = found.as_chunks::<4>().0.iter().flat_map(|p| &p[..3]);
                let squares = rgb.zip(&truth).map(|(a, b)| f64::from(a - b).powi(2));
                let psnr = -10.0 * (squares.sum::<f64>() / truth.len() as f64).log10();
                assert!(psnr >= 50.0, "{code:?} {memory:?}: {psnr:.1} dB");
            }
        }
    }
}

#[test]
fn a_packed_file_shows_the_same() {
    let packed = pack(STILL_LIFE).unwrap();
    let ordinary = Open::new(STILL_LIFE, 0);
    let (camera, options) = (ordinary.camera(60, 50), usual_options());
    let expected = bytes_of(&ordinary, &camera, &options, NOTHING);
    for flags in [0, OPEN_BORROWED, OPEN_UNVERIFIED | OPEN_WITHOUT_TABLE] {
        let opened = Open::new(&packed, flags);
        assert!(bytes_of(&opened, &camera, &options, NOTHING) == expected, "{flags}");
    }
}
