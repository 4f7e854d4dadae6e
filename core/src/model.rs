//! A scene as the renderer sees it: borrowed parts, checked to fit together.

use crate::field::AnyField;
use crate::march::{Hierarchical, Reach};
use crate::render::{Detail, SamplingMode};
use crate::scratch::Limits;
use crate::space::UnitMap;
use crate::{Error, Occupancy, Sampling, Space};

/// What the colours of a model, and of its background, mean.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorSpace {
    /// What the photographs held: sRGB-encoded values, composited as they are.
    #[default]
    Srgb,
    /// Linear light, composited as such; [`pixel`](crate::pixel) encodes it as sRGB bytes.
    Linear,
}

/// How a picture of the model is finished.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Colour behind the scene, in the model's colour space.
    pub background: [f32; 3],
    /// The space of the model's colours.
    pub color_space: ColorSpace,
    /// How much neighbouring pixels may differ where one between them is
    /// interpolated, in usual quality: what the scene bears, found when its model was
    /// made. From 0 to below 0.25.
    pub tolerance: f32,
}

impl Default for Display {
    /// sRGB on black.
    fn default() -> Self {
        Self { background: [0.0; 3], color_space: ColorSpace::Srgb, tolerance: Self::TOLERANCE }
    }
}

impl Display {
    /// The tolerance of a model of which nothing is known.
    pub const TOLERANCE: f32 = 0.03;
}

/// A radiance field with all that is needed to render it. Borrows the bytes it
/// was opened from and owns no memory.
#[derive(Clone, Copy, Debug)]
pub struct Model<'a> {
    /// Density and colour.
    pub field: AnyField<'a>,
    /// Where the field lives.
    pub space: Space,
    /// Cells that may hold something; sigma is 0 outside them. `None`: everywhere.
    pub occupancy: Option<Occupancy<'a>>,
    /// Steps along a ray.
    pub sampling: Sampling,
    /// Hierarchical sampling, where the model was made for it.
    pub hierarchical: Option<Hierarchical>,
    /// Background and colour space.
    pub display: Display,
}

impl<'a> Model<'a> {
    /// Bytes that [`with_table`](Self::with_table) needs.
    #[must_use]
    pub const fn table_len(&self) -> usize {
        match &self.occupancy {
            Some(occupancy) => occupancy.table_len(),
            None => 0,
        }
    }

    /// The same model with a [table](Occupancy::with_table) of what lies around the
    /// cells of its occupancy, in the caller's `memory`: the same pictures in less
    /// time.
    ///
    /// # Errors
    /// [`Error::OutputLength`] where `memory` is shorter than
    /// [`table_len`](Self::table_len).
    pub fn with_table<'b>(&self, memory: &'b mut [u8]) -> Result<Model<'b>, Error>
    where
        'a: 'b,
    {
        let model: Model<'b> = *self;
        let Some(occupancy) = self.occupancy else { return Ok(model) };
        occupancy.write_table(memory)?;
        let occupancy = occupancy.with_table(&memory[..occupancy.table_len()])?;
        Ok(Model { occupancy: Some(occupancy), ..model })
    }

    /// Checks that the parts fit together and every number can be used.
    ///
    /// # Errors
    /// Whatever the parts report.
    pub fn validate(&self) -> Result<(), Error> {
        self.space.validate()?;
        self.sampling.validate()?;
        if let Some(hierarchical) = &self.hierarchical {
            hierarchical.validate()?;
        }
        if !self.display.background.iter().all(|v| v.is_finite()) {
            return Err(Error::Range("background colour"));
        }
        if !(0.0..0.25).contains(&self.display.tolerance) {
            return Err(Error::Range("tolerance"));
        }
        self.field.validate()
    }

    /// The unit coordinates of local point `p` where the model may hold something: inside
    /// the box, its faces included, and in an occupied cell. `map` is the space's.
    #[inline(always)]
    pub(crate) fn place(&self, map: &UnitMap, p: [f32; 3]) -> Option<[f32; 3]> {
        let u = map.apply(p);
        let occupied = || self.occupancy.is_none_or(|occupancy| occupancy.at(u));
        (self.space.contains(p) && occupied()).then_some(u)
    }

    /// What may be left out of pictures, from 0, the fastest, to 1, the finest; the
    /// usual is 0.5. Numbers outside that range count as the nearer end, NaN as 1.
    #[must_use]
    pub fn detail(&self, quality: f32) -> Detail {
        Detail::new(quality, self.display.tolerance)
    }

    /// Hierarchical sampling: the model's own numbers, or, where it was made for occupancy
    /// sampling, the NeRF paper's within the space and its occupied cells.
    #[must_use]
    pub fn hierarchical_sampling(&self) -> SamplingMode {
        let clipped = Hierarchical { reach: Reach::Clipped, ..Hierarchical::PAPER };
        SamplingMode::Hierarchical(self.hierarchical.unwrap_or(clipped))
    }

    /// Checks that scratch for `limits` suffices.
    ///
    /// # Errors
    /// [`Error::Limits`].
    pub fn fits(&self, limits: &Limits) -> Result<(), Error> {
        let needed = self.field.limits();
        if needed.width > limits.width {
            return Err(Error::Limits("widest layer"));
        }
        if needed.rows.iter().zip(&limits.rows).any(|(needed, given)| needed > given) {
            return Err(Error::Limits("rows of samples"));
        }
        if needed.channels > limits.channels {
            return Err(Error::Limits("channels of a ray"));
        }
        Ok(())
    }
}
