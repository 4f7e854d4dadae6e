//! Rays of a tile that travel together, from start to pixel.

use fearless_simd::Simd;

use crate::Model;
use crate::lanes::LANES;
use crate::march::{Marcher, Output, RayPacket, Stage, march};
use crate::render::RenderStats;
use crate::render::composite::Compositor;
use crate::render::observe::Observer;
use crate::render::source::Source;
use crate::scratch::{Scratch, Tuning, sums_len};

/// Rays that travel together.
pub(super) struct RayGroup<'m, 's, 'o, 'f> {
    pub(super) model: &'m Model<'m>,
    pub(super) marcher: Marcher<'m>,
    pub(super) tuning: Tuning,
    pub(super) scratch: Scratch<'s>,
    pub(super) stats: RenderStats,
    /// Samples that are allowed, all pixels together.
    pub(super) max_samples: u64,
    pub(super) observer: Option<&'o mut Observer<'f>>,
}

impl RayGroup<'_, '_, '_, '_> {
    /// Rays in the group.
    #[inline(always)]
    pub(super) const fn count(&self) -> usize {
        self.scratch.slots.count
    }

    /// Rays that still find room, up to a packet of them.
    #[inline(always)]
    pub(super) fn room(&self) -> usize {
        LANES.min(self.tuning.rays - self.count())
    }

    /// Whether few more rays find room.
    #[inline(always)]
    pub(super) const fn is_full(&self) -> bool {
        self.count() + LANES / 4 > self.tuning.rays
    }

    /// Whether there have been more samples than are allowed.
    #[inline(always)]
    pub(super) const fn is_spent(&self) -> bool {
        self.stats.samples > self.max_samples
    }

    /// Notifies the observer.
    #[inline(always)]
    pub(super) fn ended(&mut self, stage: Stage, n: usize) {
        if let Some(observer) = &mut self.observer {
            observer(stage, n);
        }
    }

    /// Adds the rays of these numbers, at most sixteen, that meet an occupied
    /// cell; calls `missed` for those that do not. `known` are depths at which they
    /// may begin, and the depth of a unit vector.
    pub(super) fn add<S: Simd>(
        &mut self,
        simd: S,
        source: &(impl Source + ?Sized),
        numbers: &[u32],
        known: Option<(&[f32; LANES], [f32; 3])>,
        mut missed: impl FnMut(u32),
    ) {
        let mut packet = RayPacket::EMPTY;
        source.fill(simd, numbers, &mut packet);
        self.marcher.enter(simd, &mut packet);
        if let Some((depths, axis)) = known {
            self.marcher.begin_at(simd, &mut packet, depths, axis);
        }
        (numbers.len()..LANES).for_each(|lane| packet.stop(lane));
        let bent = self.marcher.space().is_bent();
        self.marcher.seek(simd, &mut packet);
        for (lane, number) in numbers.iter().enumerate() {
            // Where rays bend, the next piece may meet one.
            if packet.next[lane] < packet.end[lane] || packet.next[lane].is_finite() && bent {
                self.scratch.slots.push(&packet, lane, *number);
            } else {
                missed(*number);
            }
        }
    }

    /// Takes all rays to their ends.
    pub(super) fn march<S: Simd>(&mut self, simd: S) {
        let (model, count) = (self.model, self.count());
        let channels = model.field.channels();
        let Self { marcher, scratch, stats, max_samples, observer, .. } = self;
        let max_samples = *max_samples;
        let Scratch { work, samples, slots, active, sums, .. } = scratch;
        sums[..count * sums_len(channels)].fill(0.0);
        active[..count].iter_mut().zip(0..).for_each(|(active, number)| *active = number);
        let step = model.sampling.step;
        let mut sink = Compositor { slots, sums, channels, step, stats, max_samples, observer };
        let active = &mut active[..count];
        march(simd, &model.field, Output::Channels, marcher, (samples, work), active, &mut sink);
    }
}
