//! Pixels of another size than those of the photographs that a model has learnt from.

use clap::Args;
use pocketnerf_core::render::Tiles;
use pocketnerf_core::{Camera, Space};
use pocketnerf_formats::{About, DefaultCamera, ModelFile};
use pocketnerf_train::picture::Antialias;

/// Rays a pixel, as they are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    /// As many as a pixel holds pixels of the photographs.
    Auto,
    /// So many along each side.
    Side(u32),
}

/// How many rays a pixel has.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Rendering")]
pub(super) struct Antialiasing {
    /// Rays a pixel, which is their mean: N for NxN, off for one, or auto
    ///
    /// auto: where pixels are larger than those of the photographs that the model was trained
    /// on, as many as one holds of these. Edges are smooth, and a picture takes about as long as
    /// one of the photographs' size. One ray for models of other programs, which do not say what
    /// they were trained on.
    #[arg(long, value_name = "auto|off|N", default_value = "auto", value_parser = parse_rays)]
    antialias: Asked,
}

fn parse_rays(text: &str) -> Result<Asked, String> {
    match text {
        "auto" => Ok(Asked::Auto),
        "off" => Ok(Asked::Side(1)),
        _ => {
            let n = text.parse().ok().filter(|n| (1..=Tiles::MOST_RAYS).contains(n));
            let expected =
                || format!("expected auto, off or a number from 1 to {}", Tiles::MOST_RAYS);
            n.map(Asked::Side).ok_or_else(expected)
        }
    }
}

impl Antialiasing {
    /// For pictures of the model that this is said of.
    pub(super) fn of(self, about: &About<'_>) -> Antialias {
        match self.antialias {
            Asked::Side(n) => Antialias::Rays(n),
            Asked::Auto => Antialias::of(about),
        }
    }
}

/// Pixels that show so many times as much as those of the photographs are said ...
const MORE: f32 = 1.5;
/// ... and those that show so many times as little: details that no photograph shows are lost
/// sooner.
const LESS: f32 = 1.35;

/// What to say of pictures whose rays see more or less than a pixel of the photographs that a
/// model has learnt from: they are smaller or larger, or taken from farther away or nearer.
pub(super) fn size_doubt(
    file: &ModelFile<'_>,
    camera: &Camera,
    antialias: Antialias,
) -> Option<String> {
    doubt(file.about.camera, camera, &file.model.space, antialias)
}

/// The same, of a model whose photographs are like its `own` camera's.
fn doubt(
    own: Option<DefaultCamera>,
    camera: &Camera,
    space: &Space,
    antialias: Antialias,
) -> Option<String> {
    let own = own?.camera();
    let near = nearness(&own, camera, space);
    if near > LESS {
        return Some(format!(
            "the camera is {near:.1} times as near to the scene as the photographs: none shows such \
             details; train on photographs from there"
        ));
    }
    let pixel = |camera: &Camera| 1.0 / camera.focal[0];
    let times = pixel(camera) / pixel(&own);
    let [rays, enough] = [antialias, Antialias::Like(own.focal[0])].map(|a| a.rays(camera));
    if times / rays as f32 > MORE {
        let advice = match rays < enough {
            true => format!("--antialias {enough} casts {enough}x{enough} rays a pixel"),
            false => "render them larger and scale them down".to_owned(),
        };
        Some(format!(
            "pictures of {} pixels show {times:.1} times as much in a pixel as the photographs: \
             edges are jagged; {advice}",
            camera.width
        ))
    } else if times < 1.0 / LESS {
        Some(format!(
            "pictures of {} pixels show {:.1} times as little in a pixel as the photographs: no \
             photograph shows such details; train on larger ones",
            camera.width,
            1.0 / times
        ))
    } else {
        None
    }
}

/// How many times as near to the middle of the scene a camera is as another one; 1 where they are
/// in it, or nothing is.
fn nearness(own: &Camera, camera: &Camera, space: &Space) -> f32 {
    let Some([low, high]) = space.scene_box() else { return 1.0 };
    let is_outside = |camera: &Camera| {
        let at = camera.position();
        (0..3).any(|a| at[a] < low[a] || at[a] > high[a])
    };
    let distance = |camera: &Camera| {
        let at = camera.position();
        (0..3).map(|a| (at[a] - 0.5 * (low[a] + high[a])).powi(2)).sum::<f32>().sqrt()
    };
    match is_outside(own) && is_outside(camera) {
        true => distance(own) / distance(camera),
        false => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pocketnerf_formats::Provenance;

    const OWN: DefaultCamera =
        DefaultCamera { camera_to_world: [0.0; 16], fov_x: 0.7, width: 800, height: 800 };

    #[test]
    fn pictures_of_other_pixels_are_said() {
        let at = |width: u32| Camera::from_fov_x(width, width, 0.7, OWN.camera_to_world);
        let space = Space::Box { min: [-1.0; 3], max: [1.0; 3] };
        let said = |width: u32, rays| doubt(Some(OWN), &at(width), &space, rays);
        let off = Antialias::Off;
        assert_eq!((said(800, off), said(600, off), said(1060, off)), (None, None, None));
        assert!(said(1100, off).unwrap().contains("1.4 times as little"));
        assert_eq!(doubt(None, &at(100), &space, off), None);
        let jagged = said(200, off).unwrap();
        assert!(jagged.contains("4.0 times as much") && jagged.ends_with("4x4 rays a pixel"));
        assert!(said(1600, off).unwrap().contains("2.0 times as little"));
        // Three rays a side are enough for four pixels, two are not.
        assert_eq!(said(200, Antialias::Rays(3)), None);
        assert_eq!(said(200, Antialias::Rays(2)), Some(jagged));
        let like = Antialias::Like(OWN.camera().focal[0]);
        assert!((10..800).step_by(7).all(|width| said(width, like).is_none()));
        // No tile holds the rays of a pixel.
        assert!(said(5, like).unwrap().ends_with("render them larger and scale them down"));
        assert!(said(1600, like).unwrap().contains("2.0 times as little"));
    }

    #[test]
    fn cameras_that_are_nearer_are_said() {
        let at = |distance: f32| {
            let pose = Camera::look_at([0.0, distance, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
            Camera::from_fov_x(800, 800, 0.7, pose)
        };
        let space = Space::Box { min: [-1.0; 3], max: [1.0; 3] };
        let said = |own: f32, distance: f32| {
            let like = Antialias::Like(OWN.camera().focal[0]);
            let own = DefaultCamera { camera_to_world: at(own).camera_to_world, ..OWN };
            doubt(Some(own), &at(distance), &space, like)
        };
        assert_eq!((said(4.0, 4.0), said(4.0, 3.0), said(4.0, 16.0)), (None, None, None));
        assert!(said(4.0, 2.0).unwrap().starts_with("the camera is 2.0 times as near"));
        // Inside, some things are near and some are not.
        assert_eq!((said(4.0, 0.5), said(0.9, 0.3)), (None, None));
    }

    #[test]
    fn rays_as_they_are_asked_for() {
        for (text, asked) in [("auto", Asked::Auto), ("off", Asked::Side(1)), ("8", Asked::Side(8))]
        {
            assert_eq!(parse_rays(text), Ok(asked));
        }
        for text in ["", "0", "65", "-1", "2x2", "Auto"] {
            assert!(parse_rays(text).unwrap_err().contains("1 to 64"), "{text}");
        }
        let auto = Antialiasing { antialias: Asked::Auto };
        let origin = Provenance { trained_on: 7, ..Provenance::default() };
        let trained = About { camera: Some(OWN), provenance: Some(origin), ..About::default() };
        assert_eq!(auto.of(&trained), Antialias::Like(OWN.camera().focal[0]));
        let imported = About { provenance: Some(Provenance::default()), ..trained };
        for about in [imported, About { camera: None, ..trained }, About::default()] {
            assert_eq!(auto.of(&about), Antialias::Off);
        }
        let four = Antialiasing { antialias: Asked::Side(4) };
        assert_eq!(four.of(&imported), Antialias::Rays(4));
    }
}
