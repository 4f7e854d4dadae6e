//! The chart as one self-contained page: `index.html`.

use std::collections::BTreeMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use serde::Serialize;

use super::{Axis, Better, Chart};

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// JPEG quality of the pictures.
const JPEG: u8 = 88;

/// Pictures for the page by the points' ids.
pub type Pictures = BTreeMap<String, String>;

/// An 8-bit RGB picture as a data URL: JPEG in base 64.
///
/// # Errors
/// What encoding reports.
pub fn picture(width: u32, height: u32, rgb: &[u8]) -> Result<String, image::ImageError> {
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, JPEG).encode(
        rgb,
        width,
        height,
        ExtendedColorType::Rgb8,
    )?;
    Ok(format!("data:image/jpeg;base64,{}", STANDARD.encode(jpeg)))
}

#[derive(Serialize)]
struct Data<'c> {
    chart: &'c Chart,
    axes: Vec<AxisData>,
    pictures: &'c Pictures,
}

#[derive(Serialize)]
struct AxisData {
    key: &'static str,
    label: &'static str,
    accuracy: bool,
    more_is_better: bool,
}

/// The page, with the points' pictures.
///
/// # Errors
/// None that a chart can cause.
pub fn html(chart: &Chart, pictures: &Pictures) -> Result<String, serde_json::Error> {
    let axis = |axis: Axis| AxisData {
        key: axis.key(),
        label: axis.label(),
        accuracy: axis.is_accuracy(),
        more_is_better: axis.better() == Better::More,
    };
    let axes = Axis::ALL.map(axis).into();
    let data = serde_json::to_string(&Data { chart, axes, pictures })?;
    // No text of a point may end the element.
    let data = data.replace('<', "\\u003c");
    let page = PAGE.replacen("/*STYLE*/", STYLE, 1).replacen("/*SCRIPT*/", SCRIPT, 1);
    Ok(page.replacen("/*DATA*/", &data, 1))
}
