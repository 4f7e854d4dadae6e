//! The same answers.

use std::ptr::{null, null_mut};

use pocketnerf_c::{
    Info, OPEN_MODEL_COORDINATES, Text, pnrf_collision_probability, pnrf_density,
    pnrf_density_gradient, pnrf_depths, pnrf_info, pnrf_normals, pnrf_occupied, pnrf_radiance,
    pnrf_segment_transmittance, pnrf_sphere_clear, pnrf_text,
};
use pocketnerf_core::query::{Depth, normal};
use pocketnerf_core::space::Contracted;
use pocketnerf_core::{Model, Ray, SimdLevel, Space, Tuning};
use pocketnerf_formats::{Precision, open, write};

use crate::{GOLDEN, Open, STILL_LIFE, done, usual_options};

/// Points in and around the ball of a model, the same every time.
fn points(info: &Info, n: usize) -> Vec<[f32; 3]> {
    let mut state = 1u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 8_388_608.0 - 1.0
    };
    (0..n).map(|_| info.center.map(|c| c + info.radius * next())).collect()
}

fn info(model: &Open) -> Info {
    let mut info = unsafe { std::mem::zeroed() };
    done(|error| unsafe { pnrf_info(model.0, &raw mut info, error) });
    info
}

#[test]
fn answers_are_those_of_the_rust_crates() {
    for bytes in [GOLDEN, STILL_LIFE] {
        let (model, file) = (Open::new(bytes, 0), open(bytes).unwrap());
        let probe = file.probe(SimdLevel::detect(), Tuning::FAST).unwrap();
        let (usual, mut scratch) = (usual_options(), model.scratch(&usual_options()));
        let (m, (s, length)) = (model.0, (scratch.as_mut_ptr(), scratch.len()));
        let mut own = vec![0.0; probe.scratch_len()];
        let points = points(&info(&model), 500);
        let p = points.as_ptr().cast::<f32>();

        let (mut found, mut expected) = (vec![-1.0; 500], vec![0.0; 500]);
        let out = found.as_mut_ptr();
        done(|e| unsafe { pnrf_density(m, &usual, p, 500, out, s, length, e) });
        probe.density(&points, &mut own, &mut expected).unwrap();
        assert_eq!(found, expected);
        assert!(expected.iter().any(|sigma| *sigma > 0.0) && expected.contains(&0.0));

        let directions: Vec<[f32; 3]> = points.iter().rev().copied().collect();
        let d = directions.as_ptr().cast::<f32>();
        let (mut found, mut expected) = (vec![[-1.0f32; 4]; 500], vec![[0.0; 4]; 500]);
        let out = found.as_mut_ptr().cast();
        done(|e| unsafe { pnrf_radiance(m, &usual, p, d, 500, out, s, length, e) });
        probe.radiance(&points, &directions, &mut own, &mut expected).unwrap();
        assert_eq!(found, expected);

        let (mut found, mut expected) = (vec![[-1.0f32; 3]; 500], vec![[0.0; 3]; 500]);
        let out = found.as_mut_ptr().cast();
        done(|e| unsafe { pnrf_density_gradient(m, &usual, p, 500, out, s, length, e) });
        probe.density_gradient(&points, &mut own, &mut expected).unwrap();
        assert_eq!(found, expected);
        let out = found.as_mut_ptr().cast();
        done(|e| unsafe { pnrf_normals(m, &usual, p, 500, out, s, length, e) });
        assert!(found.iter().eq(expected.into_iter().map(normal).collect::<Vec<_>>().iter()));

        let mut found = vec![7; 500];
        done(|e| unsafe { pnrf_occupied(m, p, 500, found.as_mut_ptr(), e) });
        assert!(
            found.iter().eq(points
                .iter()
                .map(|p| u8::from(probe.occupied(*p)))
                .collect::<Vec<_>>()
                .iter())
        );
        let radius = 0.2 * info(&model).radius;
        let balls: Vec<[f32; 4]> = points.iter().map(|[x, y, z]| [*x, *y, *z, radius]).collect();
        let b = balls.as_ptr().cast();
        done(|e| unsafe { pnrf_sphere_clear(m, b, 500, found.as_mut_ptr(), e) });
        let clear: Vec<u8> = points.iter().map(|p| probe.sphere_clear(*p, radius).into()).collect();
        assert_eq!(found, clear);

        let (mut found, mut expected) = (vec![-1.0; 250], vec![0.0; 250]);
        let out = found.as_mut_ptr();
        done(|e| unsafe { pnrf_segment_transmittance(m, &usual, p, 250, out, s, length, e) });
        let segments = points.as_chunks().0;
        probe.segment_transmittance(segments, &mut own, &mut expected).unwrap();
        assert_eq!(found, expected);

        let mut hit = -1.0;
        let out = &raw mut hit;
        done(|e| unsafe {
            pnrf_collision_probability(m, &usual, p, 500, 1e-3, 0.01, out, s, length, e)
        });
        assert_eq!(hit, probe.collision_probability(&points, 1e-3, 0.01, &mut own).unwrap());

        let rays: Vec<Ray> = points
            .as_chunks()
            .0
            .iter()
            .map(|[origin, direction]| Ray { origin: *origin, direction: *direction })
            .collect();
        let axis = [0.0, 0.6, -0.8];
        let (mut found, mut expected) = (vec![-1.0; 250], vec![0.0; 250]);
        for (kind, depth) in (0..).zip([
            Depth::Expected,
            Depth::Median,
            Depth::FirstSigma(0.3),
            Depth::FirstOpacity(0.3),
        ]) {
            for axis in [None, Some(axis)] {
                let along = axis.as_ref().map_or(null(), |axis| axis.as_ptr());
                let out = found.as_mut_ptr();
                done(|e| unsafe {
                    pnrf_depths(m, &usual, p, 250, kind, 0.3, along, out, s, length, e)
                });
                probe.depths(&rays, depth, axis, &mut own, &mut expected).unwrap();
                assert_eq!(found, expected, "{depth:?}");
            }
        }
    }
}

#[test]
fn a_model_tells_what_it_is() {
    let model = Open::new(GOLDEN, 0);
    let told = info(&model);
    assert_eq!(told.bytes, GOLDEN.len() as u64);
    assert_eq!((told.has_camera, told.has_queries, told.is_linear), (1, 1, 0));
    // As the golden file has it: a quarter turn, twice as large, moved.
    assert_eq!((told.scale, told.translation), (2.0, [0.5, 0.25, -4.0]));
    assert_eq!(told.rotation, [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let own = info(&Open::new(GOLDEN, OPEN_MODEL_COORDINATES));
    assert_eq!((own.scale, own.translation), (1.0, [0.0; 3]));
    assert_eq!((own.radius * 2.0, own.step * 2.0), (told.radius, told.step));
    assert_eq!((own.box_min, own.box_max), (told.box_min, told.box_max));

    let text = |which: Text| {
        let (mut needed, mut buffer) = (0, [0x7f; 64]);
        done(|error| unsafe {
            pnrf_text(model.0, which as u32, buffer.as_mut_ptr(), 64, &raw mut needed, error)
        });
        let text: Vec<u8> = buffer[..needed - 1].iter().map(|byte| *byte as u8).collect();
        assert_eq!(buffer[needed - 1], 0);
        String::from_utf8(text).unwrap()
    };
    let all = [Text::Name, Text::Kind, Text::Method, Text::Program, Text::Dataset].map(text);
    assert_eq!(all, ["tiny", "hash-grid", "none", "pocketnerf-tests", "nothing"]);
}

/// The golden model in a cube of 4 around (1, -1, 0.5), and beyond.
fn contracted() -> Vec<u8> {
    let golden = open(GOLDEN).unwrap();
    let space = Space::Contracted(Contracted { center: [1.0, -1.0, 0.5], radius: 2.0 });
    let model = Model { space, ..golden.model };
    write(&model, &golden.about, Precision::F16).unwrap()
}

#[test]
fn a_cube_stands_for_a_scene_without_an_end() {
    let bytes = contracted();
    let of = |flags| info(&Open::new(&bytes, flags));
    let (own, told) = (of(OPEN_MODEL_COORDINATES), of(0));
    assert_eq!((own.center, own.box_min), ([1.0, -1.0, 0.5], [-1.0, -3.0, -1.5]));
    assert_eq!(own.box_max, [3.0, 1.0, 2.5]);
    assert!((own.radius - 2.0 * 3f32.sqrt()).abs() < 1e-6, "{}", own.radius);
    let golden = open(GOLDEN).unwrap();
    assert_eq!(own.step, 2.0 * golden.model.sampling.step);
    let scale = golden.about.scene.scale;
    assert_eq!((told.radius, told.step), (scale * own.radius, scale * own.step));
}

#[test]
fn models_in_bent_coordinates_are_not_asked() {
    for bytes in [include_bytes!("../../../../tests/golden/ndc-f16.pnerf"), &contracted()[..]] {
        is_not_asked(&Open::new(bytes, 0));
    }
}

fn is_not_asked(model: &Open) {
    assert_eq!(info(model).has_queries, 0);
    let (point, mut occupied) = ([0.0; 3], 7u8);
    let status =
        unsafe { pnrf_occupied(model.0, point.as_ptr(), 1, &raw mut occupied, null_mut()) };
    assert_eq!((status, occupied), (pocketnerf_c::Status::Unsupported, 7));
}
