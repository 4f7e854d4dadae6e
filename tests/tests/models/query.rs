//! Questions to models in files: in the dataset's coordinates, and never a false "free".

use std::path::Path;

use pocketnerf_core::query::{Depth, normal};
use pocketnerf_core::reference;
use pocketnerf_core::{Error, Probe, Ray, SimdLevel, Tuning};
use pocketnerf_formats::open_verified;
use pocketnerf_train::random::Random;

/// What the embedding example carries: the built-in scene, trained.
const STILL_LIFE: &[u8] = include_bytes!("../../../embed-demo/still-life.pnerf");

fn golden(name: &str) -> Vec<u8> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("golden").join(name);
    std::fs::read(path).unwrap()
}

/// A random point in the box, in the model's coordinates.
fn point(random: &mut Random, [min, max]: [[f32; 3]; 2]) -> [f32; 3] {
    [0, 1, 2].map(|a| min[a] + random.next_f32() * (max[a] - min[a]))
}

/// SCENE of the goldens says that the dataset is twice as large, turned and moved:
/// densities are half the oracle's, gradients a quarter and turned, distances twice as long.
#[test]
fn answers_are_in_the_units_of_the_dataset() {
    let mut random = Random::new(1, [0; 3]);
    let mut worst = 0.0f32;
    for name in [
        "hash-grid-f16",
        "hash-grid-f32",
        "hash-grid-i8",
        "per-sample-f16",
        "nerf-f16",
        "plenoxels-i8",
        "planes-i8",
        "derf-f16",
    ] {
        let bytes = golden(&format!("{name}.pnerf"));
        let file = open_verified(&bytes).unwrap();
        let (model, scene) = (&file.model, &file.about.scene);
        let points: Vec<[f32; 3]> =
            (0..1000).map(|_| point(&mut random, model.space.bounds())).collect();
        let there: Vec<[f32; 3]> = points.iter().map(|p| scene.to_dataset(*p)).collect();
        for level in SimdLevel::ALL.into_iter().filter(|level| level.is_available()) {
            let probe = file.probe(level, Tuning::FAST).unwrap();
            let own = Probe::new(model, level, Tuning::FAST).unwrap();
            let mut scratch = vec![0.0; probe.scratch_len()];
            let (mut sigma, mut occupied) = (vec![0.0; points.len()], 0);
            probe.density(&there, &mut scratch, &mut sigma).unwrap();
            for (p, sigma) in points.iter().zip(&sigma) {
                let expected = reference::query(model, *p, [0.0, 0.0, 1.0]).unwrap().sigma;
                // Rounding may take a point across a wall; see to it that few are.
                if (expected > 0.0) == (*sigma > 0.0) {
                    let off = (scene.scale * sigma - expected).abs();
                    assert!(off <= 1e-3 * expected, "{name} {level} {p:?}: {sigma}, {expected}");
                    worst = worst.max(off / expected.max(1e-30));
                    occupied += usize::from(expected > 0.0);
                }
            }
            assert!(occupied > 20, "{name}: {occupied} points in occupied cells");
            // Gradients turn with the axes; those near walls of cells may be of another side.
            let (mut here, mut turned) =
                (vec![[0.0; 3]; points.len()], vec![[0.0; 3]; points.len()]);
            own.density_gradient(&points, &mut scratch, &mut here).unwrap();
            probe.density_gradient(&there, &mut scratch, &mut turned).unwrap();
            let mut same = 0;
            for (here, turned) in here.iter().zip(&turned) {
                let back = scene.to_model_direction(*turned).map(|v| scene.scale.powi(2) * v);
                let size = here.iter().map(|v| v * v).sum::<f32>().sqrt();
                let off = (0..3).map(|a| (back[a] - here[a]).abs()).fold(0.0, f32::max);
                same += usize::from(off <= 2e-3 * size);
                assert!(normal(*turned).iter().all(|v| v.is_finite()));
            }
            assert!(same > 950, "{name} {level}: {same} of 1000 gradients");
            // A segment lets the same light pass, and depths are longer.
            let ends = points.as_chunks::<2>().0;
            let ends_there = there.as_chunks::<2>().0;
            let (mut passes, mut passes_there) = (vec![0.0; 500], vec![0.0; 500]);
            own.segment_transmittance(ends, &mut scratch, &mut passes).unwrap();
            probe.segment_transmittance(ends_there, &mut scratch, &mut passes_there).unwrap();
            let apart = |(a, b): &(&f32, &f32)| (*a - *b).abs() > 1e-4;
            let apart = passes.iter().zip(&passes_there).filter(apart).count();
            assert!(apart <= 10, "{name} {level}: {apart} of 500 segments");
            let (mut depth, mut depth_there) = ([0.0], [0.0]);
            let center = model.space.center();
            let eye = [center[0], center[1], center[2] + 3.0];
            let ray = Ray { origin: eye, direction: [0.0, 0.0, -1.0] };
            let [from, to] = [eye, center].map(|p| scene.to_dataset(p));
            let way = [0, 1, 2].map(|a| to[a] - from[a]);
            // Of whatever length.
            let ray_there = Ray { origin: from, direction: way };
            own.depths(&[ray], Depth::Expected, None, &mut scratch, &mut depth).unwrap();
            probe
                .depths(&[ray_there], Depth::Expected, None, &mut scratch, &mut depth_there)
                .unwrap();
            let off = depth_there[0] - scene.scale * depth[0];
            assert!(depth == depth_there || off.abs() < 1e-3, "{depth:?} {depth_there:?}");
        }
    }
    println!("worst density: {worst:e} of it");
    let ndc = golden("ndc-f16.pnerf");
    let refused = open_verified(&ndc).unwrap().probe(SimdLevel::detect(), Tuning::FAST).err();
    assert!(matches!(refused, Some(Error::Unsupported(_))), "{refused:?}");
}

/// In a trained scene: where `sphere_clear` says so, no point of the ball has density, and
/// no way through it holds back light; most balls far from everything are clear.
#[test]
fn clear_balls_of_a_trained_scene_are_empty() {
    let file = open_verified(STILL_LIFE).unwrap();
    let probe = file.probe(SimdLevel::detect(), Tuning::FAST).unwrap();
    let scene = &file.about.scene;
    let mut scratch = vec![0.0; probe.scratch_len()];
    let mut random = Random::new(2, [0; 3]);
    let (mut clear, mut near) = (0, 0);
    for _ in 0..4000 {
        let center = scene.to_dataset(point(&mut random, file.model.space.bounds()));
        let radius =
            random.next_f32().powi(2) * 0.3 * scene.scale / file.model.space.unit_map().scale;
        if !probe.sphere_clear(center, radius) {
            near += 1;
            continue;
        }
        clear += 1;
        let points: Vec<[f32; 3]> = (0..100)
            .map(|_| {
                let d = [0; 3].map(|_| 2.0 * random.next_f32() - 1.0);
                let length = d.iter().map(|v| v * v).sum::<f32>().sqrt().max(1e-6);
                // Half of them on the surface.
                let far = if random.next_f32() < 0.5 { 1.0 } else { random.next_f32() };
                [0, 1, 2].map(|a| center[a] + radius * far * d[a] / length)
            })
            .collect();
        let mut sigma = vec![f32::NAN; points.len()];
        probe.density(&points, &mut scratch, &mut sigma).unwrap();
        assert!(sigma.iter().all(|sigma| *sigma == 0.0), "{center:?} {radius}");
        let mut passes = vec![f32::NAN; 50];
        probe.segment_transmittance(points.as_chunks().0, &mut scratch, &mut passes).unwrap();
        assert!(passes.iter().all(|passes| *passes == 1.0), "{center:?} {radius}");
    }
    println!("{clear} balls are clear, {near} are not");
    assert!(clear > 1000 && near > 500, "{clear} balls are clear, {near} are not");
}
