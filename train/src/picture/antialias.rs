//! How many rays are cast a pixel.

use pocketnerf_core::Camera;
use pocketnerf_core::render::Tiles;
use pocketnerf_formats::About;

/// Rays a pixel. A field has learnt what pixels of photographs see; a ray through the centre of
/// a larger one sees a part of it, and edges become jagged. As many rays as it holds pixels of
/// the photographs see all of it, in no more time than a picture of their size takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Antialias {
    /// One, through its centre.
    #[default]
    Off,
    /// So many along each side, 1 to [`Tiles::MOST_RAYS`]; others count as the nearest of these.
    Rays(u32),
    /// As many along each side, rounded, as it is times larger than the pixels of a camera with
    /// this focal length in pixels.
    Like(f32),
}

impl Antialias {
    /// As a model's pixels are those of its photographs: [`Like`](Self::Like) these; one ray for
    /// models of other programs, which do not say what they were trained on.
    #[must_use]
    pub fn of(about: &About<'_>) -> Self {
        let is_trained = about.provenance.is_some_and(|origin| origin.trained_on != 0);
        match about.camera.filter(|_| is_trained) {
            Some(own) => Self::Like(own.camera().focal[0]),
            None => Self::Off,
        }
    }

    /// Rays along each side of a pixel of `camera`, 1 to [`Tiles::MOST_RAYS`].
    #[must_use]
    pub fn rays(self, camera: &Camera) -> u32 {
        let n = match self {
            Self::Off => 1,
            Self::Rays(n) => n,
            // A cast cuts off, and takes NaN to 0.
            Self::Like(focal) => (focal / camera.focal[0]).round() as u32,
        };
        n.clamp(1, Tiles::MOST_RAYS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_by_hand() {
        let pose = Camera::look_at([4.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let at = |width: u32| Camera::from_fov_x(width, 9, 0.7, pose);
        let like = Antialias::Like(at(800).focal[0]);
        for (width, n) in [(1600, 1), (800, 1), (540, 1), (530, 2), (400, 2), (267, 3), (100, 8)] {
            assert_eq!(like.rays(&at(width)), n, "{width}");
            assert_eq!(Antialias::Off.rays(&at(width)), 1);
            assert_eq!(Antialias::Rays(5).rays(&at(width)), 5);
        }
        assert_eq!(like.rays(&at(1)), Tiles::MOST_RAYS);
        assert_eq!(Antialias::Rays(0).rays(&at(8)), 1);
        assert_eq!(Antialias::Rays(u32::MAX).rays(&at(8)), Tiles::MOST_RAYS);
        assert_eq!(Antialias::Like(f32::NAN).rays(&at(8)), 1);
    }
}
