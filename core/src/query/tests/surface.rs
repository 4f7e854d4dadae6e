//! Surfaces whose normals are known.

use super::*;
use crate::Ray;
use crate::query::Depth;

/// Fog that thickens downwards faces up, whatever the caller's axes, also for more rays than are
/// taken at a time; where nothing is, there is no normal.
#[test]
fn surfaces_face_where_density_falls() {
    // A quarter turn about x: the model's z is the caller's -y.
    let turned = Similarity {
        scale: 3.0,
        rotation: [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]],
        translation: [5.0, 0.0, -2.0],
    };
    for kind in kinds() {
        // Half of the light is absorbed at z = -0.68; the fields are as coarse as the box, and one of
        // the points around is in it.
        let model = fog(&kind, -2.0, -1.0);
        for (similarity, up, y) in
            [(Similarity::IDENTITY, [0.0, 0.0, 1.0], 0.1), (turned, [0.0, -1.0, 0.0], -0.1)]
        {
            let probe = Probe::new(&model, SimdLevel::detect(), Tuning::SMALL).unwrap();
            let probe = probe.with_similarity(similarity).unwrap();
            let mut scratch = vec![0.0; probe.scratch_len()];
            let rays: Vec<Ray> = (0..40)
                .map(|i| {
                    // Every third passes beside the box.
                    let x = if i % 3 == 0 { 4.0 } else { 0.02 * i as f32 };
                    let origin = similarity.to_dataset([x, y, 3.0]);
                    Ray { origin, direction: up.map(|v: f32| -2.0 * v) }
                })
                .collect();
            let (mut depths, mut normals) = (vec![0.0; 40], vec![[7.0; 3]; 40]);
            probe.depths(&rays, Depth::Median, None, &mut scratch, &mut depths).unwrap();
            probe.surface_normals(&rays, &depths, &mut scratch, &mut normals).unwrap();
            for (i, normal) in normals.iter().enumerate() {
                let expected = if i % 3 == 0 { [0.0; 3] } else { up };
                let off = normal.iter().zip(expected).map(|(a, b)| (a - b).abs());
                assert!(
                    off.fold(0.0, f32::max) < 0.02,
                    "{i}: {normal:?} at {}, expected {expected:?}",
                    depths[i]
                );
            }
            let short = probe.surface_normals(&rays, &depths[1..], &mut scratch, &mut normals);
            assert!(short.is_err(), "{short:?}");
            let still = [Ray { direction: [0.0; 3], ..rays[0] }];
            let refused = probe.surface_normals(&still, &[1.0], &mut scratch, &mut normals[..1]);
            assert!(refused.is_err(), "{refused:?}");
        }
    }
}
