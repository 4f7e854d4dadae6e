//! Ways to look: size, distance, shortcuts.

use crate::stress::{Bar, Case, Mode, Training, Viewing};

pub(super) const MODES: &[Mode] = &[
    Mode {
        name: "skipping",
        what: "empty space skipped, compared with every step taken",
        unit: "on",
        strengths: &[1.0],
        quick: 1.0,
        bar: Bar::Loss(0.02),
        cause: "Thin things fall out of the cells that are visited.",
        published: "instant-ngp #360; nerfacc #72: sample positions that differ when skipping",
        case: |_, _| {
            Some(Case::viewed(
                Viewing::with(&["--quality", "1"]),
                Viewing::with(&["--quality", "1", "--no-skip"]),
            ))
        },
    },
    Mode {
        name: "quality",
        what: "pictures of this quality, compared with every pixel rendered",
        unit: "quality",
        strengths: &[0.0, 0.5],
        quick: 0.0,
        bar: Bar::Loss(1.0),
        cause: "Pixels whose neighbours agree are interpolated.",
        published: "",
        case: |strength, _| {
            let quality = strength.to_string();
            Some(Case::viewed(
                Viewing::with(&["--quality", &quality]),
                Viewing::with(&["--quality", "1"]),
            ))
        },
    },
    Mode {
        name: "smaller-pictures",
        what: "pictures so many times smaller, compared with a model trained at that size",
        unit: "times",
        strengths: &[2.0, 4.0, 8.0],
        quick: 2.0,
        bar: Bar::Loss(1.0),
        cause: "A ray through a pixel's centre sees a point of what the pixel sees the mean of; as \
                many rays as it holds pixels of the photographs see all of it.",
        published: "mip-NeRF: NeRF 31.2 dB at the full size, 22.5 at an eighth of it",
        case: |strength, _| Some(resized(strength.log2() as i32)),
    },
    Mode {
        name: "larger-pictures",
        what: "pictures so many times larger, compared with a model trained at that size",
        unit: "times",
        strengths: &[2.0],
        quick: 2.0,
        bar: Bar::Loss(1.0),
        cause: "Details that photographs do not show cannot be learnt; steps between samples show.",
        published: "Mip-Splatting: zooming in erodes, zooming out thickens",
        case: |strength, context| {
            let smaller = -(strength.log2() as i32);
            (context.downscale_factor.is_multiple_of(strength as u32)).then(|| resized(smaller))
        },
    },
    Mode {
        name: "distance",
        what: "cameras so many times as far away as in training",
        unit: "times",
        strengths: &[0.5, 0.7, 1.5, 2.0, 4.0],
        quick: 2.0,
        bar: Bar::Loss(2.0),
        cause: "From afar a pixel sees the mean of what a ray sees a point of; from nearby, what no \
                photograph shows.",
        published: "nerfacc #134: smoke where the camera leaves the distance of training",
        case: |strength, context| {
            let seen = Viewing { distance: Some(strength), ..Viewing::default() };
            context.still_life.then(|| Case::viewed(seen, Viewing::default()))
        },
    },
];

/// Pictures of another size than those of training, compared with a model trained at that size.
fn resized(smaller: i32) -> Case {
    let seen = Viewing { smaller, ..Viewing::default() };
    Case {
        training: Training::default(),
        viewing: seen.clone(),
        reference: (Training { smaller, ..Training::default() }, seen),
    }
}
