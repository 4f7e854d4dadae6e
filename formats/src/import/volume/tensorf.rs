//! TensoRF (Chen et al. 2022) as its program saves it: `TensorBase.save`.

use std::format;
use std::string::ToString;
use std::vec::Vec;

use pocketnerf_core::Error;
use pocketnerf_core::network::Dense;

use super::factors::{Factors, factors};
use crate::import::layer::{Layer, Stored};
use crate::import::settings::{Settings, setting};
use crate::import::tensors::{Tensors, values};
use crate::import::{Checkpoint, FieldError, Tensor};

/// Entries along an axis.
const SIZES: core::ops::RangeInclusive<usize> = 2..=2048;
/// Most products, and most values of a colour's features.
pub(super) const MOST: usize = 512;
/// Most octaves that encode a value.
const OCTAVES: u32 = 16;
/// Where rays of normalised device coordinates begin and end.
const NDC: [f32; 2] = [0.0, 1.0];
/// Steps along the box's diagonal at most.
const STEPS: f32 = 1e5;

/// Planes and lines, or lines alone, and how their products become densities and colours.
#[derive(Clone, Debug)]
pub struct TensoRf {
    /// The box, smallest and largest corner; entries lie from face to face.
    pub bounds: [[f32; 3]; 2],
    /// Entries along x, y and z.
    pub sizes: [usize; 3],
    /// Their sum, moved and bent, is the density.
    pub density: Factors,
    /// Colours are made of these products.
    pub appearance: Factors,
    /// Densities are softplus of sums, or what of them is above 0.
    pub softplus: bool,
    /// Added to the density's sum before softplus.
    pub density_shift: f32,
    /// Densities are per so many units of length.
    pub distance_scale: f32,
    /// Between samples, along a ray.
    pub step: f32,
    /// Rays begin at a distance between these.
    pub near_far: [f32; 2],
    /// Samples that weigh less have no colour.
    pub weight_threshold: f32,
    /// Where there is something, if the program has noted it.
    pub alpha_mask: Option<AlphaMask>,
    /// How colours are made.
    pub shading: Shading,
    basis: Stored,
    network: Vec<Stored>,
}

/// How features become a colour. Octave k encodes v as sin(2^k v) and cos(2^k v).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// A network of features, direction, and both encoded: sines of all, then cosines.
    Network {
        /// Octaves of features.
        features: u32,
        /// Octaves of directions.
        directions: u32,
    },
    /// Nine spherical harmonics a colour.
    Harmonics,
    /// Features are the colour.
    Colors,
}

/// Where a field holds something: a grid of yes and no, interpolated; what is above 0 is shown.
#[derive(Clone, Debug)]
pub struct AlphaMask {
    /// Smallest and largest corner, on which the outermost entries lie.
    pub bounds: [[f32; 3]; 2],
    /// Entries along x, y and z.
    pub sizes: [usize; 3],
    /// A bit an entry, the highest of a byte first; x runs fastest, z slowest.
    bits: Vec<u8>,
}

impl AlphaMask {
    /// Whether the entry (x, y, z) holds something.
    #[must_use]
    pub fn holds(&self, [x, y, z]: [usize; 3]) -> bool {
        let entry = x + self.sizes[0] * (y + self.sizes[1] * z);
        self.bits[entry / 8] >> (7 - entry % 8) & 1 == 1
    }
}

impl TensoRf {
    /// Whether a checkpoint has this program's tensors.
    #[must_use]
    pub fn recognises(checkpoint: &Checkpoint<'_>) -> bool {
        checkpoint.text("kwargs.shadingMode").is_some()
    }

    /// Takes the field from a checkpoint.
    ///
    /// # Errors
    /// See [`FieldError`].
    pub fn read(checkpoint: &Checkpoint<'_>) -> Result<Self, FieldError> {
        let settings = Settings(checkpoint);
        if checkpoint.tensor("state_dict.line_coef").is_some() {
            let expected = "density_line and app_line, of TensorVMSplit or TensorCP";
            return Err(setting("state_dict.line_coef", "a TensorVM", expected));
        }
        let bounds = corners("kwargs.aabb", settings.tensor("kwargs.aabb")?)?;
        let sizes = sizes(settings, "kwargs.gridSize", 0, [0, 1, 2])?;
        let Some(mut tensors) = Tensors::of(checkpoint, "state_dict.") else {
            return Err(FieldError::unknown(checkpoint));
        };
        let density = factors(&mut tensors, "density", sizes)?;
        let appearance = factors(&mut tensors, "app", sizes)?;
        let basis = tensors.unbiased("basis_mat")?;
        if basis.n_in != appearance.n_products() || basis.n_out > MOST {
            let found = Vec::from([basis.n_out, basis.n_in]);
            let expected = format!("[at most {MOST}, {}]", appearance.n_products());
            return Err(FieldError::Shape { name: "basis_mat.weight".into(), found, expected });
        }
        let octaves = |name| settings.count(name, 0, 0..=OCTAVES);
        let modes = ["MLP_Fea", "MLP", "SH", "RGB"];
        let shading = match settings.choice("kwargs.shadingMode", "", &modes)? {
            "SH" => Shading::Harmonics,
            "RGB" => Shading::Colors,
            mode => Shading::Network {
                features: if mode == "MLP" { 0 } else { octaves("kwargs.fea_pe")? },
                directions: octaves("kwargs.view_pe")?,
            },
        };
        let network = network(&mut tensors, shading, &basis)?;
        tensors.finish()?;

        let number = |name: &str, range: [f32; 2]| -> Result<f32, FieldError> {
            let found = settings.number(name)? as f32;
            let [low, high] = range;
            match (low..=high).contains(&found) {
                true => Ok(found),
                false => Err(setting(name, &found.to_string(), &format!("{low} to {high}"))),
            }
        };
        let [low, high] = bounds;
        let sides = [0, 1, 2].map(|a| high[a] - low[a]);
        let unit = (0..3).map(|a| sides[a] / (sizes[a] - 1) as f32).sum::<f32>() / 3.0;
        let step = unit * number("kwargs.step_ratio", [1e-3, 1e3])?;
        let diagonal = sides.iter().map(|side| side * side).sum::<f32>().sqrt();
        if diagonal > STEPS * step {
            return Err(setting("kwargs.step_ratio", "steps of next to nothing", "100000 at most"));
        }
        let acts = ["softplus", "relu"];
        let near_far = settings.vector("kwargs.near_far").unwrap_or([0.0, f32::MAX]);
        if near_far == NDC {
            let expected = "distances: scenes in normalised device coordinates are not rendered";
            return Err(setting("kwargs.near_far", &format!("{near_far:?}"), expected));
        }
        Ok(Self {
            bounds,
            sizes,
            density,
            appearance,
            softplus: settings.choice("kwargs.fea2denseAct", "softplus", &acts)? == "softplus",
            density_shift: number("kwargs.density_shift", [-100.0, 100.0])?,
            distance_scale: number("kwargs.distance_scale", [1e-6, 1e6])?,
            step,
            near_far: [near_far[0].max(0.0), near_far[1].max(near_far[0].max(0.0))],
            weight_threshold: number("kwargs.rayMarch_weight_thres", [0.0, 0.1])?,
            alpha_mask: alpha_mask(settings)?,
            shading,
            basis: basis.stored(),
            network: network.iter().map(Layer::stored).collect(),
        })
    }

    /// From products to features, without bias.
    ///
    /// # Errors
    /// What core refuses.
    pub fn basis(&self) -> Result<Dense<'_>, Error> {
        self.basis.view()
    }

    /// The layers of the network of colours, with ReLU between them and a sigmoid behind; none
    /// where there is no network.
    ///
    /// # Errors
    /// What core refuses.
    pub fn network(&self) -> Result<Vec<Dense<'_>>, Error> {
        self.network.iter().map(Stored::view).collect()
    }

    /// Samples of a ray.
    #[must_use]
    pub fn n_steps(&self) -> usize {
        let [low, high] = self.bounds;
        let squares = (0..3).map(|a| (high[a] - low[a]).powi(2)).sum::<f32>();
        (squares.sqrt() / self.step) as usize + 1
    }
}

/// The layers of the network behind the features.
fn network(
    tensors: &mut Tensors<'_, '_>,
    shading: Shading,
    basis: &Layer,
) -> Result<Vec<Layer>, FieldError> {
    let n_features = basis.n_out;
    let (n_in, n_layers) = match shading {
        Shading::Network { features, directions } => {
            let encoded = |n: usize, octaves: u32| n + 2 * n * octaves as usize;
            (encoded(n_features, features) + encoded(3, directions), 3)
        }
        Shading::Harmonics => (27, 0),
        Shading::Colors => (3, 0),
    };
    if n_layers == 0 && n_features != n_in {
        let found = Vec::from([n_features, basis.n_in]);
        let expected = format!("{n_in} rows");
        return Err(FieldError::Shape { name: "basis_mat.weight".into(), found, expected });
    }
    let (mut width, mut layers) = (n_in, Vec::new());
    for i in 0..n_layers {
        // Between them are those of ReLU.
        let name = format!("renderModule.mlp.{}", 2 * i);
        let layer = tensors.layer(&name)?;
        let wrong = layer.n_in != width || layer.n_out > MOST;
        if wrong || (i + 1 == n_layers && layer.n_out != 3) {
            return Err(FieldError::Shape {
                name: format!("{name}.weight"),
                found: Vec::from([layer.n_out, layer.n_in]),
                expected: format!("{width} columns, the last layer 3 rows"),
            });
        }
        width = layer.n_out;
        layers.push(layer);
    }
    Ok(layers)
}

/// Three sizes that are listed under a name from number `first` on, in this order of the axes.
fn sizes(
    settings: Settings<'_, '_>,
    name: &str,
    first: usize,
    axes: [usize; 3],
) -> Result<[usize; 3], FieldError> {
    let mut sizes = [0; 3];
    for (i, axis) in axes.into_iter().enumerate() {
        let name = format!("{name}.{}", first + i);
        let (least, most) = (*SIZES.start() as u32, *SIZES.end() as u32);
        sizes[axis] = settings.count(&name, 0, least..=most)? as usize;
    }
    Ok(sizes)
}

/// The corners of a box.
fn corners(name: &str, tensor: &Tensor<'_>) -> Result<[[f32; 3]; 2], FieldError> {
    let found = values(name, tensor)?;
    match found[..] {
        [a, b, c, x, y, z] if a < x && b < y && c < z => Ok([[a, b, c], [x, y, z]]),
        _ => Err(setting(name, &format!("{:?}", &found[..found.len().min(6)]), "a box's corners")),
    }
}

fn alpha_mask(settings: Settings<'_, '_>) -> Result<Option<AlphaMask>, FieldError> {
    const MASK: &str = "alphaMask.mask";
    let Some(mask) = settings.0.tensor(MASK) else { return Ok(None) };
    let bounds = corners("alphaMask.aabb", settings.tensor("alphaMask.aabb")?)?;
    // One picture of one channel, then z, y and x.
    let first = if settings.0.number("alphaMask.shape.4").is_some() { 2 } else { 0 };
    for i in 0..first {
        settings.count(&format!("alphaMask.shape.{i}"), 0, 1..=1)?;
    }
    let sizes = sizes(settings, "alphaMask.shape", first, [2, 1, 0])?;
    let bits = mask.to_bytes().map_err(|error| FieldError::Tensor(MASK.to_string(), error))?;
    let len = sizes.iter().product::<usize>();
    if bits.len() != len.div_ceil(8) {
        let expected = format!("{} bytes", len.div_ceil(8));
        return Err(setting(MASK, &format!("{} bytes", bits.len()), &expected));
    }
    Ok(Some(AlphaMask { bounds, sizes, bits }))
}
