//! DeRF: a scene in parts, each with a small network of its own.

mod reference;

use fearless_simd::Simd;

use crate::encoding::{Affine, Fourier, Waves};
use crate::field::{Activation, Field, FieldKernels, NerfField, NerfNetwork, Samples};
use crate::network::{Dense, MAX_LAYERS, Mlp};
use crate::scratch::{Limits, Workspace};
use crate::{DType, Error, TensorView};

/// Most heads.
pub const MAX_HEADS: usize = 64;

/// Decomposed radiance fields (Rebain et al. 2021, "DeRF: Decomposed Radiance Fields").
///
/// Space is divided among heads, small vanilla NeRFs: a point belongs to the one whose site is
/// nearest (a Voronoi diagram), and no other is asked. A point costs what one head
/// costs, however many there are.
#[derive(Clone, Copy, Debug)]
pub struct DerfField<'a> {
    /// What all heads look like.
    pub shape: HeadShape,
    /// Where they are, unit coordinates: [`DType::F32`], `[heads, 3]`.
    pub sites: TensorView<'a>,
    /// `[heads, n_parameters]`: of each head the layers of the trunk, the density, the feature,
    /// the two layers of the colour network; of each layer its weights, `[n_in, n_out]`, then its
    /// biases.
    pub heads: TensorView<'a>,
    /// Factor on densities: carries the unit of length.
    pub density_scale: f32,
}

/// The shape of a head: a vanilla NeRF of positions from -1 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeadShape {
    /// Octaves of positions, up to 16.
    pub octaves: u32,
    /// Octaves of directions; `None`: colours do not depend on them, and there is no feature.
    pub direction_octaves: Option<u32>,
    /// Layers of the trunk.
    pub depth: u32,
    /// Their width, and that of the feature.
    pub width: u32,
    /// The layer of the trunk, counted from 0, that reads the position once more; 0: none.
    pub skip: u32,
    /// Width of the layer before colours.
    pub color_width: u32,
    /// How the last layer becomes a density.
    pub activation: Activation,
}

/// Encodes coordinates and their octaves.
const fn fourier<'a>(octaves: u32) -> Fourier<'a> {
    Fourier { waves: Waves::Octaves { n: octaves, pi: false }, include_input: true }
}

/// Values that encode a point.
const fn n_encoded(octaves: u32) -> u32 {
    3 + 6 * octaves
}

impl HeadShape {
    /// Inputs and outputs of the layers, in order.
    pub fn layers(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let Self { depth, width, skip, color_width, octaves, .. } = *self;
        let n_position = n_encoded(octaves);
        let trunk = (0..depth).map(move |i| match i {
            0 => [n_position, width],
            i if i == skip => [n_position + width, width],
            _ => [width; 2],
        });
        let n_direction = self.direction_octaves.map(n_encoded);
        let feature = n_direction.map(|_| [width; 2]);
        let color = [[width + n_direction.unwrap_or(0), color_width], [color_width, 3]];
        trunk.chain([[width, 1]]).chain(feature).chain(color)
    }

    /// Parameters of a head.
    #[must_use]
    pub fn n_parameters(&self) -> usize {
        self.layers().map(|[n_in, n_out]| ((n_in + 1) * n_out) as usize).sum()
    }

    fn validate(&self) -> Result<(), Error> {
        let octaves = [self.octaves, self.direction_octaves.unwrap_or(0)];
        if octaves.iter().any(|n| *n > 16) {
            return Err(Error::Range("octaves of a head"));
        }
        if !(1..=MAX_LAYERS as u32).contains(&self.depth) || self.skip >= self.depth {
            return Err(Error::Range("layers of a head"));
        }
        let width = 1..=1024;
        if !width.contains(&self.width) || !width.contains(&self.color_width) {
            return Err(Error::Range("width of a head's layers"));
        }
        Ok(())
    }
}

impl<'a> DerfField<'a> {
    /// Number of heads.
    #[must_use]
    pub const fn n_heads(&self) -> usize {
        self.sites.rows()
    }

    /// The field of a head, as if all points were its own.
    ///
    /// # Errors
    /// [`Error::Range`] for a head that is not there, or what is wrong with the shape.
    pub fn head(&self, number: usize) -> Result<NerfField<'a>, Error> {
        let Self { shape, heads, .. } = self;
        shape.validate()?;
        let row = shape.n_parameters() * heads.dtype().size();
        let missing = Error::Range("number of a head");
        let mut rest = heads.bytes().chunks_exact(row).nth(number).ok_or(missing)?;
        let mut tensor = |rows: u32, cols: u32| {
            let bytes = (rows * cols) as usize * heads.dtype().size();
            let (own, after) = rest.split_at_checked(bytes).ok_or(missing)?;
            rest = after;
            TensorView::new(own, heads.dtype(), [rows, cols], heads.scale_log2(), heads.layout())
        };
        let mut layers = shape.layers();
        let mut next = || {
            let [n_in, n_out] = layers.next().ok_or(missing)?;
            Ok::<_, Error>(Dense { weight: tensor(n_in, n_out)?, bias: Some(tensor(1, n_out)?) })
        };
        let mut trunk = [Dense::EMPTY; MAX_LAYERS];
        let trunk = &mut trunk[..shape.depth as usize];
        for layer in &mut *trunk {
            *layer = next()?;
        }
        let density = next()?;
        let feature = shape.direction_octaves.map(|_| next()).transpose()?;
        let color = Mlp::new(&[next()?, next()?])?;
        let skips = if shape.skip == 0 { 0 } else { 1 << shape.skip };
        Ok(NerfField {
            positions: fourier(shape.octaves),
            directions: shape.direction_octaves.map(fourier),
            map: Affine::CENTRED,
            activation: shape.activation,
            density_scale: self.density_scale,
            fine: NerfNetwork::new(trunk, [skips, 0], density, feature, color)?,
            coarse: None,
        })
    }

    /// Writes the number of each point's head, the first of those whose sites are nearest.
    pub fn nearest(&self, points: [&[f32]; 3], to: &mut [f32]) {
        to.fill(0.0);
        let [x, y, z] = points;
        for (s, to) in to.iter_mut().enumerate() {
            let mut least = f32::INFINITY;
            for head in 0..self.n_heads() {
                let site = [0, 1, 2].map(|axis| self.sites.get(3 * head + axis));
                let distance = square_distance([x[s], y[s], z[s]], site);
                if distance < least {
                    (least, *to) = (distance, head as f32);
                }
            }
        }
    }
}

/// In this order, so that every renderer finds the same head.
fn square_distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
}

/// Rows of samples kept beside what a head takes: the points; the number of each one's head; a
/// head's own points, directions and their numbers; what it says of them.
const OWN_ROWS: usize = 3 + 1 + 3 + 3 + 1 + 4;

impl Field for DerfField<'_> {
    fn kind(&self) -> &'static str {
        "derf"
    }

    fn channels(&self) -> usize {
        3
    }

    fn dtype(&self) -> DType {
        self.heads.dtype()
    }

    fn limits(&self) -> Limits {
        let limits = self.head(0).map(|head| head.limits());
        let limits =
            limits.unwrap_or(Limits { width: 1, rows: [1; 2], channels: 3, ray_samples: 0 });
        let [a, b] = limits.rows;
        Limits { rows: [a + OWN_ROWS, b], ..limits }
    }

    fn finest_detail(&self) -> f32 {
        self.head(0).map_or(1.0, |head| head.finest_detail())
    }

    fn validate(&self) -> Result<(), Error> {
        let n = self.n_heads();
        if !(1..=MAX_HEADS).contains(&n) {
            return Err(Error::Range("number of heads, 1 to 64"));
        }
        if self.sites.dtype() != DType::F32 || self.sites.cols() != 3 {
            return Err(Error::Shape("sites of heads"));
        }
        self.shape.validate()?;
        if self.heads.rows() != n || self.heads.cols() != self.shape.n_parameters() {
            return Err(Error::Shape("heads and their shape"));
        }
        self.head(0)?.validate()
    }
}

impl FieldKernels for DerfField<'_> {
    /// Keeps the points: each head encodes its own.
    fn encode<S: Simd>(&self, _: S, points: [&[f32]; 3], work: &mut Workspace<'_>) {
        let OwnRows { points: rows, nearest, .. } = OwnRows::cut(work.a, work.stride);
        for (row, points) in rows.chunks_exact_mut(work.stride).zip(points) {
            row[..points.len()].copy_from_slice(points);
        }
        self.nearest(points, &mut nearest[..points[0].len()]);
    }

    fn decode<S: Simd>(&self, simd: S, samples: Samples<'_>, work: &mut Workspace<'_>) {
        self.heads(simd, samples.len(), Some(samples.directions), work);
    }

    fn decode_density<S: Simd>(&self, simd: S, n: usize, work: &mut Workspace<'_>) {
        self.heads(simd, n, None, work);
    }
}

/// The rows beside what a head takes.
struct OwnRows<'w> {
    /// What heads take.
    heads: &'w mut [f32],
    points: &'w mut [f32],
    nearest: &'w mut [f32],
    /// Points and directions of a head.
    gathered: &'w mut [f32],
    numbers: &'w mut [f32],
    results: &'w mut [f32],
}

impl<'w> OwnRows<'w> {
    fn cut(a: &'w mut [f32], stride: usize) -> Self {
        let (heads, own) = a.split_at_mut(a.len() - OWN_ROWS * stride);
        let (points, own) = own.split_at_mut(3 * stride);
        let (nearest, own) = own.split_at_mut(stride);
        let (gathered, own) = own.split_at_mut(6 * stride);
        let (numbers, results) = own.split_at_mut(stride);
        Self { heads, points, nearest, gathered, numbers, results }
    }
}

impl DerfField<'_> {
    /// Each head over its own of `n` points; densities alone where there are no directions.
    fn heads<S: Simd>(
        &self,
        simd: S,
        n: usize,
        directions: Option<[&[f32]; 3]>,
        work: &mut Workspace<'_>,
    ) {
        let Workspace { a, b, output, panel, stride, rounded } = work;
        let stride = *stride;
        let OwnRows { heads, points, nearest, gathered, numbers, results } =
            OwnRows::cut(a, stride);
        let colors = if directions.is_some() { 3 } else { 0 };
        for number in 0..self.n_heads() {
            let mut len = 0;
            for s in (0..n).filter(|s| nearest[*s] == number as f32) {
                for axis in 0..3 {
                    gathered[axis * stride + len] = points[axis * stride + s];
                    if let Some(directions) = directions {
                        gathered[(3 + axis) * stride + len] = directions[axis][s];
                    }
                }
                numbers[len] = s as f32;
                len += 1;
            }
            if len == 0 {
                continue;
            }
            let padded = len.next_multiple_of(crate::lanes::LANES);
            let mut rows = gathered.chunks_exact_mut(stride);
            let mut row = || {
                let row = rows.next().unwrap_or_default();
                row[len..padded].fill(0.0);
                &row[..padded]
            };
            let (points, directions) = ([row(), row(), row()], [row(), row(), row()]);
            // `validate` has refused what has no such head.
            let Ok(head) = self.head(number) else { continue };
            let mut work =
                Workspace { a: heads, b, output: results, panel, stride, rounded: *rounded };
            head.encode(simd, points, &mut work);
            match colors {
                0 => head.decode_density(simd, padded, &mut work),
                _ => head.decode(simd, Samples { points, directions }, &mut work),
            }
            for (i, s) in numbers[..len].iter().enumerate() {
                for row in 0..=colors {
                    output[row * stride + *s as usize] = results[row * stride + i];
                }
            }
        }
    }
}
