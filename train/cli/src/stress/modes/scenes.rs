//! Scenes that are hard for radiance fields, each of which the program makes itself.

use crate::stress::{Bar, Case, Context, Mode, Photos, Training};

pub(super) const MODES: &[Mode] = &[
    Mode {
        name: "wires",
        what: "wires of a quarter to two cells across",
        unit: "on",
        strengths: &[1.0],
        quick: 1.0,
        bar: Bar::Psnr(25.0),
        cause: "Thin things are missed by samples and fall out of occupied cells.",
        published: "nerfacc: a thread thinner than a cell is found by chance",
        case: |_, context| built_in("wires", context),
    },
    Mode {
        name: "glossy",
        what: "bodies that mirror their surroundings and a sharp lamp",
        unit: "on",
        strengths: &[1.0],
        quick: 1.0,
        bar: Bar::Psnr(24.0),
        cause: "Reflections move over a surface as the view does, and are taken for geometry behind it.",
        published: "Ref-NeRF; NeRF++: shape and radiance explain each other",
        case: |_, context| built_in("glossy", context),
    },
    Mode {
        name: "glass",
        what: "tinted glass before and around other things",
        unit: "on",
        strengths: &[1.0],
        quick: 1.0,
        bar: Bar::Psnr(32.0),
        cause: "A surface that light passes looks like fog, and what lies behind it is seen less.",
        published: "",
        case: |_, context| built_in("glass", context),
    },
    Mode {
        name: "foliage",
        what: "some hundred small leaves",
        unit: "on",
        strengths: &[1.0],
        quick: 1.0,
        bar: Bar::Psnr(23.0),
        cause: "Many small surfaces share the entries of a table.",
        published: "JaxNeRF: ficus depends on the seed; mip-NeRF 360's ficus 26.66 dB at nerfbaselines.github.io",
        case: |_, context| built_in("foliage", context),
    },
    Mode {
        name: "fog",
        what: "soft balls of fog",
        unit: "on",
        strengths: &[1.0],
        quick: 1.0,
        bar: Bar::Psnr(33.0),
        cause: "Steps as long as solid surfaces allow are too long for what is thin.",
        published: "",
        case: |_, context| built_in("fog", context),
    },
    Mode {
        name: "white",
        what: "a white ball on white",
        unit: "on",
        strengths: &[1.0],
        quick: 1.0,
        bar: Bar::Psnr(46.0),
        cause: "What has the background's colour may as well be a hole.",
        published: "ngp_pl #32: the chair's white parts became background",
        case: |_, context| built_in("white", context),
    },
    Mode {
        name: "room",
        what: "a room seen from inside",
        unit: "on",
        strengths: &[1.0],
        quick: 1.0,
        bar: Bar::Psnr(23.0),
        cause: "Cameras stand in the scene: fog in front of each explains its photograph.",
        published: "nerfacc #234: a tight box gives grey pictures",
        case: |_, context| built_in("room", context),
    },
    Mode {
        name: "village",
        what: "a scene without an end, up to the sky",
        unit: "on",
        strengths: &[1.0],
        quick: 1.0,
        bar: Bar::Psnr(22.0),
        cause: "A box ends before the scene does: what lies beyond becomes fog before the cameras.",
        published: "NeRF++, mip-NeRF 360: coordinates that shrink what is far away",
        case: |_, context| built_in("village", context),
    },
];

/// A built-in scene, once: beside the still life.
fn built_in(name: &'static str, context: &Context) -> Option<Case> {
    let training = Training { photos: Photos::BuiltIn(name), ..Training::default() };
    context.still_life.then(|| Case::trained(training))
}
