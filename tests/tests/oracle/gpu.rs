//! Pictures by the GPU against the CPU's own: every kind of field, stored type, shading,
//! space and sampling. A software GPU will do.

use naga::valid::{Capabilities, ValidationFlags, Validator};
use pocketnerf_core::field::Shading;
use pocketnerf_core::march::{Hierarchical, Reach};
use pocketnerf_core::pixel::rgba8;
use pocketnerf_core::render::{Detail, SamplingMode};
use pocketnerf_core::{
    AnyField, Camera, ColorSpace, Display, Error, Model, Ray, RenderOptions, SimdLevel, Tuning,
};
use pocketnerf_gpu::{Gpu, Renderer, Software, pack::Packed, shader, training};

use crate::models::{Encoding, Random, Recipe, camera, in_contracted, in_ndc};
use crate::picture::{Picture, rays, tile, whole};

/// How like they have to be, dB.
const LEAST: f64 = 50.0;

/// What every GPU can that wgpu reaches by Vulkan, Metal, DirectX 12 or WebGPU: two half
/// precision numbers in a word.
const CAPABILITIES: Capabilities = Capabilities::SHADER_FLOAT16_IN_FLOAT32;

/// The GPU, if there is one; without one where tools are required, the tests fail. Each test opens
/// it anew: a software GPU compiles for seconds, which tests do side by side.
fn gpu() -> Option<Gpu> {
    match Gpu::open(Software::Allowed) {
        Ok(gpu) => Some(gpu),
        Err(why) => {
            assert!(std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_none(), "{why}");
            println!("{why}: install mesa-vulkan-drivers; nothing is tested");
            None
        }
    }
}

fn finest(model: &Model<'_>) -> RenderOptions {
    RenderOptions {
        detail: Detail::FINEST,
        ..RenderOptions::new(model, SimdLevel::detect(), Tuning::FAST)
    }
}

/// PSNR of colours and opacities, dB, and of the pixels that hold back half of the light the
/// share whose depth differs by more than half a percent.
fn likeness(gpu: &Gpu, model: &Model<'_>, camera: &Camera, options: &RenderOptions) -> (f64, f64) {
    let mut renderer = Renderer::new(gpu, model, options).unwrap();
    let expected = tile(model, camera, whole(camera), options);
    compared(renderer.render(camera).unwrap(), &expected)
}

fn compared(found: &pocketnerf_gpu::Picture, expected: &Picture) -> (f64, f64) {
    assert!(found.hits > 0 && found.samples >= found.hits);
    let (mut dense, mut far_off) = (0, 0);
    let pixels = found.rgba.as_chunks::<4>().0.iter().zip(found.depth.iter().zip(&expected.depth));
    for (_, (found, expected)) in pixels.filter(|(rgba, _)| rgba[3] > 0.5) {
        dense += 1;
        far_off += usize::from((found - expected).abs() > 5e-3 * expected);
    }
    let squares = found.rgba.iter().zip(expected.rgba.as_flattened());
    let squares: f64 = squares.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    let psnr = -10.0 * (squares / found.rgba.len() as f64).log10();
    (psnr, f64::from(far_off as u32) / f64::from(dense.max(1)))
}

/// Asserts that they are alike.
fn assert_alike(gpu: &Gpu, name: &str, model: &Model<'_>, size: [u32; 2], options: &RenderOptions) {
    let (psnr, far_off) = likeness(gpu, model, &camera(size[0], size[1]), options);
    assert!(psnr >= LEAST, "{name}: {psnr:.1} dB");
    assert!(far_off <= 0.05, "{name}: {far_off:.3} of the depths differ");
}

/// Where a model is.
#[derive(Clone, Copy, Debug)]
enum Place {
    Box,
    Contracted,
    Ndc,
}

impl Place {
    const ALL: [Self; 3] = [Self::Box, Self::Contracted, Self::Ndc];
}

fn build(recipe: Recipe, place: Place) -> (String, Model<'static>) {
    let model = recipe.build();
    let model = match place {
        Place::Box => model,
        Place::Contracted => in_contracted(model),
        Place::Ndc => in_ndc(model),
    };
    (format!("{recipe:?}, {place:?}"), model)
}

/// Compiling a program takes a CPU seconds: of each kind of grid one with colours of samples and
/// one with colours of rays, every stored type, with and without cells, in each of the spaces.
fn some_grids() -> impl Iterator<Item = (String, Model<'static>)> {
    let grids: Vec<Recipe> = Recipe::all()
        .filter(|recipe| matches!(recipe.encoding, Encoding::HashGrid(_) | Encoding::Corners(_)))
        .collect();
    let n_encodings = grids.len() / 12;
    let one =
        move |i: usize| grids[12 * (i / 2) + [[0, 7, 9, 8], [6, 3, 11, 10]][i % 2][i / 2 % 4]];
    (0..2 * n_encodings).map(move |i| build(one(i), Place::ALL[i % 3]))
}

/// Of either number of components every stored type: with colours of samples, and of rays.
fn some_planes() -> impl Iterator<Item = (String, Model<'static>)> {
    let some = Recipe::planes().enumerate().filter(|(i, _)| i % 2 == i / 6);
    some.map(|(i, recipe)| build(recipe, Place::ALL[i / 2 % 3]))
}

/// Of every kind of vanilla NeRF one.
fn some_nerfs() -> impl Iterator<Item = (String, Model<'static>)> {
    let some = Recipe::nerfs().skip(1).step_by(2).enumerate();
    some.map(|(i, recipe)| build(recipe, Place::ALL[i % 3]))
}

fn hierarchically(model: &Model<'_>, reach: Reach, n_fine: u32) -> RenderOptions {
    let hierarchical = Hierarchical { n_coarse: 24, n_fine, reach };
    finest(model).with_sampling(SamplingMode::Hierarchical(hierarchical))
}

/// Naga's own compilers take each program, which asks for no optional feature of a GPU.
#[test]
fn every_program_is_valid_everywhere() {
    let (mut n, mut n_training) = (0, 0);
    let validate = |name: &str, source: String| {
        let module = naga::front::wgsl::parse_str(&source)
            .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&source)));
        let mut validator = Validator::new(ValidationFlags::all(), CAPABILITIES);
        validator.validate(&module).unwrap_or_else(|error| panic!("{name}: {error:?}"));
    };
    for (i, recipe) in Recipe::all().enumerate() {
        for place in Place::ALL {
            let (name, model) = build(recipe, place);
            let left_out = |encoding| matches!(encoding, Encoding::Voxels(_) | Encoding::Derf(_));
            if left_out(recipe.encoding) {
                let refused = Packed::new(&model).unwrap_err();
                assert_eq!(refused, Error::Unsupported("this kind of field"));
                continue;
            }
            let packed = Packed::new(&model).unwrap();
            if let Ok(source) = training::source(&model) {
                validate(&name, source);
                n_training += 1;
            }
            let reach = [Reach::Clipped, Reach::Distance, Reach::Depth][i % 3];
            for options in [finest(&model), hierarchically(&model, reach, [40, 0][i % 2])] {
                validate(&name, shader::source(&model, &packed, &options));
                n += 1;
            }
        }
    }
    assert!(n > 450 && n_training >= 24, "{n} {n_training}");
    println!("{n} programs that render, {n_training} that train");
}

#[test]
fn grids_look_as_on_the_cpu() {
    let Some(gpu) = &gpu() else { return };
    for (name, model) in some_grids() {
        assert_alike(gpu, &name, &model, [40, 30], &finest(&model));
    }
}

#[test]
fn planes_look_as_on_the_cpu() {
    let Some(gpu) = &gpu() else { return };
    for (name, model) in some_planes() {
        assert_alike(gpu, &name, &model, [40, 30], &finest(&model));
    }
}

#[test]
fn nerfs_and_hierarchical_samples_look_as_on_the_cpu() {
    let Some(gpu) = &gpu() else { return };
    for (name, model) in some_nerfs() {
        assert_alike(gpu, &name, &model, [40, 30], &finest(&model));
    }
    let grid = build(Recipe::PLAIN, Place::Box);
    let deferred = build(Recipe { shading: Shading::PerRay, ..Recipe::PLAIN }, Place::Ndc);
    let nerfs = some_nerfs().filter(|(name, _)| name.contains("coarse: true"));
    let samplings = [(Reach::Clipped, 40), (Reach::Depth, 0), (Reach::Distance, 32)];
    let mut n = 0;
    for (i, (name, model)) in [grid, deferred].into_iter().chain(nerfs).enumerate() {
        let (reach, n_fine) = samplings[i % 3];
        let options = hierarchically(&model, reach, n_fine);
        assert_alike(gpu, &format!("{name} {reach:?} {n_fine}"), &model, [24, 18], &options);
        n += 1;
    }
    assert!(n > 2, "{n}");
}

/// Rays in all directions, from within the cube and from outside: some of one piece, some of
/// several, with the samples and depths of the CPU.
#[test]
fn rays_bend_as_on_the_cpu() {
    let Some(gpu) = &gpu() else { return };
    let mut random = Random(41);
    let mut ray = |i: usize| {
        let reach = [1.2, 9.0][i % 2];
        let origin = [0.3, -0.2, 0.1].map(|center| center + reach * random.signed());
        let direction = [(); 3].map(|()| random.signed());
        let length = direction.iter().map(|d| d * d).sum::<f32>().sqrt();
        Ray { origin, direction: direction.map(|d| d / length) }
    };
    let some: Vec<Ray> = (0..1600).map(&mut ray).collect();
    let deferred = Recipe { shading: Shading::PerRay, occupancy: None, ..Recipe::PLAIN };
    let nerf = Recipe::nerfs().find(|recipe| format!("{recipe:?}").contains("coarse: true"));
    let [plain, deferred, nerf] =
        [Recipe::PLAIN, deferred, nerf.unwrap()].map(|recipe| build(recipe, Place::Contracted));
    for ((name, model), options) in [
        (&plain, finest(&plain.1)),
        (&deferred, finest(&deferred.1)),
        (&nerf, hierarchically(&nerf.1, Reach::Distance, 32)),
        (&nerf, hierarchically(&nerf.1, Reach::Clipped, 40)),
    ] {
        let mut renderer = Renderer::new(gpu, model, &options).unwrap();
        let found = renderer.render_rays(&some, 40, [0.0, 0.0, -1.0]).unwrap();
        let expected = rays(model, &some, &options);
        let (psnr, far_off) = compared(found, &expected);
        assert!(psnr >= LEAST + 10.0, "{name}: {psnr:.1} dB");
        assert!(far_off <= 0.01, "{name}: {far_off:.3} of the depths differ");
        let off = found.samples.abs_diff(expected.stats.samples);
        assert!(off <= expected.stats.samples / 500, "{name}: {off} samples more or less");
    }
}

/// A picture is the same however it comes about: again, of rays that are given, in parts.
#[test]
fn the_same_pictures_from_rays_and_again() {
    let Some(gpu) = &gpu() else { return };
    let (_, mut model) = build(Recipe { shading: Shading::PerRay, ..Recipe::PLAIN }, Place::Box);
    // Of a denser mist, so that rays end.
    if let AnyField::HashGrid(field) = &mut model.field {
        field.decoder.log_density_bias += 4.0;
    }
    let mut renderer = Renderer::new(gpu, &model, &finest(&model)).unwrap();
    // More pixels than are asked for at a time at first.
    let camera = camera(93, 85);
    let first = renderer.render(&camera).unwrap().clone();
    assert_eq!(renderer.render(&camera).unwrap(), &first);
    let ray = |i: u32| camera.ray((i % 93) as f32 + 0.5, (i / 93) as f32 + 0.5);
    let rays: Vec<_> = (0..93 * 85).map(ray).collect();
    let given = renderer.render_rays(&rays, 93, camera.axis()).unwrap();
    assert_eq!((given.width, given.height), (93, 85));
    // Directions are normalised elsewhere.
    let most = first.rgba.iter().zip(&given.rgba).map(|(a, b)| (a - b).abs());
    let far_off = most.filter(|difference| *difference > 1e-4).count();
    assert!(far_off < given.rgba.len() / 200, "{far_off}");
    assert!(first.depth.contains(&f32::INFINITY) && first.hits < 93 * 85);
    // Less detail, as the CPU has it without interpolated pixels.
    let coarse = Detail { min_transmittance: 0.02, coarse_step_below: 0.3, ..Detail::FINEST };
    let options = RenderOptions { detail: coarse, ..finest(&model) };
    let (psnr, _) = likeness(gpu, &model, &camera, &options);
    assert!(psnr >= 40.0, "{psnr:.1} dB");
    let fewer = Renderer::new(gpu, &model, &options).unwrap().render(&camera).unwrap().samples;
    assert!(fewer < first.samples * 9 / 10, "{fewer} of {}", first.samples);
}

/// A picture that is drawn has the bytes of one that is rendered, over any background, also where
/// its rows are asked for in several bands.
#[test]
fn what_is_drawn_has_the_bytes_of_what_is_rendered() {
    let Some(gpu) = &gpu() else { return };
    let (_, model) = build(Recipe { shading: Shading::PerRay, ..Recipe::PLAIN }, Place::Box);
    let mut renderer = Renderer::new(gpu, &model, &finest(&model)).unwrap();
    let srgb = Display { background: [0.2, 1.0, 0.6], ..Display::default() };
    let linear = Display { color_space: ColorSpace::Linear, ..srgb };
    assert!(renderer.rgba8(&srgb).unwrap().is_empty());
    // The larger one in bands, and then in the memory of the larger one.
    for camera in [camera(93, 85), camera(40, 30)] {
        renderer.draw(&camera).unwrap();
        renderer.draw(&camera).unwrap();
        for display in [srgb, linear] {
            let found = renderer.rgba8(&display).unwrap().to_vec();
            let expected = renderer.render(&camera).unwrap().rgba.as_chunks::<4>().0;
            assert_eq!(found.len(), 4 * expected.len());
            for (found, expected) in found.as_chunks::<4>().0.iter().zip(expected) {
                let [r, g, b] = display.rgb8(*expected);
                let alpha = rgba8(*expected, ColorSpace::Srgb)[3];
                let off = found.iter().zip([r, g, b, alpha]).map(|(a, b)| a.abs_diff(b));
                assert!(off.max() <= Some(1), "{found:?} {expected:?}");
            }
        }
    }
    renderer.finish().unwrap();
    if renderer.set_timed().unwrap() {
        renderer.render(&camera(40, 30)).unwrap();
        assert!(renderer.gpu_time().is_some());
    }
}

/// A small file cannot ask for hours of work.
#[test]
fn more_samples_than_are_allowed_are_refused() {
    let Some(gpu) = &gpu() else { return };
    let (_, mut model) = build(Recipe { occupancy: None, ..Recipe::PLAIN }, Place::Box);
    model.sampling.step = 1e-4;
    let options = RenderOptions { max_samples_per_pixel: 50, ..finest(&model) };
    let refused = Renderer::new(gpu, &model, &options).unwrap_err().to_string();
    assert!(refused.contains("more than the"), "{refused}");
}
