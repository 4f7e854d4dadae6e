//! Cameras: how many, where, and how exactly they are known.

use std::f64::consts::TAU;

use glam::{Mat3, Quat, Vec3};
use pocketnerf_train::cameras::nearest_to_axes;
use pocketnerf_train::dataset::{View, thin};
use pocketnerf_train::random::{Random, normal};

use crate::stress::{Bar, Case, Change, Mode, Training, Viewing};

pub(super) const MODES: &[Mode] = &[
    Mode {
        name: "views",
        what: "few photographs",
        unit: "photos",
        strengths: &[50.0, 25.0, 12.0, 6.0, 3.0],
        quick: 12.0,
        bar: Bar::Loss(2.0),
        cause: "Few views are explained by fog in front of each camera as well as by surfaces.",
        published: "Plenoxels, 25 views: 26.88 dB, 28.25 with strong total variation; mi-MLP: 14.73 \
                    dB at few views without it",
        case: |strength, _| {
            Some(Case::trained(Training::changed("views", strength, |views, n, _| {
                thin(views, n as usize);
            })))
        },
    },
    Mode {
        name: "gap",
        what: "no photographs within this angle of a direction; only test views there",
        unit: "degrees",
        strengths: &[25.0, 30.0, 35.0],
        quick: 25.0,
        bar: Bar::Loss(2.0),
        cause: "Between its photographs a field shows colours that it never compared, and surfaces \
                that no near camera saw.",
        published: "",
        case: |strength, _| {
            let change = |apply| Some(Change { name: "gap", strength, apply });
            let seen = Viewing { change: change(keep_near), ..Viewing::default() };
            Some(Case {
                training: Training { change: change(leave_out_near), ..Training::default() },
                viewing: seen.clone(),
                reference: (Training::default(), seen),
            })
        },
    },
    Mode {
        name: "pose-rotation",
        what: "cameras turned at random by this standard deviation about each axis",
        unit: "degrees",
        strengths: &[0.03, 0.1, 0.3, 1.0],
        quick: 0.3,
        bar: Bar::Loss(1.0),
        cause: "Photographs whose cameras are wrong contradict each other: the field blurs.",
        published: "NSVF #25: fails at errors of 0.01 that NeRF survives; ngp_pl #30",
        case: |strength, _| {
            Some(Case::trained(Training::changed(
                "pose-rotation",
                strength,
                |views, by, random| {
                    rotate(views, by, random);
                },
            )))
        },
    },
    Mode {
        name: "pose-position",
        what: "cameras moved at random by this share of their distance along each axis",
        unit: "%",
        strengths: &[0.03, 0.1, 0.3, 1.0],
        quick: 0.3,
        bar: Bar::Loss(1.0),
        cause: "As for rotations.",
        published: "",
        case: |strength, _| {
            Some(Case::trained(Training::changed(
                "pose-position",
                strength,
                |views, by, random| {
                    shift(views, by, random);
                },
            )))
        },
    },
    Mode {
        name: "one-pose",
        what: "so many cameras that look somewhere else",
        unit: "cameras",
        strengths: &[1.0, 3.0, 6.0],
        quick: 1.0,
        bar: Bar::Loss(0.3),
        cause: "A photograph whose pose is wrong is explained by fog in front of its camera.",
        published: "",
        case: |strength, _| {
            Some(Case::trained(Training::changed("one-pose", strength, |views, by, random| {
                misplace(views, by, random);
            })))
        },
    },
    Mode {
        name: "focal-length",
        what: "a focal length that is wrong by so much",
        unit: "%",
        strengths: &[-10.0, -3.0, -1.0, 1.0, 3.0, 10.0],
        quick: 3.0,
        bar: Bar::Loss(1.0),
        cause: "No point of space is where all photographs see it.",
        published: "",
        case: |strength, _| {
            // A capture's focal length is wrong for all its pictures alike.
            Some(everywhere(Change {
                name: "focal-length",
                strength,
                apply: |views, percent, _| {
                    for view in views {
                        let wrong = 1.0 + 0.01 * percent as f32;
                        view.camera.focal = view.camera.focal.map(|focal| focal * wrong);
                    }
                },
            }))
        },
    },
    Mode {
        name: "far-away",
        what: "a scene that lies so many times the cameras' distance from the origin",
        unit: "times",
        strengths: &[10.0, 100.0, 1000.0],
        quick: 1000.0,
        bar: Bar::Loss(0.3),
        cause: "Coordinates in f32 lose what is small beside what is large.",
        published: "",
        case: |strength, _| {
            Some(everywhere(Change {
                name: "far-away",
                strength,
                apply: |views, by, random| move_away(views, by, random),
            }))
        },
    },
    Mode {
        name: "units",
        what: "scene units so many times smaller",
        unit: "times",
        strengths: &[0.001, 1000.0],
        quick: 1000.0,
        bar: Bar::Loss(0.3),
        cause: "Settings that are lengths in disguise.",
        published: "",
        case: |strength, _| {
            Some(everywhere(Change {
                name: "units",
                strength,
                apply: |views, factor, _| {
                    for view in views {
                        let m = &mut view.camera.camera_to_world;
                        [3, 7, 11].iter().for_each(|i| m[*i] *= factor as f32);
                    }
                },
            }))
        },
    },
];

/// Photographs and truth alike.
fn everywhere(change: Change) -> Case {
    Case::trained(Training { all: Some(change), ..Training::default() })
}

fn position(view: &View) -> Vec3 {
    Vec3::from(view.camera.position())
}

/// What all cameras look at.
fn focus(views: &[View]) -> Vec3 {
    let poses: Vec<[f32; 16]> = views.iter().map(|view| view.camera.camera_to_world).collect();
    let middle = || views.iter().map(position).sum::<Vec3>() / views.len().max(1) as f32;
    nearest_to_axes(&poses).map_or_else(middle, |focus| focus.as_vec3())
}

/// How far cameras are from what they look at, on average.
#[must_use]
pub fn distance(views: &[View]) -> f32 {
    let focus = focus(views);
    views.iter().map(|view| position(view).distance(focus)).sum::<f32>() / views.len().max(1) as f32
}

/// Whether a view's camera is within an angle of a direction, the same for all scenes, as seen from
/// what the cameras look at.
fn is_near(view: &View, focus: Vec3, degrees: f64) -> bool {
    // To the side and half way up, where captures of objects have cameras.
    let towards = Vec3::new(0.8, -0.6, 0.6).normalize();
    let direction = (position(view) - focus).normalize_or_zero();
    f64::from(direction.angle_between(towards)).to_degrees() < degrees
}

fn leave_out_near(views: &mut Vec<View>, degrees: f64, _: &mut Random) {
    let focus = focus(views);
    views.retain(|view| !is_near(view, focus, degrees));
}

fn keep_near(views: &mut Vec<View>, degrees: f64, _: &mut Random) {
    let focus = focus(views);
    views.retain(|view| is_near(view, focus, degrees));
}

fn turn(view: &mut View, turn: Quat) {
    let m = &mut view.camera.camera_to_world;
    // Its axes are the columns; what turns is the camera in its place.
    let axes = Mat3::from_cols_array(&[m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]]);
    let turned = axes * Mat3::from_quat(turn);
    for (column, axis) in [turned.x_axis, turned.y_axis, turned.z_axis].into_iter().enumerate() {
        for row in 0..3 {
            m[4 * row + column] = axis[row];
        }
    }
}

fn rotate(views: &mut [View], degrees: f64, random: &mut Random) {
    let deviation = degrees.to_radians() as f32;
    for view in views {
        let angles = Vec3::new(normal(random), normal(random), normal(random)) * deviation;
        turn(view, Quat::from_scaled_axis(angles));
    }
}

fn shift(views: &mut [View], percent: f64, random: &mut Random) {
    let deviation = 0.01 * percent as f32 * distance(views);
    for view in views {
        let m = &mut view.camera.camera_to_world;
        [3, 7, 11].iter().for_each(|i| m[*i] += deviation * normal(random));
    }
}

/// Cameras take the pose of one a third of the way round.
fn misplace(views: &mut [View], n: f64, random: &mut Random) {
    let all = views.len();
    let poses: Vec<[f32; 16]> = views.iter().map(|view| view.camera.camera_to_world).collect();
    let first = random.below(all.max(1));
    for k in 0..(n as usize).min(all) {
        let i = (first + k * 7) % all;
        views[i].camera.camera_to_world = poses[(i + all / 3) % all];
    }
}

fn move_away(views: &mut [View], times: f64, _: &mut Random) {
    // An angle that favours no axis.
    let (sin, cos) = (0.13 * TAU as f32).sin_cos();
    let by = Vec3::new(cos, sin, 0.5).normalize() * times as f32 * scale(views);
    for view in views {
        let m = &mut view.camera.camera_to_world;
        [(3, by.x), (7, by.y), (11, by.z)].iter().for_each(|(i, by)| m[*i] += by);
    }
}

/// A length that photographs and truth have in common: a power of two near the cameras' distance.
fn scale(views: &[View]) -> f32 {
    distance(views).log2().round().exp2()
}
