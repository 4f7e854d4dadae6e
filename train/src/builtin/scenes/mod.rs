//! The scenes: one file each.

mod fog;
mod foliage;
mod glass;
mod glossy;
mod room;
pub(super) mod still_life;
mod white;
pub(super) mod wires;

use super::contents::Contents;
use super::scene::Scene;

pub(super) use room::BOX as ROOM_BOX;

/// What a scene is made of.
pub(super) fn contents(scene: Scene) -> Contents {
    match scene {
        Scene::StillLife => Contents::solid(still_life::bodies()).along_axes(),
        Scene::Wires => Contents::solid(wires::bodies()),
        Scene::Glossy => Contents::solid(glossy::bodies()),
        Scene::Glass => glass::contents(),
        Scene::Foliage => Contents::solid(foliage::bodies()),
        Scene::Fog => fog::contents(),
        Scene::White => Contents::solid(white::bodies()),
        Scene::Room => room::contents(),
    }
}
