//! From what rays have accumulated to pixels.

use fearless_simd::Simd;

use crate::field::Decoder;
use crate::lanes::LANES;
use crate::march::RaySlot;
use crate::render::ray_group::RayGroup;
use crate::render::source::Source;
use crate::render::target::Target;
use crate::scratch::{Scratch, sums_len};

impl RayGroup<'_, '_, '_, '_> {
    /// Writes the pixels of all rays, which then are forgotten.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(
        &mut self,
        simd: S,
        source: &(impl Source + ?Sized),
        target: &mut Target<'_>,
    ) {
        let model = self.model;
        match model.field.deferred() {
            None => self.write_sums(target),
            Some(decoder) => self.shade(simd, source, decoder, target),
        }
        if let Some(depth) = &mut target.depth {
            for (pixel, slot) in self.scratch.slots.iter() {
                let ray = || source.ray(pixel as u32);
                let expected = slot.accumulated.expected_depth();
                depth[pixel] = model.space.depth(ray, expected);
            }
        }
        self.scratch.slots.count = 0;
    }

    /// Per-sample shading: the sums are the colour.
    fn write_sums(&self, target: &mut Target<'_>) {
        let slots = &self.scratch.slots;
        let sums = self.scratch.sums.chunks_exact(sums_len(3));
        for ((pixel, RaySlot { accumulated, .. }), sum) in slots.iter().zip(sums) {
            let alpha = accumulated.alpha(slots.limits.min_transmittance);
            let scale = if accumulated.opacity > 0.0 { alpha / accumulated.opacity } else { 0.0 };
            target.rgba[pixel] = [scale * sum[1], scale * sum[2], scale * sum[3], alpha];
        }
    }

    /// Deferred shading: the colour network reads each hit ray's average
    /// features, `rgb = alpha * logistic(net(sum / opacity, direction))`.
    #[inline(always)]
    fn shade<S: Simd>(
        &mut self,
        simd: S,
        source: &(impl Source + ?Sized),
        decoder: &Decoder<'_>,
        target: &mut Target<'_>,
    ) {
        let is_local = self.model.space.scene_box().is_some();
        let channels = decoder.channels();
        let Scratch { work, samples, slots, sums, .. } = &mut self.scratch;
        let mut work = work.for_width(decoder.color.max_width());
        let directions = &mut samples.directions;
        let (most, count) = (work.stride, slots.count);
        let mut first = 0;
        while first < count {
            // As many hit rays as find room.
            let (mut n, mut end) = (0, first);
            while end < count && n < most {
                let RaySlot { accumulated, state, .. } = RaySlot::load(&slots.rays[end]);
                if accumulated.opacity > 0.0 {
                    let sums = &sums[end * sums_len(channels) + 1..][..channels];
                    for (row, sum) in work.a.chunks_mut(work.stride).zip(sums) {
                        row[n] = sum / accumulated.opacity;
                    }
                    let direction = match is_local {
                        true => state.direction,
                        false => source.ray(slots.pixels[end]).direction,
                    };
                    directions.iter_mut().zip(direction).for_each(|(row, d)| row[n] = d);
                    n += 1;
                }
                end += 1;
            }
            let padded = n.next_multiple_of(LANES);
            for row in work.a.chunks_mut(work.stride).take(channels) {
                row[n..padded].fill(0.0);
            }
            directions.iter_mut().for_each(|row| row[n..padded].fill(0.0));
            let directions = [0, 1, 2].map(|axis| &*directions[axis]);
            decoder.colors(simd, directions, padded, &mut work);
            let mut column = 0;
            let min_transmittance = slots.limits.min_transmittance;
            for (pixel, RaySlot { accumulated, .. }) in slots.iter().take(end).skip(first) {
                target.rgba[pixel] = [0.0; 4];
                if accumulated.opacity > 0.0 {
                    let alpha = accumulated.alpha(min_transmittance);
                    let color = |row: usize| alpha * work.output[row * work.stride + column];
                    target.rgba[pixel] = [color(1), color(2), color(3), alpha];
                    column += 1;
                }
            }
            first = end;
        }
    }
}
