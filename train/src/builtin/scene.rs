//! The built-in scenes by name: their datasets, and their truth from any camera.

use super::cameras::{AROUND, INSIDE, OUTDOORS, Region};
use super::{render, scenes};
use crate::dataset::{Dataset, Split, View};
use pocketnerf_core::Camera;

/// A built-in scene.
///
/// Each but the first shows one thing at which radiance fields fail. Cameras look at the
/// origin, in the village a little past it; but for the room and the village, everything lies
/// within 1.25 units of it in x and y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scene {
    /// A still life: a bit of everything.
    StillLife,
    /// Wires from a quarter of an occupancy cell (1/128 of the scene's side) to two cells
    /// across.
    Wires,
    /// Polished bodies that mirror each other and a sharp lamp.
    Glossy,
    /// Tinted glass before the empty background, in several layers.
    Glass,
    /// Hundreds of leaves on twigs.
    Foliage,
    /// Balls of fog with soft edges, around and beside solid bodies.
    Fog,
    /// A matt white ball, which hardly differs from a white background.
    White,
    /// A furnished room, 3.8 × 3.4 × 2.2 units, seen from inside.
    Room,
    /// A well on an endless meadow, houses and trees around it, houses and hills far away, and
    /// a sky, all opaque.
    Village,
}

impl Scene {
    /// All scenes.
    pub const ALL: [Self; 9] = [
        Self::StillLife,
        Self::Wires,
        Self::Glossy,
        Self::Glass,
        Self::Foliage,
        Self::Fog,
        Self::White,
        Self::Room,
        Self::Village,
    ];

    /// Its name on a command line: `still-life`, `wires` and so on.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::StillLife => "still-life",
            Self::Wires => "wires",
            Self::Glossy => "glossy",
            Self::Glass => "glass",
            Self::Foliage => "foliage",
            Self::Fog => "fog",
            Self::White => "white",
            Self::Room => "room",
            Self::Village => "village",
        }
    }

    /// The scene of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scene| scene.name() == name)
    }

    /// The views of one split, rendered at [`SIZE`](super::SIZE) divided by
    /// `downscale_factor`.
    ///
    /// Held-out views lie halfway between two training views. [`Split::Val`] and
    /// [`Split::Test`] have none in common, but for the still life, which is frozen: its are
    /// the same.
    #[must_use]
    pub fn dataset(self, split: Split, downscale_factor: u32) -> Dataset {
        let region = self.region();
        let (cameras, prefix) = match (split, self) {
            (Split::Train, _) => (region.train(), "train"),
            (Split::Val | Split::Test, Self::StillLife) => (region.held_out(), "held_out"),
            (Split::Val, _) => (region.validation(), "val"),
            (Split::Test, _) => (region.held_out(), "test"),
        };
        let small = |camera: &Camera| camera.downscaled(downscale_factor.max(1));
        let views = self.views(&cameras.iter().map(small).collect::<Vec<_>>(), prefix);
        let source = match self {
            Self::StillLife => "built-in scene".to_owned(),
            other => format!("built-in scene {}", other.name()),
        };
        // Nothing tells how far an opaque scene reaches.
        let aabb = (self == Self::Room).then_some(scenes::ROOM_BOX);
        Dataset { aabb, ..Dataset::new(source, "built-in", split, views) }
    }

    /// What these cameras see, in their order: any number of any size, from anywhere outside
    /// of solid bodies. View i is called `prefix/i`, with two digits or more.
    ///
    /// Pixels are straight RGBA on a transparent background, or the village's sky; alpha is
    /// coverage and opacity.
    /// Depth is where transmittance falls to one half along the ray through the pixel's
    /// centre, scene units: the distance of the first surface, but for glass and fog. It is
    /// infinite where that much light passes, and on the sky, so a pixel at an outline may be
    /// partly covered and still have infinite depth.
    #[must_use]
    pub fn views(self, cameras: &[Camera], prefix: &str) -> Vec<View> {
        let contents = scenes::contents(self);
        cameras
            .iter()
            .enumerate()
            .map(|(i, camera)| {
                let (rgba, depth) = render::view(&contents, camera);
                let view = View::new(format!("{prefix}/{i:02}"), *camera, rgba);
                View { depth: Some(depth), ..view }
            })
            .collect()
    }

    /// `n` cameras of [`SIZE`](super::SIZE), spread evenly over the part of a sphere on which
    /// the scene's views lie, and not on their path.
    ///
    /// All look as the views do, from `distance_factor` times their distance from the origin:
    /// 4 units, in the room 0.95, in the village 4 (the lowest) to 2.5 (the highest). The
    /// factor is held within 0.4 and 100, in the room within 0.5 and 1.2, in the village
    /// within 0.5 and 1.1, so that no camera enters a body.
    #[must_use]
    pub fn cameras(self, n: usize, distance_factor: f32) -> Vec<Camera> {
        self.region().spread(n, distance_factor)
    }

    /// Where its views lie.
    fn region(self) -> &'static Region {
        match self {
            Self::Room => &INSIDE,
            Self::Village => &OUTDOORS,
            _ => &AROUND,
        }
    }
}
