//! The scenes: one file each.

mod fog;
mod foliage;
mod glass;
mod glossy;
mod room;
pub(super) mod still_life;
mod village;
mod white;
pub(super) mod wires;

use super::contents::Contents;
use super::scene::Scene;
use glam::DVec2;

pub(super) use room::BOX as ROOM_BOX;
#[cfg(test)]
pub(super) use village::GROUND as VILLAGE_GROUND;

/// Cosine and sine of the golden angle, by which things go evenly around in all directions.
const GOLDEN_TURN: DVec2 = DVec2::new(-0.737_368_878, 0.675_490_294);

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
        Scene::Village => village::contents(),
    }
}
