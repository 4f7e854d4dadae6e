//! From pixels to rays to pixels: pass after pass, group after group.

use fearless_simd::{Simd, dispatch};

use crate::lanes::LANES;
use crate::march::{Marcher, RayLimits, Stage};
use crate::render::foreground::Foreground;
use crate::render::hierarchical;
use crate::render::observe::Observer;
use crate::render::passes::{Pass, Span};
use crate::render::ray_group::RayGroup;
use crate::render::source::Source;
use crate::render::target::Target;
use crate::render::{Detail, HIERARCHICAL, RenderOptions, RenderStats, SamplingMode};
use crate::scratch::Scratch;
use crate::{Error, Model};

/// What is rendered where.
pub(super) struct Job<'j, R: ?Sized> {
    pub(super) model: &'j Model<'j>,
    pub(super) source: &'j R,
    pub(super) options: &'j RenderOptions,
    /// The passes.
    pub(super) span: Span,
}

/// Checks everything, then renders.
pub(super) fn render(
    job: &Job<'_, impl Source + ?Sized>,
    scratch: &mut [f32],
    rgba: &mut [f32],
    depth: Option<&mut [f32]>,
    observer: Option<&mut Observer<'_>>,
) -> Result<RenderStats, Error> {
    let Job { model, source, options, span } = *job;
    let size = source.size()?;
    options.check(model)?;
    if scratch.len() < options.scratch_len() {
        let (needed, given) = (options.scratch_len(), scratch.len());
        return Err(Error::ScratchTooSmall { needed, given });
    }
    let n = size[0] as usize * size[1] as usize;
    let depth_len = depth.as_ref().map_or(usize::MAX, |d| d.len());
    for (needed, given) in [(n.saturating_mul(4), rgba.len()), (n, depth_len)] {
        if given < needed {
            return Err(Error::OutputLength { needed, given });
        }
    }
    let level = options.simd.token()?;
    let RenderOptions { limits, tuning, skip, detail, .. } = *options;
    let public = |number| source.ray(number);
    let mut scratch = Scratch::cut(scratch, limits, tuning);
    scratch.slots.public = Some(&public);
    scratch.work.rounded = detail.rounded && matches!(options.sampling, SamplingMode::Occupancy);
    scratch.slots.limits = RayLimits {
        min_transmittance: detail.min_transmittance.max(model.sampling.min_transmittance),
        coarse_step_below: detail.coarse_step_below,
    };
    let depths = core::mem::take(&mut scratch.depths);
    let marcher = Marcher::new(model, skip);
    let stats = RenderStats::default();
    let max_samples = n as u64 * u64::from(options.max_samples_per_pixel);
    let mut group = RayGroup { model, marcher, tuning, scratch, stats, max_samples, observer };
    let foreground = match skip {
        true => source.foreground(model, span.to, depths),
        false => Foreground::unknown(depths),
    };
    group.ended(Stage::Camera, 0);
    let rgba = rgba.as_chunks_mut().0;
    let mut target = Target { rgba, depth, size, cell: source.cell(model), foreground };
    match &options.sampling {
        SamplingMode::Occupancy => {
            dispatch!(level, simd => {
                each_pass(simd, &mut group, job, &mut target);
            });
        }
        SamplingMode::Hierarchical(_) if !HIERARCHICAL => return Err(Error::Feature("nerf")),
        SamplingMode::Hierarchical(sampling) => {
            dispatch!(level, simd => {
                hierarchical::each_pixel(simd, sampling, &mut group, job, &mut target);
            });
        }
    }
    if group.is_spent() {
        return Err(Error::TooManySamples { allowed: max_samples });
    }
    Ok(group.stats)
}

fn each_pass<S: Simd>(
    simd: S,
    group: &mut RayGroup<'_, '_, '_, '_>,
    job: &Job<'_, impl Source + ?Sized>,
    target: &mut Target<'_>,
) {
    let (source, detail) = (job.source, job.options.detail);
    for pass in job.span.passes(target.size) {
        one_pass(simd, group, source, pass, detail, target);
        if group.is_spent() {
            return;
        }
    }
}

#[inline(always)]
fn one_pass<S: Simd>(
    simd: S,
    group: &mut RayGroup<'_, '_, '_, '_>,
    source: &(impl Source + ?Sized),
    pass: Pass,
    detail: Detail,
    target: &mut Target<'_>,
) {
    let tolerance = detail.tolerance(pass.half());
    let mut pixels = pass.pixels();
    loop {
        let (mut numbers, mut depths) = ([0; LANES], [0.0; LANES]);
        let (mut n, mut seen, room) = (0, 0, group.room());
        for [x, y] in pixels.by_ref() {
            seen += 1;
            let number = y * target.size[0] + x;
            let depth = target.foreground.depth([x, y]);
            if depth == f32::INFINITY {
                target.clear(number);
                continue;
            }
            if pass.half() > 0 && target.interpolate(pass, [x, y], tolerance) {
                continue;
            }
            (numbers[n], depths[n]) = (number, depth);
            n += 1;
            if n == room {
                break;
            }
        }
        group.ended(Stage::Interpolate, seen);
        group.stats.rays += n as u64;
        let known = target.foreground.is_known().then_some((&depths, target.foreground.axis));
        group.add(simd, source, &numbers[..n], known, |pixel| target.clear(pixel));
        group.ended(Stage::Camera, n);
        let is_over = n < room && pass.is_read_next();
        if group.is_full() || (is_over && group.count() > 0) {
            group.march(simd);
            let rays = group.count();
            group.stats.hits += rays as u64;
            group.finish(simd, source, target);
            group.ended(Stage::Shade, rays);
        }
        if n < room || group.is_spent() {
            return;
        }
    }
}
