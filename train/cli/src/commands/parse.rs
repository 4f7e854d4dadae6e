//! Values of options.

use pocketnerf_core::SimdLevel;
use pocketnerf_formats::{PixelOrigin, Precision};

pub(super) fn parse_quality(text: &str) -> Result<f32, String> {
    let quality = text.parse().ok().filter(|q| (0.0..=1.0).contains(q));
    quality.ok_or_else(|| "expected a number from 0 to 1".to_owned())
}

pub(super) fn parse_pixel_origin(text: &str) -> Result<PixelOrigin, String> {
    match text {
        "center" => Ok(PixelOrigin::Center),
        "corner" => Ok(PixelOrigin::Corner),
        _ => Err("expected center or corner".to_owned()),
    }
}

pub(super) fn parse_precision(text: &str) -> Result<Precision, String> {
    match text {
        "i8" => Ok(Precision::I8),
        "f16" => Ok(Precision::F16),
        "f32" => Ok(Precision::F32),
        _ => Err("expected i8, f16 or f32".to_owned()),
    }
}

/// Seconds of a duration: `90`, `90s`, `2m` or `1h`.
pub(super) fn parse_seconds(text: &str) -> Result<f64, String> {
    let (number, unit) = match text.char_indices().last() {
        Some((at, 's')) => (&text[..at], 1.0),
        Some((at, 'm')) => (&text[..at], 60.0),
        Some((at, 'h')) => (&text[..at], 3600.0),
        _ => (text, 1.0),
    };
    let number = number.parse::<f64>().ok().filter(|number| number.is_finite());
    number
        .map(|number| number * unit)
        .ok_or_else(|| "expected a duration such as 90, 90s, 2m or 1h".to_owned())
}

/// A duration above 0 and shorter than a year, seconds.
pub(super) fn parse_positive_seconds(text: &str) -> Result<f64, String> {
    let seconds = parse_seconds(text)?;
    let fits = seconds > 0.0 && seconds < 3e7;
    fits.then_some(seconds).ok_or_else(|| "expected a duration above 0".to_owned())
}

/// A box by its corners.
pub(super) fn parse_box(text: &str) -> Result<[[f32; 3]; 2], String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([a, b, c, d, e, f])
            if [[a, d], [b, e], [c, f]]
                .iter()
                .all(|[low, high]| (1e-6..1e6).contains(&(*high - *low))) =>
        {
            Ok([[*a, *b, *c], [*d, *e, *f]])
        }
        _ => {
            Err("expected six numbers X0,Y0,Z0,X1,Y1,Z1, the first three below the others"
                .to_owned())
        }
    }
}

pub(super) fn parse_simd(name: &str) -> Result<SimdLevel, String> {
    let level: SimdLevel = name.parse().map_err(str::to_owned)?;
    level.token().map(|_| level).map_err(|e| e.to_string())
}

/// Three numbers from 0 to 1, or `white` or `black`.
pub(super) fn parse_color(text: &str) -> Result<[f32; 3], String> {
    match text {
        "white" => return Ok([1.0; 3]),
        "black" => return Ok([0.0; 3]),
        _ => {}
    }
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([r, g, b]) if [r, g, b].iter().all(|v| (0.0..=1.0).contains(*v)) => Ok([*r, *g, *b]),
        _ => Err("expected white, black or three numbers from 0 to 1: R,G,B".to_owned()),
    }
}

/// A direction: an axis, or three numbers of any length; a unit vector.
pub(super) fn parse_direction(text: &str) -> Result<[f32; 3], String> {
    let (sign, name) = match text.strip_prefix('-') {
        Some(name) => (-1.0, name),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    if let Some(axis) = ["x", "y", "z"].iter().position(|axis| *axis == name) {
        return Ok([0, 1, 2].map(|a| if a == axis { sign } else { 0.0 }));
    }
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|t| t.trim().parse()).collect();
    let direction = match numbers.as_deref() {
        Ok(&[x, y, z]) => glam::Vec3::new(x, y, z).try_normalize(),
        _ => None,
    };
    let direction = direction.filter(|direction| direction.is_finite());
    direction.map(|direction| direction.to_array()).ok_or_else(|| {
        "expected x, y, z, -x, -y, -z or three numbers that are not all 0".to_owned()
    })
}

/// A PSNR, dB.
pub(super) fn parse_psnr(text: &str) -> Result<f64, String> {
    let psnr = text.parse().ok().filter(|psnr| (1.0..=99.0).contains(psnr));
    psnr.ok_or_else(|| "expected 1 to 99 dB".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions() {
        for (text, direction) in [
            ("x", [1.0, 0.0, 0.0]),
            ("+y", [0.0, 1.0, 0.0]),
            ("-z", [0.0, 0.0, -1.0]),
            ("0, -3,4", [0.0, -0.6, 0.8]),
        ] {
            assert_eq!(parse_direction(text), Ok(direction), "{text}");
        }
        for text in ["", "-", "w", "0,0,0", "1,2", "nan,0,1", "inf,0,0", "1,2,3,4"] {
            assert!(parse_direction(text).unwrap_err().contains("not all 0"), "{text}");
        }
    }

    #[test]
    fn durations() {
        for (text, seconds) in
            [("90", 90.0), ("90s", 90.0), ("1.5m", 90.0), ("1h", 3600.0), ("1e-6", 1e-6)]
        {
            assert_eq!(parse_seconds(text), Ok(seconds), "{text}");
        }
        for text in ["", "s", "2x", "m2", "1h30m", "inf", "nans", "90 s", "2é"] {
            assert!(parse_seconds(text).unwrap_err().contains("90s"), "{text}");
        }
        assert!(parse_positive_seconds("0s").is_err() && parse_positive_seconds("9999h").is_err());
        assert_eq!(parse_positive_seconds("2m"), Ok(120.0));
    }
}
