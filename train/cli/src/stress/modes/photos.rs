//! Photographs that are not what the scene looks like.

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageFormat};
use pocketnerf_train::dataset::View;
use pocketnerf_train::random::{Random, normal};

use crate::stress::{Bar, Case, Mode, Training};

const PUBLISHED: &str = "";

pub(super) const MODES: &[Mode] = &[
    Mode {
        name: "exposure",
        what: "photographs brighter or darker at random by this standard deviation, on the whole as \
               bright as before",
        unit: "stops",
        strengths: &[0.05, 0.1, 0.25, 0.5],
        quick: 0.25,
        bar: Bar::Loss(1.0),
        cause: "Brightness that changes from photograph to photograph is learnt as view dependence \
                and as haze.",
        published: "instant-ngp #887: constant exposure reduces floaters",
        case: |strength, _| {
            Some(Case::trained(Training::changed("exposure", strength, |views, stops, random| {
                let own = centred(views.len(), random);
                for (view, own) in views.iter_mut().zip(own) {
                    scale(view, [(stops as f32 * own).exp2(); 3]);
                }
            })))
        },
    },
    Mode {
        name: "white-balance",
        what: "red and blue changed at random by this standard deviation, one against the other",
        unit: "share",
        strengths: &[0.02, 0.05, 0.1, 0.2],
        quick: 0.1,
        bar: Bar::Loss(1.0),
        cause: "As for exposure.",
        published: PUBLISHED,
        case: |strength, _| {
            Some(Case::trained(Training::changed(
                "white-balance",
                strength,
                |views, share, random| {
                    let own = centred(views.len(), random);
                    for (view, own) in views.iter_mut().zip(own) {
                        let by = share as f32 * own;
                        scale(view, [1.0 + by, 1.0, 1.0 - by]);
                    }
                },
            )))
        },
    },
    Mode {
        name: "blur",
        what: "a quarter of the photographs blurred by a box of this radius",
        unit: "pixels",
        strengths: &[1.0, 2.0, 4.0],
        quick: 2.0,
        bar: Bar::Loss(1.0),
        cause: "The field is as sharp as the mean of what it is shown.",
        published: "instant-ngp #887: motion blur is learnt as fuzz",
        case: |strength, _| {
            Some(Case::trained(Training::changed("blur", strength, |views, radius, random| {
                quarter(views, random, |view, _| blur(view, radius as usize));
            })))
        },
    },
    Mode {
        name: "noise",
        what: "a quarter of the photographs with noise of this standard deviation",
        unit: "of 255",
        strengths: &[5.0, 10.0, 20.0, 40.0],
        quick: 20.0,
        bar: Bar::Loss(1.0),
        cause: "Noise is averaged out as far as several views see a point, and learnt where they do not.",
        published: PUBLISHED,
        case: |strength, _| {
            Some(Case::trained(Training::changed("noise", strength, |views, deviation, random| {
                quarter(views, random, |view, random| {
                    each(view, |value| value + deviation as f32 * normal(random));
                });
            })))
        },
    },
    Mode {
        name: "jpeg",
        what: "all photographs compressed by JPEG at this quality",
        unit: "quality",
        strengths: &[90.0, 50.0, 30.0, 10.0],
        quick: 30.0,
        bar: Bar::Loss(1.5),
        cause: "Blocks differ from view to view and are averaged out.",
        published: PUBLISHED,
        case: |strength, _| {
            Some(Case::trained(Training::changed("jpeg", strength, |views, quality, _| {
                views.iter_mut().for_each(|view| jpeg(view, quality as u8));
            })))
        },
    },
    Mode {
        name: "distractor",
        what: "something in front of the scene in this share of the photographs",
        unit: "share",
        strengths: &[0.05, 0.1, 0.25],
        quick: 0.1,
        bar: Bar::Loss(1.0),
        cause: "What is there in one photograph only is explained by fog in front of its camera.",
        published: "RobustNeRF: outliers down-weighted",
        case: |strength, _| {
            Some(Case::trained(Training::changed(
                "distractor",
                strength,
                |views, share, random| {
                    distract(views, share, random);
                },
            )))
        },
    },
    Mode {
        name: "upside-down",
        what: "so many photographs upside down, as where an EXIF rotation is ignored",
        unit: "photos",
        strengths: &[1.0, 3.0, 6.0],
        quick: 1.0,
        bar: Bar::Loss(0.3),
        cause: "A photograph that contradicts all others is explained by fog in front of its camera.",
        published: PUBLISHED,
        case: |strength, _| {
            Some(Case::trained(Training::changed("upside-down", strength, |views, n, random| {
                let all = views.len();
                let first = random.below(all.max(1));
                for k in 0..(n as usize).min(all) {
                    let pixels = views[(first + 7 * k) % all].rgba.as_chunks_mut::<4>().0;
                    pixels.reverse();
                }
            })))
        },
    },
    Mode {
        name: "duplicate",
        what: "a photograph that is there so many times more",
        unit: "times",
        strengths: &[1.0, 10.0, 50.0],
        quick: 10.0,
        bar: Bar::Loss(0.3),
        cause: "It counts more than others.",
        published: PUBLISHED,
        case: |strength, _| {
            Some(Case::trained(Training::changed("duplicate", strength, |views, n, random| {
                let Some(view) = views.get(random.below(views.len().max(1))).cloned() else {
                    return;
                };
                views.extend(std::iter::repeat_n(view, n as usize));
            })))
        },
    },
];

/// Changes every colour of what is not transparent.
fn each(view: &mut View, mut change: impl FnMut(f32) -> f32) {
    for pixel in view.rgba.as_chunks_mut::<4>().0.iter_mut().filter(|pixel| pixel[3] > 0) {
        for value in &mut pixel[..3] {
            *value = change(f32::from(*value)).round().clamp(0.0, 255.0) as u8;
        }
    }
}

/// Multiplies the channels.
fn scale(view: &mut View, gains: [f32; 3]) {
    let mut channel = gains.iter().cycle();
    each(view, |value| value * channel.next().unwrap_or(&1.0));
}

/// Normal numbers whose mean is 0: how bright all photographs are together, nothing can tell.
fn centred(n: usize, random: &mut Random) -> Vec<f32> {
    let all: Vec<f32> = (0..n).map(|_| normal(random)).collect();
    let mean = all.iter().sum::<f32>() / n.max(1) as f32;
    all.into_iter().map(|value| value - mean).collect()
}

/// Does something to a quarter of the views, with random numbers.
fn quarter(views: &mut [View], random: &mut Random, mut what: impl FnMut(&mut View, &mut Random)) {
    let first = random.below(4);
    views.iter_mut().skip(first).step_by(4).for_each(|view| what(view, random));
}

/// A box filter of 2 `radius` + 1 pixels along both sides, of premultiplied colours.
fn blur(view: &mut View, radius: usize) {
    let [width, height] = [view.camera.width as usize, view.camera.height as usize];
    let mut pixels: Vec<[f32; 4]> = view
        .rgba
        .as_chunks::<4>()
        .0
        .iter()
        .map(|&[r, g, b, a]| {
            let alpha = f32::from(a);
            let [r, g, b] = [r, g, b].map(|value| f32::from(value) * alpha);
            [r, g, b, alpha]
        })
        .collect();
    for (along, stride, lines, next) in [(width, 1, height, width), (height, width, width, 1)] {
        let before = pixels.clone();
        for line in 0..lines {
            for i in 0..along {
                let range = i.saturating_sub(radius)..=(i + radius).min(along - 1);
                let n = range.clone().count() as f32;
                let mut sum = [0.0; 4];
                for j in range {
                    let value = before[line * next + j * stride];
                    sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += value);
                }
                pixels[line * next + i * stride] = sum.map(|sum| sum / n);
            }
        }
    }
    for (to, [r, g, b, alpha]) in view.rgba.as_chunks_mut::<4>().0.iter_mut().zip(pixels) {
        let straight = |value: f32| (value / alpha.max(1e-6)).round().clamp(0.0, 255.0) as u8;
        *to = [straight(r), straight(g), straight(b), alpha.round() as u8];
    }
}

/// Colours as JPEG keeps them; alpha as it is.
fn jpeg(view: &mut View, quality: u8) {
    let (width, height) = (view.camera.width, view.camera.height);
    let pixels = view.rgba.as_chunks_mut::<4>().0;
    let rgb: Vec<u8> = pixels.iter().flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, quality);
    let encoded = { encoder }.encode(&rgb, width, height, ExtendedColorType::Rgb8);
    let decoded =
        encoded.and_then(|()| image::load_from_memory_with_format(&bytes, ImageFormat::Jpeg));
    if let Ok(decoded) = decoded {
        for (pixel, new) in pixels.iter_mut().zip(decoded.into_rgb8().pixels()) {
            pixel[..3].copy_from_slice(&new.0);
        }
    }
}

/// A purple square of a fifth of the picture's width, anywhere.
fn distract(views: &mut [View], share: f64, random: &mut Random) {
    for view in views {
        let [width, height] = [view.camera.width as usize, view.camera.height as usize];
        let (is_in, side) = (f64::from(random.next_f32()) < share, width / 5);
        let at = [random.below(width - side), random.below(height.saturating_sub(side).max(1))];
        if is_in {
            let pixels = view.rgba.as_chunks_mut::<4>().0;
            for y in at[1]..(at[1] + side).min(height) {
                pixels[y * width + at[0]..][..side].fill([150, 30, 170, 255]);
            }
        }
    }
}
