//! SCENE, DISPLAY, DETAIL, PIXELS, QUALITY and PROVENANCE.

use pocketnerf_core::query::is_rotation;
use pocketnerf_core::{ColorSpace, Display};
use serde::{Deserialize, Serialize};

use super::Fields;
use crate::FormatError;
use crate::about::{DefaultCamera, MAX_PICTURE_SIDE, PixelOrigin, Provenance, Scene};

/// SCENE; the fields are those of [`Scene`].
#[derive(Serialize, Deserialize)]
struct SceneV1<'a> {
    scale: f32,
    rotation: [[f32; 3]; 3],
    translation: [f32; 3],
    name: Option<&'a str>,
}

pub(crate) fn read_scene<'a>(mut fields: Fields<'a>) -> Result<Scene<'a>, FormatError> {
    let SceneV1 { scale, rotation, translation, name } = fields.take()?;
    fields.check("scale", scale.is_finite() && scale > 0.0)?;
    fields.check("rotation", is_rotation(&rotation))?;
    fields.finite("translation", &translation)?;
    fields.text("name", name.unwrap_or_default())?;
    fields.finish()?;
    Ok(Scene { scale, rotation, translation, name })
}

pub(crate) fn write_scene(scene: &Scene<'_>) -> impl Serialize {
    let Scene { scale, rotation, translation, name } = *scene;
    SceneV1 { scale, rotation, translation, name }
}

/// Codes of [`ColorSpace`].
const SRGB: u8 = 0;
const LINEAR: u8 = 1;

/// DISPLAY.
#[derive(Serialize, Deserialize)]
struct DisplayV1 {
    background: [f32; 3],
    color_space: u8,
    camera: Option<CameraV1>,
}

/// The default camera in DISPLAY; the fields are those of [`DefaultCamera`].
#[derive(Serialize, Deserialize)]
struct CameraV1 {
    camera_to_world: [f32; 16],
    fov_x: f32,
    width: u32,
    height: u32,
}

pub(crate) fn read_display(
    mut fields: Fields<'_>,
) -> Result<(Display, Option<DefaultCamera>), FormatError> {
    let DisplayV1 { background, color_space, camera } = fields.take()?;
    fields.finite("background", &background)?;
    let color_space = match color_space {
        SRGB => ColorSpace::Srgb,
        LINEAR => ColorSpace::Linear,
        code => return Err(fields.unknown("colour space", code)),
    };
    let camera = match camera {
        Some(CameraV1 { camera_to_world, fov_x, width, height }) => {
            let side = 1..=MAX_PICTURE_SIDE;
            fields.finite("camera_to_world", &camera_to_world)?;
            fields.check("fov_x", fov_x > 0.0 && fov_x < core::f32::consts::PI)?;
            fields.check("width and height", side.contains(&width) && side.contains(&height))?;
            Some(DefaultCamera { camera_to_world, fov_x, width, height })
        }
        None => None,
    };
    fields.finish()?;
    Ok((Display { background, color_space, tolerance: Display::TOLERANCE }, camera))
}

/// The section's bytes; `None` for a colour space that the format has no code for.
pub(crate) fn write_display(
    display: &Display,
    camera: Option<&DefaultCamera>,
) -> Option<impl Serialize> {
    let color_space = match display.color_space {
        ColorSpace::Srgb => SRGB,
        ColorSpace::Linear => LINEAR,
        _ => return None,
    };
    let camera = camera.map(|&DefaultCamera { camera_to_world, fov_x, width, height }| CameraV1 {
        camera_to_world,
        fov_x,
        width,
        height,
    });
    Some(DisplayV1 { background: display.background, color_space, camera })
}

/// PIXELS: a code.
pub(crate) fn read_pixels(mut fields: Fields<'_>) -> Result<PixelOrigin, FormatError> {
    let origin = match fields.take()? {
        0u8 => PixelOrigin::Center,
        1 => PixelOrigin::Corner,
        code => return Err(fields.unknown("origin", code)),
    };
    fields.finish()?;
    Ok(origin)
}

pub(crate) fn write_pixels(origin: PixelOrigin) -> impl Serialize {
    u8::from(origin == PixelOrigin::Corner)
}

/// QUALITY: the number itself.
pub(crate) fn read_quality(mut fields: Fields<'_>) -> Result<f32, FormatError> {
    let quality = fields.take()?;
    fields.check("quality", (0.0..=1.0).contains(&quality))?;
    fields.finish()?;
    Ok(quality)
}

pub(crate) fn write_quality(quality: f32) -> impl Serialize {
    quality
}

/// DETAIL; the field is that of [`Display`].
#[derive(Serialize, Deserialize)]
struct DetailV1 {
    tolerance: f32,
}

pub(crate) fn read_detail(mut fields: Fields<'_>) -> Result<f32, FormatError> {
    let DetailV1 { tolerance } = fields.take()?;
    fields.check("tolerance", (0.0..0.25).contains(&tolerance))?;
    fields.finish()?;
    Ok(tolerance)
}

pub(crate) fn write_detail(tolerance: f32) -> impl Serialize {
    DetailV1 { tolerance }
}

/// PROVENANCE; the fields are those of [`Provenance`].
#[derive(Serialize, Deserialize)]
struct ProvenanceV1<'a> {
    program: &'a str,
    method: &'a str,
    seed: u64,
    steps: u64,
    trained_on: u64,
    dataset: &'a str,
    train_psnr: Option<f32>,
}

pub(crate) fn read_provenance<'a>(mut fields: Fields<'a>) -> Result<Provenance<'a>, FormatError> {
    let ProvenanceV1 { program, method, seed, steps, trained_on, dataset, train_psnr } =
        fields.take()?;
    fields.text("program", program)?;
    fields.text("method", method)?;
    fields.text("dataset", dataset)?;
    fields.finite("train_psnr", &[train_psnr.unwrap_or_default()])?;
    fields.finish()?;
    Ok(Provenance { program, method, seed, steps, trained_on, dataset, train_psnr })
}

pub(crate) fn write_provenance(provenance: &Provenance<'_>) -> impl Serialize {
    let Provenance { program, method, seed, steps, trained_on, dataset, train_psnr } = *provenance;
    ProvenanceV1 { program, method, seed, steps, trained_on, dataset, train_psnr }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::{SectionId, kind};
    use crate::metadata::{encode, test_section};

    fn fields(kind: u32, bytes: &[u8]) -> Fields<'_> {
        Fields::open(&test_section(kind, bytes)).unwrap()
    }

    fn bad<T>(kind: u32, field: &'static str) -> Result<T, FormatError> {
        Err(FormatError::Value { section: SectionId::first(kind), field })
    }

    #[test]
    fn bytes_of_scene_v1() {
        let scene = Scene {
            scale: 2.0,
            translation: [0.5, 1.0, -2.0],
            name: Some("fox"),
            ..Scene::default()
        };
        let bytes = encode(&write_scene(&scene));
        #[rustfmt::skip]
        let golden = [
            0, 0, 0, 0x40,
            0, 0, 0x80, 0x3f,  0, 0, 0, 0,        0, 0, 0, 0,
            0, 0, 0, 0,        0, 0, 0x80, 0x3f,  0, 0, 0, 0,
            0, 0, 0, 0,        0, 0, 0, 0,        0, 0, 0x80, 0x3f,
            0, 0, 0, 0x3f,     0, 0, 0x80, 0x3f,  0, 0, 0, 0xc0,
            1, 3, b'f', b'o', b'x',
        ];
        assert_eq!(bytes, golden);
        assert_eq!(read_scene(fields(kind::SCENE, &bytes)), Ok(scene));
    }

    #[test]
    fn scene_must_be_a_similarity() {
        let read = |scene: &Scene<'_>| {
            read_scene(fields(kind::SCENE, &encode(&write_scene(scene)))).map(|_| ())
        };
        let scene = Scene::default();
        for scale in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(read(&Scene { scale, ..scene }), bad(kind::SCENE, "scale"));
        }
        for i in [f32::NAN, 2.0, -1.0] {
            let rotation = [[i, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
            assert_eq!(read(&Scene { rotation, ..scene }), bad(kind::SCENE, "rotation"));
        }
        let name = Some("\x1b[2J");
        assert_eq!(read(&Scene { name, ..scene }), bad(kind::SCENE, "name"));
    }

    #[test]
    fn bytes_of_display_v1() {
        let display = Display {
            background: [1.0, 0.0, 0.5],
            color_space: ColorSpace::Linear,
            tolerance: Display::TOLERANCE,
        };
        let bytes = encode(&write_display(&display, None).unwrap());
        assert_eq!(bytes, [0, 0, 0x80, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0x3f, 1, 0]);
        assert_eq!(read_display(fields(kind::DISPLAY, &bytes)), Ok((display, None)));

        let mut camera_to_world = [0.0; 16];
        camera_to_world[15] = 1.0;
        let camera = DefaultCamera { camera_to_world, fov_x: 0.5, width: 800, height: 600 };
        let bytes = encode(&write_display(&display, Some(&camera)).unwrap());
        assert_eq!(bytes[12..14], [1, 1]);
        assert_eq!(bytes[14..74], [0; 60]);
        assert_eq!(bytes[74..], [0, 0, 0x80, 0x3f, 0, 0, 0, 0x3f, 0xa0, 0x06, 0xd8, 0x04]);
        assert_eq!(read_display(fields(kind::DISPLAY, &bytes)), Ok((display, Some(camera))));

        let wide = DefaultCamera { fov_x: 3.2, ..camera };
        let bytes = encode(&write_display(&display, Some(&wide)).unwrap());
        assert_eq!(read_display(fields(kind::DISPLAY, &bytes)), bad(kind::DISPLAY, "fov_x"));
        let huge = DefaultCamera { width: MAX_PICTURE_SIDE + 1, ..camera };
        let bytes = encode(&write_display(&display, Some(&huge)).unwrap());
        assert_eq!(
            read_display(fields(kind::DISPLAY, &bytes)),
            bad(kind::DISPLAY, "width and height")
        );
    }

    #[test]
    fn bytes_of_quality_v1() {
        assert_eq!(encode(&write_quality(0.5)), [0, 0, 0, 0x3f]);
        for quality in [0.0, 0.125, 1.0] {
            assert_eq!(
                read_quality(fields(kind::QUALITY, &encode(&write_quality(quality)))),
                Ok(quality)
            );
        }
        for quality in [-0.1, 1.5, f32::NAN] {
            let error = bad(kind::QUALITY, "quality");
            assert_eq!(
                read_quality(fields(kind::QUALITY, &encode(&write_quality(quality)))),
                error
            );
        }
        assert!(read_quality(fields(kind::QUALITY, &[0, 0, 0])).is_err());
        assert!(read_quality(fields(kind::QUALITY, &[0, 0, 0, 0, 0])).is_err());
    }

    #[test]
    fn bytes_of_pixels_v1() {
        for (code, origin) in [(0, PixelOrigin::Center), (1, PixelOrigin::Corner)] {
            assert_eq!(encode(&write_pixels(origin)), [code]);
            assert_eq!(read_pixels(fields(kind::PIXELS, &[code])), Ok(origin));
        }
        let section = SectionId::first(kind::PIXELS);
        let unknown = FormatError::UnknownCode { section, field: "origin", found: 2 };
        assert_eq!(read_pixels(fields(kind::PIXELS, &[2])), Err(unknown));
        assert!(read_pixels(fields(kind::PIXELS, &[])).is_err());
        assert!(read_pixels(fields(kind::PIXELS, &[1, 0])).is_err());
    }

    #[test]
    fn bytes_of_detail_v1() {
        let bytes = encode(&write_detail(0.125));
        assert_eq!(bytes, [0, 0, 0, 0x3e]);
        assert_eq!(read_detail(fields(kind::DETAIL, &bytes)), Ok(0.125));
        assert_eq!(read_detail(fields(kind::DETAIL, &encode(&write_detail(0.0)))), Ok(0.0));
        for tolerance in [-0.01, 0.25, f32::NAN, f32::INFINITY] {
            let bytes = encode(&write_detail(tolerance));
            let error = bad(kind::DETAIL, "tolerance");
            assert_eq!(read_detail(fields(kind::DETAIL, &bytes)), error, "{tolerance}");
        }
        assert!(read_detail(fields(kind::DETAIL, &bytes[..3])).is_err());
        assert!(read_detail(fields(kind::DETAIL, &[0, 0, 0, 0x3e, 0])).is_err());
    }

    #[test]
    fn bytes_of_provenance_v1() {
        let provenance = Provenance {
            program: "p",
            method: "m",
            seed: 300,
            steps: 5,
            trained_on: u64::MAX,
            dataset: "é",
            train_psnr: Some(1.0),
        };
        let bytes = encode(&write_provenance(&provenance));
        #[rustfmt::skip]
        let golden = [
            1, b'p',  1, b'm',  0xac, 0x02,  5,
            0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x01,
            2, 0xc3, 0xa9,
            1, 0, 0, 0x80, 0x3f,
        ];
        assert_eq!(bytes, golden);
        assert_eq!(read_provenance(fields(kind::PROVENANCE, &bytes)), Ok(provenance));
    }
}
