//! The shape of a decomposed field.

use pocketnerf_core::field::{DerfField, HeadShape, MAX_HEADS};
use pocketnerf_core::{DType, Error, Layout as Order, Occupancy, TensorView};

use super::sites;
use crate::field::layout::Layout;
use crate::field::{FourierConfig, NerfConfig, Unusable, WavesConfig};

/// Small networks for parts of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct DerfConfig {
    /// Parts of the scene, 1 to 64.
    pub n_heads: usize,
    /// What a head looks like: without a coarse network and without random frequencies.
    pub head: NerfConfig,
    /// Where heads are, unit coordinates; empty: found when training begins.
    pub(super) sites: Vec<[f32; 3]>,
}

impl Default for DerfConfig {
    fn default() -> Self {
        let (depth, width, skip, color_width) = (4, 64, 3, 32);
        let head = NerfConfig { depth, width, skip, color_width, ..NerfConfig::in_cells() };
        Self { n_heads: 8, head, sites: Vec::new() }
    }
}

/// Octaves of an encoding that a head can have.
fn octaves(encoding: &FourierConfig) -> Result<u32, Error> {
    match encoding.waves {
        WavesConfig::Octaves { n, pi: false } if encoding.include_input => Ok(n),
        _ => Err(Error::Range("encoding of a head: octaves and the input itself")),
    }
}

impl DerfConfig {
    /// The shape of a model's field, with what a checkpoint adds to it.
    pub(in crate::field) fn restored(
        field: &DerfField<'_>,
        section: Option<&[u8]>,
    ) -> Result<Self, Unusable> {
        let section = section.ok_or(Unusable::NoSection)?;
        let &[muon @ (0 | 1)] = section else { return Err(Unusable::Section) };
        let waves = |n| WavesConfig::Octaves { n, pi: false };
        let encoding = |n| FourierConfig { waves: waves(n), include_input: true };
        let shape = field.shape;
        let head = NerfConfig {
            positions: encoding(shape.octaves),
            directions: shape.direction_octaves.map(encoding),
            depth: shape.depth as usize,
            width: shape.width as usize,
            skip: shape.skip as usize,
            color_width: shape.color_width as usize,
            coarse: false,
            activation: shape.activation,
            muon: muon == 1,
            hierarchical: None,
        };
        let site = |n: usize| [0, 1, 2].map(|axis| field.sites.get(3 * n + axis));
        let sites = (0..field.n_heads()).map(site).collect();
        Ok(Self { n_heads: field.n_heads(), head, sites })
    }

    /// What [`restored`](Self::restored) reads.
    pub(super) fn section(&self) -> Vec<u8> {
        vec![self.head.muon.into()]
    }

    /// A head as core has it.
    pub(super) fn shape(&self) -> Result<HeadShape, Error> {
        let NerfConfig { positions, directions, depth, width, skip, color_width, .. } = &self.head;
        Ok(HeadShape {
            octaves: octaves(positions)?,
            direction_octaves: directions.as_ref().map(octaves).transpose()?,
            depth: *depth as u32,
            width: *width as u32,
            skip: *skip as u32,
            color_width: *color_width as u32,
            activation: self.head.activation,
        })
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        if !(1..=MAX_HEADS).contains(&self.n_heads) {
            return Err(Error::Range("number of heads, 1 to 64"));
        }
        self.shape().map(|_| ())
    }

    /// The same with sites among these cells.
    pub(super) fn within(&self, cells: &Occupancy<'_>) -> Self {
        Self { sites: sites::learnt(cells, self.n_heads), ..self.clone() }
    }

    /// Sites, or the middle where there are none yet.
    pub(super) fn sites(&self) -> Vec<[f32; 3]> {
        if self.sites.is_empty() { vec![[0.5; 3]; self.n_heads] } else { self.sites.clone() }
    }

    /// Where each tensor lies: head after head.
    #[must_use]
    pub fn layout(&self) -> Layout {
        let (head, mut layout) = (self.head.layout(), Layout::default());
        for range in [head.ranges()].repeat(self.n_heads).concat() {
            layout.push(range.part, range.shape);
        }
        layout
    }

    /// The field of all heads' parameters.
    pub(super) fn view<'a>(
        &self,
        sites: &'a [[f32; 3]],
        density_scale: f32,
        parameters: &'a [f32],
    ) -> Result<DerfField<'a>, Error> {
        let tensor = |values: &'a [f32]| {
            let shape = [sites.len() as u32, (values.len() / sites.len()) as u32];
            let bytes = bytemuck::must_cast_slice(values);
            TensorView::new(bytes, DType::F32, shape, 0, Order::RowMajor)
        };
        let (sites, heads) = (tensor(sites.as_flattened())?, tensor(parameters)?);
        Ok(DerfField { shape: self.shape()?, sites, heads, density_scale })
    }
}
