//! Transparency that is wrong.

use pocketnerf_train::dataset::View;

use crate::stress::{Bar, Case, Change, Mode, Training, Viewing};

pub(super) const MODES: &[Mode] = &[
    Mode {
        name: "half-transparent",
        what: "this share of the photographs half as opaque as it should be",
        unit: "share",
        strengths: &[0.02, 0.1, 0.3],
        quick: 0.1,
        bar: Bar::Loss(0.5),
        cause: "Photographs that disagree on how much light passes.",
        published: "",
        case: |strength, context| {
            let training =
                Training::changed("half-transparent", strength, |views, share, random| {
                    for view in views {
                        if f64::from(random.next_f32()) < share {
                            view.rgba.iter_mut().skip(3).step_by(4).for_each(|alpha| *alpha /= 2);
                        }
                    }
                });
            context.has_alpha.then(|| Case::trained(training))
        },
    },
    Mode {
        name: "alpha-lost",
        what: "this share of the photographs opaque over black",
        unit: "share",
        strengths: &[0.02, 0.1, 1.0],
        quick: 0.1,
        bar: Bar::Loss(0.5),
        cause: "Where some cut-outs have lost their alpha, empty space is black in some views and \
                nothing in others.",
        published: "nerfstudio #2979: alpha dropped",
        case: |strength, context| {
            let training = Training::changed("alpha-lost", strength, |views, share, random| {
                for view in views {
                    if f64::from(random.next_f32()) < share {
                        over(view, 0.0);
                    }
                }
            });
            let black = || Viewing::with(&["--background", "black"]);
            context.has_alpha.then(|| Case {
                viewing: black(),
                reference: (Training::default(), black()),
                ..Case::trained(training)
            })
        },
    },
    Mode {
        name: "opaque",
        what: "all photographs opaque, over a grey level",
        unit: "grey",
        strengths: &[0.0, 0.5, 1.0],
        quick: 1.0,
        bar: Bar::Loss(1.0),
        cause: "Without silhouettes the scene may lie anywhere, and fog before each camera explains \
                its picture.",
        published: "nerfstudio #1441: hotdog 19 dB, 27 with the right background",
        case: |strength, context| {
            let grey = format!("{strength},{strength},{strength}");
            let seen = || Viewing::with(&["--background", &grey]);
            let training = Training::changed("opaque", strength, |views, grey, _| {
                views.iter_mut().for_each(|view| over(view, grey as f32));
            });
            context.has_alpha.then(|| Case {
                viewing: seen(),
                reference: (Training::default(), seen()),
                ..Case::trained(training)
            })
        },
    },
    Mode {
        name: "translucent-pixel",
        what: "opaque photographs of which one has so many translucent pixels",
        unit: "pixels",
        strengths: &[1.0, 5.0],
        quick: 1.0,
        bar: Bar::Loss(0.3),
        cause: "A flaw of one image must not make a program take all for cut-outs.",
        published: "",
        case: |strength, _| {
            let change = |strength| {
                let apply: fn(&mut Vec<View>, f64, &mut _) = |views, n, _| {
                    views.iter_mut().for_each(|view| over(view, 1.0));
                    if let Some(view) = views.first_mut() {
                        let alpha = view.rgba.iter_mut().skip(3).step_by(4);
                        alpha.take(n as usize).for_each(|alpha| *alpha = 200);
                    }
                };
                Training {
                    change: Some(Change { name: "translucent", strength, apply }),
                    ..Training::default()
                }
            };
            Some(Case {
                reference: (change(0.0), Viewing::with(&["--background", "white"])),
                viewing: Viewing::with(&["--background", "white"]),
                ..Case::trained(change(strength))
            })
        },
    },
    Mode {
        name: "test-background",
        what: "looked at against a grey level instead of the usual background",
        unit: "grey",
        strengths: &[0.0, 0.5, 1.0],
        quick: 0.0,
        bar: Bar::Loss(1.5),
        cause: "Holes and haze show against colours that training did not have behind them.",
        published: "instant-ngp #1266: lego 36.1 dB, 29.8 with another background at test",
        case: |strength, context| {
            let grey = format!("{strength},{strength},{strength}");
            let seen = Viewing::with(&["--background", &grey]);
            context.has_alpha.then(|| Case::viewed(seen, Viewing::default()))
        },
    },
];

/// Opaque, over a grey level from 0 to 1.
fn over(view: &mut View, grey: f32) {
    for [r, g, b, a] in view.rgba.as_chunks_mut::<4>().0 {
        let alpha = f32::from(*a) / 255.0;
        for value in [r, g, b] {
            *value = (f32::from(*value) * alpha + 255.0 * grey * (1.0 - alpha)).round() as u8;
        }
        *a = 255;
    }
}
