//! Intrinsics and lenses of `transforms.json`.

use serde::Deserialize;

use crate::dataset::intrinsics::{Focal, Intrinsics};
use crate::lens::Lens;

/// What stands at the top of the file or in a frame, which goes before it.
#[derive(Default, Deserialize)]
#[serde(expecting = "an object")]
pub(super) struct RawCamera {
    x_fov: Option<f64>,
    y_fov: Option<f64>,
    fl_x: Option<f64>,
    fl_y: Option<f64>,
    camera_angle_x: Option<f64>,
    camera_angle_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    w: Option<f64>,
    h: Option<f64>,
    k1: Option<f64>,
    k2: Option<f64>,
    k3: Option<f64>,
    k4: Option<f64>,
    p1: Option<f64>,
    p2: Option<f64>,
    distortion_params: Option<Vec<f64>>,
    is_fisheye: Option<bool>,
    camera_model: Option<String>,
    rolling_shutter: Option<Vec<f64>>,
    ftheta_p0: Option<f64>,
    latlong: Option<bool>,
    equirectangular: Option<bool>,
    orthographic: Option<bool>,
}

/// Why a camera was refused; part of a line.
pub(super) enum Refused {
    /// A number that no camera has.
    Problem(String),
    /// Something that is not known here, by its name.
    NotReadable(String),
}

const PERSPECTIVE: [&str; 5] = ["OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL"];
const FISHEYE: [&str; 3] = ["OPENCV_FISHEYE", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE"];

/// Whether a frame is a panorama: nerfstudio's EQUIRECTANGULAR, instant-ngp's `latlong`.
fn is_panorama(top: &RawCamera, frame: &RawCamera) -> bool {
    let model = frame.camera_model.as_ref().or(top.camera_model.as_ref());
    model.is_some_and(|model| model == "EQUIRECTANGULAR")
        || frame.latlong.or(top.latlong) == Some(true)
}

/// A frame's intrinsics. A focal length is searched in the order `x_fov` (degrees),
/// `fl_x` (pixels), `camera_angle_x` (radians), first in the frame.
pub(super) fn intrinsics(top: &RawCamera, frame: &RawCamera) -> Result<Intrinsics, Refused> {
    let size = match [frame.w.or(top.w), frame.h.or(top.h)] {
        [Some(w), Some(h)] if [w, h].iter().all(|side| (1.0..1e6).contains(side)) => Some([w, h]),
        [None, None] => None,
        [w, h] => {
            let shown = [w, h].map(|v| v.map_or_else(|| "nothing".to_owned(), |v| v.to_string()));
            let [w, h] = shown;
            return Err(Refused::Problem(format!("w is {w} and h is {h}, expected pixels")));
        }
    };
    if is_panorama(top, frame) {
        // The whole image, whatever a focal length means there.
        return Ok(Intrinsics::panorama(size));
    }
    let own = frame.focal()?;
    let is_own = own != [None; 2];
    let focal = if is_own { own } else { top.focal()? };
    if focal == [None; 2] {
        return Err(Refused::Problem(
            "no focal length, expected fl_x in pixels, camera_angle_x in radians or x_fov in degrees"
                .to_owned(),
        ));
    }
    let center = [frame.cx.or(top.cx), frame.cy.or(top.cy)];
    if let Some(c) = center.iter().flatten().find(|c| !(-1e6..1e6).contains(*c)) {
        return Err(Refused::Problem(format!("the principal point is at {c}, expected pixels")));
    }
    let shared = !is_own && frame.w.is_none() && frame.h.is_none();
    Ok(Intrinsics { size, focal, center, shared })
}

/// A frame's lens.
pub(super) fn lens(top: &RawCamera, frame: &RawCamera) -> Result<Lens, Refused> {
    for camera in [frame, top] {
        camera.refuse_what_cannot_be_read()?;
    }
    if is_panorama(top, frame) {
        return Ok(Lens::Equirectangular);
    }
    let model = frame.camera_model.as_deref().or(top.camera_model.as_deref());
    let is_fisheye = match model {
        None => frame.is_fisheye.or(top.is_fisheye).unwrap_or(false),
        Some(model) if FISHEYE.contains(&model) => true,
        Some(model) if PERSPECTIVE.contains(&model) => {
            frame.is_fisheye.or(top.is_fisheye).unwrap_or(false)
        }
        Some(model) => return Err(Refused::NotReadable(format!("camera_model \"{model}\""))),
    };
    let of = |pick: fn(&RawCamera) -> Option<f64>| pick(frame).or(pick(top)).unwrap_or(0.0);
    let list = frame.distortion_params.as_ref().or(top.distortion_params.as_ref());
    let (k, p) = match list.map(Vec::as_slice) {
        Some(&[k1, k2, k3, k4, p1, p2]) => ([k1, k2, k3, k4], [p1, p2]),
        Some(list) => {
            return Err(Refused::Problem(format!(
                "distortion_params has {} numbers, expected 6: k1, k2, k3, k4, p1, p2",
                list.len()
            )));
        }
        None => {
            let k = [of(|c| c.k1), of(|c| c.k2), of(|c| c.k3), of(|c| c.k4)];
            (k, [of(|c| c.p1), of(|c| c.p2)])
        }
    };
    if let Some(value) = k.iter().chain(&p).find(|value| value.abs() >= 1e6) {
        return Err(Refused::Problem(format!(
            "a lens coefficient is {value}, expected a small one"
        )));
    }
    if !is_fisheye {
        return Ok(Lens::open_cv(k, p));
    }
    // instant-ngp keeps four numbers, in which p1, p2 and k3, k4 share their places.
    if p != [0.0; 2] {
        return Err(Refused::NotReadable("a fisheye lens with p1 and p2".to_owned()));
    }
    Ok(Lens::fisheye(k))
}

impl RawCamera {
    fn focal(&self) -> Result<[Option<Focal>; 2], Refused> {
        let axis = |[fov, pixels, angle]: [(&str, Option<f64>); 3]| {
            let angle_in = |(name, value): (&str, Option<f64>), unit: f64, expected: &str| {
                value.map(|value| {
                    let angle = value * unit;
                    let is_sound = (0.01..std::f64::consts::PI).contains(&angle);
                    let problem = || format!("{name} is {value}, expected {expected}");
                    is_sound.then_some(Focal::Angle(angle)).ok_or_else(problem)
                })
            };
            let degrees = "degrees from 1 to below 180";
            let radians = "radians from 0.01 to below pi; degrees must be converted";
            let focal = angle_in(fov, std::f64::consts::PI / 180.0, degrees)
                .or_else(|| {
                    let (name, value) = pixels;
                    value.map(|value| {
                        let problem = || format!("{name} is {value}, expected pixels above 0");
                        let is_sound = (1e-3..1e7).contains(&value);
                        is_sound.then_some(Focal::Pixels(value)).ok_or_else(problem)
                    })
                })
                .or_else(|| angle_in(angle, 1.0, radians));
            focal.transpose().map_err(Refused::Problem)
        };
        let x =
            [("x_fov", self.x_fov), ("fl_x", self.fl_x), ("camera_angle_x", self.camera_angle_x)];
        let y =
            [("y_fov", self.y_fov), ("fl_y", self.fl_y), ("camera_angle_y", self.camera_angle_y)];
        Ok([axis(x)?, axis(y)?])
    }

    fn refuse_what_cannot_be_read(&self) -> Result<(), Refused> {
        let moves = |times: &Vec<f64>| times.iter().any(|time| *time != 0.0);
        let given = [
            ("rolling_shutter", self.rolling_shutter.as_ref().is_some_and(moves)),
            ("ftheta_p0", self.ftheta_p0.is_some()),
            ("equirectangular", self.equirectangular == Some(true)),
            ("orthographic", self.orthographic == Some(true)),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((key, _)) => Err(Refused::NotReadable(format!("\"{key}\""))),
        }
    }
}
