//! How densely rays are sampled: what a model was made for.

/// The sampling that a model was made for. All distances are along the
/// [local](crate::Space::local) ray: Euclidean and in scene units where the space is a
/// box, which no other is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Distance between samples. Sample k of a ray lies at
    /// `(k + 0.5) * step + near`, wherever the ray enters the scene.
    pub step: f32,
    /// Nothing is seen nearer than this.
    pub near: f32,
    /// Nothing is seen farther than this.
    pub far: f32,
    /// A ray ends where its transmittance falls below this, and counts as opaque.
    pub min_transmittance: f32,
}

/// No ray takes more steps than this, whatever a file says.
pub const MAX_STEPS: u32 = 1 << 20;

impl Sampling {
    /// Checks that the numbers can be marched with.
    ///
    /// # Errors
    /// [`crate::Error::Range`].
    pub fn validate(&self) -> Result<(), crate::Error> {
        let finite =
            [self.step, self.near, self.far, self.min_transmittance].iter().all(|v| v.is_finite());
        let steps = (self.far - self.near) / self.step;
        if !finite || self.step <= 0.0 || self.near < 0.0 || self.far <= self.near {
            return Err(crate::Error::Range("sampling step, near and far"));
        }
        if steps >= MAX_STEPS as f32 {
            return Err(crate::Error::Range("sampling step: more than 2^20 steps a ray"));
        }
        if !(0.0..1.0).contains(&self.min_transmittance) {
            return Err(crate::Error::Range("sampling min_transmittance"));
        }
        Ok(())
    }
}

/// Most samples of a ray in either round of hierarchical sampling.
pub const MAX_SAMPLES: u32 = 1024;

/// How many samples hierarchical sampling takes (Mildenhall et al. 2020, section 5.2):
/// evenly spaced ones, then more of them where those have weight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hierarchical {
    /// Evenly spaced samples, at least 4.
    pub n_coarse: u32,
    /// Samples that are drawn from the weights of the first; 0: none.
    pub n_fine: u32,
    /// Which part of a ray has samples.
    pub reach: Reach,
}

/// Which part of a ray has the samples of hierarchical sampling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// From where it enters the space to where it leaves it, and occupied cells alone; the
    /// last sample stands for nothing.
    Clipped,
    /// From `near` to `far`, distances along the ray, wherever that is; the last sample
    /// stands for all behind it. In normalised device coordinates: all of the ray.
    Distance,
    /// The same, `near` and `far` being depths along the axis of the picture's camera, as
    /// in the authors' program. For rays without a camera, distances.
    Depth,
}

impl Hierarchical {
    /// The paper's numbers.
    pub const PAPER: Self = Self { n_coarse: 64, n_fine: 128, reach: Reach::Distance };

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`crate::Error::Range`].
    pub const fn validate(&self) -> Result<(), crate::Error> {
        if self.n_coarse < 4 || self.n_coarse > MAX_SAMPLES || self.n_fine > MAX_SAMPLES {
            return Err(crate::Error::Range("hierarchical sampling: number of samples"));
        }
        Ok(())
    }

    /// Samples of a ray after the second round.
    #[must_use]
    pub const fn n_all(&self) -> usize {
        (self.n_coarse + self.n_fine) as usize
    }
}
