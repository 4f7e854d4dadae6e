//! The caller's working memory, cut into the buffers that a tile needs.

use crate::Error;
use crate::lanes::LANES;
use crate::march::{RayLimits, RaySlots, SampleBatch};
use crate::network::panel_len;

/// The largest model that scratch is sized for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Widest layer: the position encoding's output, any network's input,
    /// hidden layer or output.
    pub width: usize,
    /// Rows of a batch of samples in each of the two buffers that layers alternate
    /// between: the position encoding's output and every second layer after it, and
    /// the layers between. What is computed once a ray takes turns in them.
    pub rows: [usize; 2],
    /// Features that the density network gives, and channels that a ray
    /// accumulates, whichever is more; at least 3.
    pub channels: usize,
    /// Samples of a ray in hierarchical sampling; 0: it is not used.
    pub ray_samples: usize,
}

/// How much is worked on at a time: speed against memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tuning {
    /// Samples a batch: a multiple of 32.
    pub samples: usize,
    /// Rays in flight: a multiple of 16, at most `samples`.
    pub rays: usize,
}

impl Limits {
    /// Enough for every hash grid with networks up to 64 wide.
    pub const SMALL: Self = Self { width: 64, rows: [64; 2], channels: 15, ray_samples: 0 };

    /// Rays that travel together in hierarchical sampling: enough to fill batches even
    /// where most samples lie in empty cells.
    pub(crate) const fn hierarchical_rays(&self, tuning: Tuning) -> usize {
        if self.ray_samples == 0 {
            return 0;
        }
        let wanted = 16 * tuning.samples / self.ray_samples;
        let most = if tuning.rays < 4096 { tuning.rays } else { 4096 };
        if wanted > most {
            most
        } else if wanted == 0 {
            1
        } else {
            wanted
        }
    }
}

impl Tuning {
    /// At most 24 KiB with [`Limits::SMALL`]: microcontrollers.
    pub const SMALL: Self = Self { samples: 32, rays: 16 };
    /// At most 1 MiB with [`Limits::SMALL`]: what fits a core's second-level cache.
    pub const FAST: Self = Self { samples: 1024, rays: 512 };

    /// Checks that scratch can be cut up like this.
    ///
    /// # Errors
    /// [`Error::Range`].
    pub fn validate(&self) -> Result<(), Error> {
        let Self { samples, rays } = *self;
        let multiples = samples.is_multiple_of(32) && rays.is_multiple_of(LANES);
        if !multiples || rays == 0 || rays > samples || rays > 1 << 24 {
            return Err(Error::Range(
                "tuning: samples a multiple of 32, rays of 16 and no more than samples or 2^24",
            ));
        }
        Ok(())
    }

    /// Distance between rows of a batch. Not a power of two, or the rows would
    /// compete for the same lines of the cache.
    #[must_use]
    pub const fn stride(&self) -> usize {
        if self.samples >= 256 { self.samples + 16 } else { self.samples }
    }
}

/// Values that may be left out at the start, so that rows begin at a line of
/// the cache.
const ALIGNMENT: usize = 15;
/// Values kept of a ray on its way, beside its channels.
pub(crate) const RAY_LEN: usize = 16;
/// Sums kept for a ray: of what is in a field's rows of output, in whole
/// registers.
pub(crate) const fn sums_len(channels: usize) -> usize {
    (1 + channels).next_multiple_of(LANES)
}

/// Rows kept for a sample: position, direction, distance, and whose it is.
const SAMPLE_ROWS: usize = 8;

/// `f32` values that [`render_tile`](crate::render::render_tile) needs.
#[must_use]
pub const fn scratch_len(limits: Limits, tuning: Tuning) -> usize {
    let stride = tuning.stride();
    ALIGNMENT
        + buffer_len(limits, tuning, 0)
        + buffer_len(limits, tuning, 1)
        + (1 + limits.channels) * stride
        + panel_len(limits.width)
        + SAMPLE_ROWS * stride
        + tuning.rays * (RAY_LEN + 2 + sums_len(limits.channels))
        + depths_len(tuning)
        + hierarchical_len(limits, tuning)
}

/// What hierarchical sampling takes: two rows a ray, one more, and one of a batch.
const fn hierarchical_len(limits: Limits, tuning: Tuning) -> usize {
    if limits.ray_samples == 0 {
        return 0;
    }
    let rows = 2 * limits.hierarchical_rays(tuning) + 1;
    rows * limits.ray_samples + tuning.stride()
}

/// Depths of a tile's squares of pixels: for a tile of 128 x 64 pixels enough for
/// squares of 8 x 8, of 4 x 4 where there is memory for many rays.
const fn depths_len(tuning: Tuning) -> usize {
    if tuning.rays > 128 { tuning.rays } else { 128 }
}

/// Values of a buffer: its rows of a batch, and sixteen columns of any layer.
const fn buffer_len(limits: Limits, tuning: Tuning, buffer: usize) -> usize {
    let (batch, least) = (limits.rows[buffer] * tuning.stride(), limits.width * LANES);
    if batch > least { batch } else { least }
}

/// Buffers of one batch; rows are `stride` values apart.
#[derive(Debug)]
pub struct Workspace<'s> {
    /// `[rows][stride]`: encoded points, and every second layer.
    pub a: &'s mut [f32],
    /// `[rows][stride]`: the other layers.
    pub b: &'s mut [f32],
    /// `[1 + channels][stride]`: what a field gives.
    pub output: &'s mut [f32],
    /// One panel of weights.
    pub panel: &'s mut [f32],
    /// Distance between rows.
    pub stride: usize,
    /// Whether networks may round to 14 bits, where that is faster.
    pub rounded: bool,
}

impl Workspace<'_> {
    /// The same memory for layers up to `width` wide: as many columns as find room,
    /// at most as many as before; an odd number of sixteens, or rows would compete for
    /// the same lines of the cache.
    pub(crate) fn for_width(&mut self, width: usize) -> Workspace<'_> {
        let Self { a, b, output, panel, stride, rounded } = self;
        let sixteens = (a.len().min(b.len()) / width).min(*stride) / LANES;
        let stride = ((sixteens - 1) | 1) * LANES;
        Workspace { a, b, output, panel, stride, rounded: *rounded }
    }
}

/// All of the scratch.
pub(crate) struct Scratch<'s> {
    pub(crate) work: Workspace<'s>,
    pub(crate) samples: SampleBatch<'s>,
    pub(crate) slots: RaySlots<'s>,
    /// Numbers of the rays that have steps left.
    pub(crate) active: &'s mut [u32],
    /// [`sums_len`] sums a ray.
    pub(crate) sums: &'s mut [f32],
    /// Depths of squares of pixels.
    pub(crate) depths: &'s mut [f32],
    pub(crate) hierarchical: HierarchicalScratch<'s>,
}

/// What hierarchical sampling keeps.
#[derive(Debug)]
pub(crate) struct HierarchicalScratch<'s> {
    /// `[ray][2][ray_samples]`: distances and opacities of the first round, then the
    /// distances of the second.
    pub(crate) rays: &'s mut [f32],
    /// Distances drawn for a ray.
    pub(crate) found: &'s mut [f32],
    /// The lengths that a batch's samples stand for.
    pub(crate) lengths: &'s mut [f32],
}

impl<'s> Scratch<'s> {
    /// Cuts `memory`, which holds at least [`scratch_len`] values.
    pub(crate) fn cut(memory: &'s mut [f32], limits: Limits, tuning: Tuning) -> Self {
        let stride = tuning.stride();
        // `align_offset` may refuse; then rows begin anywhere, which is slower.
        let skip = memory.as_ptr().align_offset(64);
        let mut rest = &mut memory[if skip <= ALIGNMENT { skip } else { 0 }..];
        let mut take = |n: usize| {
            let (head, tail) = core::mem::take(&mut rest).split_at_mut(n);
            rest = tail;
            head
        };
        Self {
            work: Workspace {
                a: take(buffer_len(limits, tuning, 0)),
                b: take(buffer_len(limits, tuning, 1)),
                output: take((1 + limits.channels) * stride),
                panel: take(panel_len(limits.width)),
                stride,
                rounded: false,
            },
            samples: SampleBatch {
                points: [take(stride), take(stride), take(stride)],
                directions: [take(stride), take(stride), take(stride)],
                t: take(stride),
                capacity: tuning.samples,
                len: 0,
                directed: false,
            },
            slots: RaySlots {
                runs: bytemuck::must_cast_slice_mut(take(stride)),
                rays: take(tuning.rays * RAY_LEN).as_chunks_mut().0,
                pixels: bytemuck::must_cast_slice_mut(take(tuning.rays)),
                count: 0,
                limits: RayLimits::NONE,
                public: None,
            },
            active: bytemuck::must_cast_slice_mut(take(tuning.rays)),
            sums: take(tuning.rays * sums_len(limits.channels)),
            depths: take(depths_len(tuning)),
            hierarchical: HierarchicalScratch {
                rays: take(2 * limits.hierarchical_rays(tuning) * limits.ray_samples),
                found: take(limits.ray_samples),
                lengths: take(if limits.ray_samples > 0 { stride } else { 0 }),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn promised_sizes() {
        const { assert!(scratch_len(Limits::SMALL, Tuning::SMALL) * 4 <= 24 * 1024) };
        const { assert!(scratch_len(Limits::SMALL, Tuning::FAST) * 4 <= 1024 * 1024) };
    }

    #[test]
    fn cut_uses_exactly_what_was_promised() {
        let mut memory = [0.0; scratch_len(Limits::SMALL, Tuning::SMALL)];
        let scratch = Scratch::cut(&mut memory, Limits::SMALL, Tuning::SMALL);
        assert_eq!(scratch.slots.rays.len(), Tuning::SMALL.rays);
        assert_eq!(scratch.sums.len(), Tuning::SMALL.rays * sums_len(Limits::SMALL.channels));
    }
}
