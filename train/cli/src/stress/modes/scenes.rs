//! Scenes that are hard for radiance fields, each of which the program makes itself.

use crate::stress::{Bar, Case, Mode, Photos, Training};

pub(super) const MODES: &[Mode] = &[Mode {
    name: "wires",
    what: "wires thinner than a cell",
    unit: "on",
    strengths: &[1.0],
    quick: 1.0,
    bar: Bar::Psnr(25.0),
    cause: "Thin things are missed by samples and fall out of occupied cells.",
    published: "nerfacc: a thread thinner than a cell is found by chance",
    case: |_, context| built_in("wires", context.built_in),
}];

/// A built-in scene, once: beside the still life.
fn built_in(name: &'static str, wanted: bool) -> Option<Case> {
    let training = Training { photos: Photos::BuiltIn(name), ..Training::default() };
    wanted.then(|| Case::trained(training))
}
