//! Files that are broken.

use std::io;
use std::path::Path;

use crate::stress::{Bar, Case, Damage, Mode, Training};

pub(super) const MODES: &[Mode] = &[
    Mode {
        name: "cut-short",
        what: "so many image files that end in the middle",
        unit: "files",
        strengths: &[1.0, 3.0, 20.0],
        quick: 1.0,
        bar: Bar::Loss(0.3),
        cause: "Up to a tenth of the photographs are left out with a note; more is refused.",
        published: "",
        case: |strength, _| {
            Some(damaged("cut-short", strength, |image| {
                let bytes = std::fs::read(image)?;
                std::fs::write(image, &bytes[..bytes.len() / 2])
            }))
        },
    },
    Mode {
        name: "missing",
        what: "so many image files that are not there",
        unit: "files",
        strengths: &[1.0, 3.0, 20.0],
        quick: 1.0,
        bar: Bar::Loss(0.3),
        cause: "Frames without an image are left out with a note; most of them is refused.",
        published: "",
        case: |strength, _| Some(damaged("missing", strength, |image| std::fs::remove_file(image))),
    },
];

/// Does something to the first images, every third from the second on.
fn damaged(name: &'static str, strength: f64, what: fn(&Path) -> io::Result<()>) -> Case {
    let damage = Damage { name, strength, what };
    Case::trained(Training { damage: Some(damage), ..Training::default() })
}
