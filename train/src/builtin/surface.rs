//! What the bodies of the built-in scene are made of.
//!
//! Colours are in image (sRGB-like) values from 0 to 1. The constants named
//! here set how hard the scene is; changing one changes the frozen hash.

use super::noise::{noise, wave};
use glam::DVec3;

/// Side of a grain of the stone, scene units: 1.7 pixels at the cameras' distance.
const STONE_CELL: f64 = 0.0122;
/// Amplitude of the stone's grain: beyond what a small table resolves, so it
/// bounds the error of every model from below.
const STONE_CONTRAST: f64 = 0.20;
/// Side of the board's grain, scene units: 6 pixels at the cameras' distance.
const BOARD_CELL: f64 = 0.045;
/// Amplitude of the board's grain: what a large table resolves and a small one does not.
const BOARD_CONTRAST: f64 = 0.30;
/// Amplitude of the glaze's reflection of the surroundings: what a field
/// without view dependence cannot show.
pub(super) const GLAZE_REFLECTION: f64 = 0.42;
/// Colour of the wires. Against white, a darker grey makes them cost more.
const WIRE: DVec3 = DVec3::new(0.50, 0.48, 0.42);

/// A material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Surface {
    /// A chess board with grained squares.
    Board,
    /// Stone with grain as fine as the pixels.
    Stone,
    /// A dark body that reflects light and surroundings.
    Glaze,
    /// White, nearly unshaded.
    White,
    /// Red marble with veins.
    Marble,
    /// Bands of two colours.
    Bands,
    /// The wires' metal.
    Wire,
    /// One colour.
    Plain(DVec3),
}

impl Surface {
    /// The colour at `p` where the outward normal is `normal`.
    pub(super) fn albedo(self, p: DVec3, normal: DVec3) -> DVec3 {
        match self {
            Self::Board => board(p, normal),
            Self::Stone => {
                let grain = STONE_CONTRAST * noise(p, STONE_CELL);
                DVec3::new(0.27, 0.36, 0.44) + DVec3::splat(grain)
            }
            Self::Glaze => DVec3::new(0.10, 0.03, 0.08),
            Self::White => DVec3::ONE,
            Self::Marble => marble(p),
            Self::Bands => {
                let band = wave(9.0 * p.z + 0.25 * noise(p, 0.12));
                let step = ((band - 0.5) * 6.0 + 0.5).clamp(0.0, 1.0);
                mix3(DVec3::new(0.02, 0.36, 0.34), DVec3::new(0.95, 0.80, 0.42), step)
            }
            Self::Wire => WIRE,
            Self::Plain(colour) => colour,
        }
    }

    /// Whether the colour changes within a pixel, away from any outline.
    pub(super) fn is_fine(self) -> bool {
        matches!(self, Self::Board | Self::Stone)
    }
}

/// Eight by eight squares on top, dark wood at the sides.
fn board(p: DVec3, normal: DVec3) -> DVec3 {
    const SQUARE: f64 = 0.21;
    let grain = 1.0 + BOARD_CONTRAST * (noise(p, BOARD_CELL) + 0.5 * noise(p, 0.5 * BOARD_CELL));
    let odd = ((p.x / SQUARE).floor() + (p.y / SQUARE).floor()) as i64 & 1 != 0;
    let colour = match (normal.z > 0.5, odd) {
        (true, true) => DVec3::new(0.80, 0.72, 0.56),
        (true, false) => DVec3::new(0.17, 0.10, 0.09),
        (false, _) => DVec3::new(0.26, 0.13, 0.08),
    };
    colour * grain
}

/// Swirls of red with light veins.
fn marble(p: DVec3) -> DVec3 {
    let swirl = noise(p, 0.22) + 0.5 * noise(p, 0.11) + 0.25 * noise(p, 0.055);
    let band = wave(2.0 * p.z + 1.5 * p.x + 1.1 * swirl);
    let vein = (1.0 - 9.0 * (band - 0.62).abs()).max(0.0);
    let red = mix3(DVec3::new(0.36, 0.02, 0.04), DVec3::new(0.90, 0.20, 0.08), band);
    mix3(red, DVec3::new(0.98, 0.78, 0.55), 0.8 * vein)
}

fn mix3(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a + (b - a) * t
}
