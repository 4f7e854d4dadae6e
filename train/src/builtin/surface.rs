//! What the bodies of the built-in scenes are made of.
//!
//! Colours are in image (sRGB-like) values from 0 to 1. The constants named
//! here set how hard the still life is; changing one changes the frozen hash.

use super::noise::{noise, wave};
use glam::DVec3;

/// Side of a grain of the stone, scene units: 1.7 pixels at the cameras' distance.
const STONE_CELL: f64 = 0.0122;
/// Amplitude of the stone's grain: beyond what a small table resolves, so it
/// bounds the error of every model from below.
const STONE_CONTRAST: f64 = 0.28;
/// Side of the grain of the board and the marble, scene units: 2.2 pixels at
/// the cameras' distance.
const BOARD_CELL: f64 = 0.016;
/// Amplitude of the board's grain (the marble has less): what a large
/// table resolves and a small one does not.
const BOARD_CONTRAST: f64 = 0.38;
/// Linear strength of the surroundings in the glaze and of the lamp's highlight
/// on it: what a field without view dependence cannot show.
pub(super) const GLAZE_REFLECTION: f64 = 0.60;
/// See [`GLAZE_REFLECTION`].
pub(super) const GLAZE_HIGHLIGHT: f64 = 0.36;
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
    /// One colour, on what is too thin to cast a visible shadow.
    Thin(DVec3),
    /// One colour, on what is thin from some sides.
    Leaf(DVec3),
    /// A smooth body that mirrors what is around it, in part: `reflectance` where it is
    /// looked at straight.
    Mirror { colour: DVec3, reflectance: f64 },
    /// Squares of two colours in the axes of the scene; on upright sides too.
    Checks { side: f64, colours: [DVec3; 2] },
    /// Stripes across x + y + z, `period` from one to the next, with soft edges.
    Stripes { period: f64, colours: [DVec3; 2] },
    /// Clouds of two colours, some as wide as `cell` and weaker ones a quarter as wide.
    Mottled { cell: f64, colours: [DVec3; 2] },
    /// Grass around a round place of gravel on the z axis. The farther away, the coarser, and
    /// plain in the end: what a pixel cannot show is not there.
    Meadow,
}

impl Surface {
    /// The colour at `p` where the outward normal is `normal`.
    pub(super) fn albedo(self, p: DVec3, normal: DVec3) -> DVec3 {
        match self {
            Self::Board => board(p, normal),
            Self::Stone => {
                let grain = STONE_CONTRAST * noise(p, STONE_CELL);
                DVec3::new(0.29, 0.38, 0.47) + DVec3::splat(grain)
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
            Self::Plain(colour)
            | Self::Thin(colour)
            | Self::Leaf(colour)
            | Self::Mirror { colour, .. } => colour,
            Self::Checks { side, colours } => colours[usize::from(is_odd(p / side, normal))],
            Self::Stripes { period, colours: [a, b] } => {
                let wave = wave((p.x + p.y + p.z) / period);
                mix3(a, b, ((wave - 0.5) * 4.0 + 0.5).clamp(0.0, 1.0))
            }
            Self::Mottled { cell, colours: [a, b] } => {
                let cloud = 0.5 + 0.4 * noise(p, cell) + 0.2 * noise(p, 0.25 * cell);
                mix3(a, b, cloud.clamp(0.0, 1.0))
            }
            Self::Meadow => meadow(p),
        }
    }

    /// Whether four samples of a pixel could all miss what is made of it.
    pub(super) fn is_thin(self) -> bool {
        matches!(self, Self::Wire | Self::Thin(_) | Self::Leaf(_))
    }

    /// Whether what is made of it hides the lamp from something visibly.
    pub(super) fn casts_shadow(self) -> bool {
        !matches!(self, Self::Wire | Self::Thin(_))
    }

    /// Whether the colour changes within a pixel, away from any outline.
    pub(super) fn is_fine(self) -> bool {
        matches!(self, Self::Board | Self::Stone | Self::Marble)
    }
}

/// Which of two squares of side 1 holds `p`. The axis along which the surface mostly faces
/// does not count: a flat side may lie on a limit between squares.
fn is_odd(p: DVec3, normal: DVec3) -> bool {
    let face = normal.abs();
    let across = face.cmplt(DVec3::splat(face.max_element()));
    let index = DVec3::select(across, p.floor(), DVec3::ZERO);
    (index.x + index.y + index.z) as i64 & 1 != 0
}

/// Eight by eight squares on top, dark wood at the sides.
fn board(p: DVec3, normal: DVec3) -> DVec3 {
    const SQUARE: f64 = 0.21;
    let grain = BOARD_CONTRAST * noise(p, BOARD_CELL);
    let odd = ((p.x / SQUARE).floor() + (p.y / SQUARE).floor()) as i64 & 1 != 0;
    let colour = match (normal.z > 0.5, odd) {
        (true, true) => DVec3::new(0.74, 0.66, 0.51),
        (true, false) => DVec3::new(0.24, 0.15, 0.12),
        (false, _) => DVec3::new(0.26, 0.13, 0.08),
    };
    (colour + DVec3::splat(grain)).max(DVec3::ZERO)
}

/// Swirls of red with light veins.
fn marble(p: DVec3) -> DVec3 {
    let swirl = noise(p, 0.22) + 0.5 * noise(p, 0.11) + 0.25 * noise(p, 0.055);
    let band = wave(2.0 * p.z + 1.5 * p.x + 1.1 * swirl);
    let vein = (1.0 - 9.0 * (band - 0.62).abs()).max(0.0);
    let red = mix3(DVec3::new(0.36, 0.02, 0.04), DVec3::new(0.90, 0.20, 0.08), band);
    let grain = 0.4 * BOARD_CONTRAST * noise(p, BOARD_CELL);
    (mix3(red, DVec3::new(0.98, 0.78, 0.55), 0.8 * vein) + DVec3::splat(grain)).max(DVec3::ZERO)
}

/// Grass and gravel at `p`.
fn meadow(p: DVec3) -> DVec3 {
    /// Sides of grains, scene units.
    const CELLS: [f64; 5] = [0.07, 0.28, 1.1, 4.5, 18.0];
    /// How far away from the axis grains of side 1 are gone, squared. Cameras stand near the
    /// axis, a unit above the ground: what a pixel covers of it grows with the square of the
    /// distance.
    const REACH: f64 = 225.0;
    let from_axis = p.truncate().length_squared();
    let grain: f64 = CELLS
        .into_iter()
        .map(|cell| (cell, (1.0 - from_axis / (REACH * cell)).max(0.0)))
        .filter(|(_, left)| *left > 0.0)
        .map(|(cell, left)| left * left * noise(p, cell))
        .sum();
    let shade = (0.5 + 0.22 * grain).clamp(0.0, 1.0);
    let grass = mix3(DVec3::new(0.24, 0.38, 0.14), DVec3::new(0.56, 0.62, 0.30), shade);
    if from_axis > 9.0 {
        return grass;
    }
    let gravel = mix3(DVec3::new(0.44, 0.38, 0.32), DVec3::new(0.80, 0.74, 0.64), shade);
    let edge = (3.0 * (1.9 - from_axis.sqrt() + 0.4 * noise(p, 0.5))).clamp(0.0, 1.0);
    mix3(grass, gravel, edge)
}

pub(super) fn mix3(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a + (b - a) * t
}
