//! Metashape's sensors.
//!
//! "Camera models" in the Metashape Professional manual: with x = X / Z, y = Y / Z (right, down,
//! forward) and r² = x² + y²,
//!
//! x' = x (1 + K1 r² + K2 r⁴ + K3 r⁶ + K4 r⁸) + P1 (r² + 2 x²) + 2 P2 x y,
//! y' = y (1 + K1 r² + K2 r⁴ + K3 r⁶ + K4 r⁸) + P2 (r² + 2 y²) + 2 P1 x y,
//! u = w / 2 + cx + x' (f + B1) + y' B2 and v = h / 2 + cy + y' f,
//!
//! the first pixel's centre at (0.5, 0.5). So its P1 and P2 are OpenCV's p2 and p1 (nerfstudio's
//! `metashape_utils.py` does not exchange them). A fisheye has x and y scaled by atan(r) / r first.
//! A spherical camera shows longitude along u and latitude along v.

use roxmltree::Node;

use super::xml::{attribute, child, number};
use crate::dataset::intrinsics::Intrinsics;
use crate::lens::Lens;

/// A camera's optics.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sensor {
    pub(super) intrinsics: Intrinsics,
    pub(super) lens: Lens,
    /// Whether photographs were taken row after row while the camera moved.
    pub(super) is_rolling: bool,
}

impl Sensor {
    /// `None` where it is not calibrated.
    pub(super) fn read(sensor: Node<'_, '_>) -> Result<Option<Self>, String> {
        let kind = sensor.attribute("type").unwrap_or("frame");
        let calibrations = || sensor.children().filter(|node| node.has_tag_name("calibration"));
        let is_adjusted = |node: &Node<'_, '_>| node.attribute("class") == Some("adjusted");
        let calibration = calibrations().find(is_adjusted).or_else(|| calibrations().next());
        let size = calibration.and_then(resolution).or_else(|| resolution(sensor));
        let size = size.ok_or("no <resolution>, expected width and height")?;
        let rolling = child(sensor, "rolling_shutter").and_then(|node| node.text());
        let is_rolling = rolling.is_some_and(|text| !["0", "false", "disabled"].contains(&text));
        let (intrinsics, lens) = match (kind, calibration) {
            ("spherical", _) if size.iter().any(|side| !(1.0..1e6).contains(side)) => {
                return Err(format!("{}x{} pixels, expected 1x1 or more", size[0], size[1]));
            }
            ("spherical", _) => (Intrinsics::panorama(Some(size)), Lens::Equirectangular),
            ("frame" | "fisheye", None) => return Ok(None),
            ("frame" | "fisheye", Some(calibration)) => {
                let (pixels, lens) = bent(kind, calibration, size)?;
                (Intrinsics::from_pixels(size, pixels, &lens)?, lens)
            }
            _ => return Err(format!("a {kind} sensor, expected frame, fisheye or spherical")),
        };
        Ok(Some(Self { intrinsics, lens, is_rolling }))
    }
}

fn resolution(node: Node<'_, '_>) -> Option<[f64; 2]> {
    let node = child(node, "resolution")?;
    Some([attribute(node, "width")?, attribute(node, "height")?])
}

/// Focal lengths and principal point, and the lens.
fn bent(
    kind: &str,
    calibration: Node<'_, '_>,
    [width, height]: [f64; 2],
) -> Result<([f64; 4], Lens), String> {
    let f = number(calibration, "f")?.ok_or("no <f>, expected a focal length in pixels")?;
    let of = |name: &str| number(calibration, name).map(Option::unwrap_or_default);
    let [cx, cy, b1, b2] = [of("cx")?, of("cy")?, of("b1")?, of("b2")?];
    let k = [of("k1")?, of("k2")?, of("k3")?, of("k4")?];
    let [p1, p2] = [of("p1")?, of("p2")?];
    if of("p3")? != 0.0 || of("p4")? != 0.0 {
        return Err("p3 and p4, expected a calibration without them".to_owned());
    }
    let lens = match kind {
        "fisheye" => Lens::thin_prism_fisheye(k, [p2, p1], [0.0; 2]),
        _ => Lens::open_cv(k, [p2, p1]),
    };
    let fx = f + b1;
    // Else it is refused as a focal length.
    let lens = if fx > 0.0 { lens.skewed(b2 / fx) } else { lens };
    Ok(([fx, f, 0.5 * width + cx, 0.5 * height + cy], lens))
}
