//! Models and rays whose numbers cannot be used.

use super::*;

#[test]
fn nan_weights_are_empty_space() {
    let empty = RayResult { samples: 8, ..RayResult::EMPTY };
    for kind in kinds() {
        for shading in SHADINGS {
            // Of the density, in a hidden layer: ReLU must not take them away.
            let mut scene = constant(&kind, 1.0, [0.0; 3], shading);
            let first = Dense { bias: Some(tensor(1, 3, &[f32::NAN; 3])), ..scene.density_layer() };
            let second = dense(3, 3, &[1.0; 9], &[0.0; 3]);
            scene.decoder.density = Mlp::new(&[first, second]).unwrap();
            assert_eq!(render_ray(&scene.build(), &ALONG_Z), Ok(empty));
            // Infinities that cancel: inf - inf.
            let first = dense(3, 3, &[0.0; 9], &[0.0; 3]);
            let infinite = dense(3, 3, &[f32::INFINITY; 9], &[f32::NEG_INFINITY; 3]);
            let layers = [scene.density_layer(), first, infinite];
            scene.decoder.density = Mlp::new(&layers).unwrap();
            assert_eq!(render_ray(&scene.build(), &ALONG_Z), Ok(empty));
            // Of the colour: black, with the opacity of the density.
            let mut scene = constant(&kind, 1.0, [0.0; 3], shading);
            let plain = render_ray(&scene.build(), &ALONG_Z).unwrap();
            scene.set_color(&[dense(3, 3, &[f32::NAN; 9], &[f32::NAN; 3])]);
            let black = render_ray(&scene.build(), &ALONG_Z).unwrap();
            assert_eq!(black, RayResult { rgb: [0.0; 3], ..plain });
        }
    }
}

// With both kinds linked: picks one of them.
#[cfg(all(feature = "hash-grid", feature = "nerf"))]
#[test]
fn a_nan_entry_is_empty_only_where_it_is_read() {
    use crate::AnyField;
    for kind in kinds() {
        let scene = constant(&kind, 0.0, [0.0; 3], Shading::PerSample);
        let mut model = scene.build();
        let AnyField::HashGrid(field) = &mut model.field else { continue };
        // Every corner with z = 2: read where u.z > 1/2, which is z > 0, half of the samples.
        let values: std::vec::Vec<f32> =
            (0..64).map(|e| if e / 32 == 1 && e % 8 < 4 { f32::NAN } else { 0.0 }).collect();
        field.grid.levels[0] = tensor(64, 1, &values);
        let seen = render_ray(&model, &ALONG_Z).unwrap();
        assert_eq!(seen.samples, 8);
        close(seen.opacity, 1.0 - (-1.0f64).exp());
    }
}

#[test]
fn rays_that_are_not_numbers_see_nothing() {
    for kind in kinds() {
        let model = constant(&kind, 1.0, [0.0; 3], Shading::PerRay).build();
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let origin = Ray { origin: [bad, 0.0, -3.0], ..ALONG_Z };
            let direction = Ray { direction: [0.0, 0.0, bad], ..ALONG_Z };
            assert_eq!(render_ray(&model, &origin), Ok(RayResult::EMPTY));
            assert_eq!(render_ray(&model, &direction), Ok(RayResult::EMPTY));
            assert_eq!(query(&model, [bad, 0.0, 0.0], [0.0, 0.0, 1.0]).unwrap().sigma, 0.0);
        }
    }
}

#[test]
fn refuses_what_it_cannot_evaluate() {
    for kind in kinds() {
        let mut scene = SceneBuilder::new(&kind, [0.0; 3], [0.0; 3]);
        scene.sampling.step = 0.0;
        assert!(matches!(render_ray(&scene.build(), &ALONG_Z), Err(Error::Range(_))));
        let mut scene = SceneBuilder::new(&kind, [0.0; 3], [0.0; 3]);
        let wide =
            [dense(3, 513, &[0.0; 3 * 513], &[0.0; 513]), dense(513, 3, &[0.0; 1539], &[0.0; 3])];
        scene.set_color(&wide);
        assert!(matches!(render_ray(&scene.build(), &ALONG_Z), Err(Error::Limits(_))));
        assert!(matches!(query(&scene.build(), [0.0; 3], [0.0; 3]), Err(Error::Limits(_))));
    }
}
