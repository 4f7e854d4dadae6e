//! From what rays have accumulated to pixels.

use fearless_simd::Simd;

use crate::field::Decoder;
use crate::march::LANES;
use crate::march::composite::Accumulated;
use crate::render::flight::Flight;
use crate::render::group::Group;
use crate::render::source::Source;
use crate::render::target::Target;
use crate::scratch::sums_len;

impl Group<'_, '_, '_, '_> {
    /// Writes the pixels of all rays, which then are forgotten.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(
        &mut self,
        simd: S,
        deferred: Option<&Decoder<'_>>,
        source: &(impl Source + ?Sized),
        target: &mut Target<'_>,
    ) {
        match deferred {
            None => self.write_sums(target),
            Some(decoder) => self.shade(simd, decoder, target),
        }
        if let Some(depth) = &mut target.depth {
            for (pixel, accumulated) in self.finished() {
                let ray = || source.ray(pixel as u32);
                depth[pixel] = self.model.space.depth(ray, accumulated.expected_depth());
            }
        }
        self.count = 0;
    }

    /// Each ray's pixel and what it has accumulated.
    fn finished(&self) -> impl Iterator<Item = (usize, Accumulated)> + Clone {
        let rays = self.scratch.rays[..self.count].iter().map(Flight::load);
        rays.map(|flight| (flight.pixel as usize, flight.accumulated))
    }

    /// Per-sample shading: the sums are the colour.
    fn write_sums(&self, target: &mut Target<'_>) {
        let sums = self.scratch.sums.chunks_exact(sums_len(3));
        for ((pixel, accumulated), sum) in self.finished().zip(sums) {
            let alpha = accumulated.alpha(self.min_transmittance);
            let scale = if accumulated.opacity > 0.0 { alpha / accumulated.opacity } else { 0.0 };
            target.rgba[pixel] = [scale * sum[1], scale * sum[2], scale * sum[3], alpha];
        }
    }

    /// Deferred shading: the colour network reads each hit ray's average
    /// features, `rgb = alpha * logistic(net(sum / opacity, direction))`.
    #[inline(always)]
    fn shade<S: Simd>(&mut self, simd: S, decoder: &Decoder<'_>, target: &mut Target<'_>) {
        let channels = decoder.channels();
        let rays = &self.scratch.rays[..self.count];
        let mut work = self.scratch.work.for_width(decoder.color.max_width());
        let most = work.stride;
        let mut first = 0;
        while first < self.count {
            // As many hit rays as find room.
            let (mut n, mut end) = (0, first);
            while end < self.count && n < most {
                let Flight { accumulated, walk, .. } = Flight::load(&rays[end]);
                if accumulated.opacity > 0.0 {
                    let sums = &self.scratch.sums[end * sums_len(channels) + 1..][..channels];
                    for (row, sum) in work.a.chunks_mut(work.stride).zip(sums) {
                        row[n] = sum / accumulated.opacity;
                    }
                    let directions = self.scratch.directions.iter_mut();
                    for (row, d) in directions.zip(walk.public_direction(&self.model.space)) {
                        row[n] = d;
                    }
                    n += 1;
                }
                end += 1;
            }
            let padded = n.next_multiple_of(LANES);
            for row in work.a.chunks_mut(work.stride).take(channels) {
                row[n..padded].fill(0.0);
            }
            for row in &mut self.scratch.directions {
                row[n..padded].fill(0.0);
            }
            let directions = [0, 1, 2].map(|axis| &*self.scratch.directions[axis]);
            decoder.colors(simd, directions, padded, &mut work);
            let mut column = 0;
            for ray in &rays[first..end] {
                let Flight { accumulated, pixel, .. } = Flight::load(ray);
                let pixel = pixel as usize;
                target.rgba[pixel] = [0.0; 4];
                if accumulated.opacity > 0.0 {
                    let alpha = accumulated.alpha(self.min_transmittance);
                    let color = |row: usize| alpha * work.output[row * work.stride + column];
                    target.rgba[pixel] = [color(1), color(2), color(3), alpha];
                    column += 1;
                }
            }
            first = end;
        }
    }
}
