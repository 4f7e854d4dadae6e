//! Settings: seeds, length, size, box, limits.

use crate::stress::{Bar, Case, Context, Mode, Photos, Training, Viewing};

pub(super) const MODES: &[Mode] = &[
    Mode {
        name: "seed",
        what: "another random seed",
        unit: "seed",
        strengths: &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0],
        quick: 1.0,
        bar: Bar::Loss(1.0),
        cause: "A field that starts unluckily may end empty or all background. A run that has learnt \
                nothing is noticed after some hundred steps and begins again with another seed.",
        published: "nerfbaselines.github.io, official code: NeRF's mic 13.03 dB instead of 32.91; \
                    kwea123/nerf_pl #46: 3 of 5 lego runs at 9 to 10 dB",
        case: |strength, _| {
            Some(Case::trained(Training { seed: strength as u64, ..Training::default() }))
        },
    },
    Mode {
        name: "training-background",
        what: "learnt and seen against one grey level instead of random colours",
        unit: "grey",
        strengths: &[0.0, 0.5, 1.0],
        quick: 1.0,
        bar: Bar::Loss(1.5),
        cause: "Against one colour, what has that colour may become a hole, or empty space a wall.",
        published: "nerfacc: instant-ngp on constant white 32.35 instead of 33.18 dB",
        case: |strength, context| {
            let grey = format!("{strength},{strength},{strength}");
            let background = ["--background", &grey];
            context.has_alpha.then(|| Case {
                viewing: Viewing::with(&background),
                reference: (Training::default(), Viewing::with(&background)),
                ..Case::trained(Training::with(&background))
            })
        },
    },
    Mode {
        name: "steps",
        what: "too few steps",
        unit: "share",
        strengths: &[0.05, 0.1, 0.25, 0.5],
        quick: 0.1,
        bar: Bar::Loss(1.0),
        cause: "A field needs some hundred steps to take shape. Runs of fewer than 512 steps say so.",
        published: "",
        case: |strength, context| {
            let steps = (strength * f64::from(context.steps)).max(1.0) as u32;
            Some(Case::trained(Training { steps: Some(steps), ..Training::default() }))
        },
    },
    Mode {
        name: "learning-rate",
        what: "learning rates so many times as high",
        unit: "times",
        strengths: &[0.25, 0.5, 2.0, 4.0, 8.0],
        quick: 4.0,
        bar: Bar::Loss(1.0),
        cause: "Steps that are too long jump over what they look for: parameters end as fog, empty, or \
                not finite. A run that has learnt nothing begins again with another seed.",
        published: "CNC, README: a rate of 6e-3 instead of the paper's 1e-2 is more stable",
        case: |strength, _| {
            Some(Case::trained(Training::with(&["--learning-rate", &strength.to_string()])))
        },
    },
    Mode {
        name: "table-size",
        what: "tables of fewer entries",
        unit: "log2",
        strengths: &[8.0, 10.0, 12.0, 14.0],
        quick: 10.0,
        bar: Bar::Loss(1.5),
        cause: "Few entries serve several places at once.",
        published: "",
        case: |strength, context| {
            let options = context.entries?(strength);
            Some(Case::trained(Training::with(&options.each_ref().map(String::as_str))))
        },
    },
    Mode {
        name: "precision",
        what: "weights stored in so many bits instead of 32",
        unit: "bits",
        strengths: &[8.0, 16.0],
        quick: 8.0,
        bar: Bar::Loss(0.1),
        cause: "Rounding; large values overflow. Training itself reads rounded weights.",
        published: "PlenVDB, table 4: voxels in f16, 0.00 dB",
        case: |strength, context| {
            let name = if strength < 16.0 { "i8" } else { "f16" };
            let reference = Training::with(&["--precision", "f32"]);
            // Without tables nothing is stored in eight bits.
            (context.entries.is_some() || name != "i8").then(|| Case {
                reference: (reference, Viewing::default()),
                ..Case::trained(Training::with(&["--precision", name]))
            })
        },
    },
    Mode {
        name: "box-size",
        what: "a box of so many times the right side",
        unit: "times",
        strengths: &[0.5, 0.8, 1.5, 2.0, 4.0],
        quick: 0.5,
        bar: Bar::Loss(0.5),
        cause: "Too small a box cuts the scene off and what is outside is smeared over its walls; too \
                large a one wastes cells and entries on nothing.",
        published: "TensoRF #37, #46: wrong boxes train at 24 to 25 dB and test at 9 to 12",
        case: |strength, context| {
            case_of_box(context, |low, high| {
                let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
                [middle - strength as f32 * half, middle + strength as f32 * half]
            })
        },
    },
    Mode {
        name: "box-shift",
        what: "a box shifted by this share of its side",
        unit: "share",
        strengths: &[0.1, 0.2, 0.4],
        quick: 0.2,
        bar: Bar::Loss(0.5),
        cause: "What lies outside the box cannot be learnt.",
        published: "",
        case: |strength, context| {
            case_of_box(context, |low, high| {
                [low, high].map(|side| side + strength as f32 * (high - low))
            })
        },
    },
    Mode {
        name: "near",
        what: "nothing learnt nearer than this share of the cameras' distance",
        unit: "share",
        strengths: &[0.5, 0.8, 0.95],
        quick: 0.95,
        bar: Bar::Loss(0.5),
        cause: "What lies before the near plane cannot be seen.",
        published: "",
        case: |strength, context| {
            let near = (strength * context.distance).to_string();
            Some(Case::trained(Training::with(&["--near", &near])))
        },
    },
    Mode {
        name: "far",
        what: "nothing learnt farther than this share of the cameras' distance",
        unit: "share",
        strengths: &[0.9, 1.0, 1.3],
        quick: 1.0,
        bar: Bar::Loss(0.5),
        cause: "What lies behind the far plane cannot be seen.",
        published: "",
        case: |strength, context| {
            let far = (strength * context.distance).to_string();
            Some(Case::trained(Training::with(&["--far", &far])))
        },
    },
    Mode {
        name: "space",
        what: "a forward-facing capture learnt in a box",
        unit: "on",
        strengths: &[1.0],
        quick: 1.0,
        bar: Bar::Loss(1.0),
        cause: "Far things need cells that grow with their distance: normalised device coordinates.",
        published: "bmild/nerf #47: normalised device coordinates for a half space only",
        case: |_, context| {
            let given =
                |options: &[&str]| Training { photos: Photos::Given, ..Training::with(options) };
            context.forward_facing.then(|| Case {
                reference: (given(&[]), Viewing::default()),
                ..Case::trained(given(&["--space", "box"]))
            })
        },
    },
];

/// A run in a box whose sides along each axis are made of the right ones.
fn case_of_box(context: &Context, side: impl Fn(f32, f32) -> [f32; 2]) -> Option<Case> {
    let [low, high] = context.aabb?;
    let sides = [0, 1, 2].map(|axis| side(low[axis], high[axis]));
    let numbers = [0, 1].iter().flat_map(|end| sides.map(|side| side[*end].to_string()));
    let text = numbers.collect::<Vec<_>>().join(",");
    Some(Case::trained(Training::with(&["--aabb", &text])))
}
