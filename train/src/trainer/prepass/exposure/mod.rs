//! How bright each photograph is beside the others.
//!
//! What changes from photograph to photograph, exposure and white balance, a field whose colours
//! depend on the direction takes for light of the scene: training's PSNR stays high, and what lies
//! between the photographs is wrong. A small field whose colours do not depend on it cannot; what
//! it shows of a view is what the other photographs say of it. Gains and that field are found by
//! turns. The model of a gain a photograph and channel is that of structure from motion and
//! NeRF in the Wild (Martin-Brualla et al. 2021), without their networks.

mod uneven;

use pocketnerf_core::{Error, SimdLevel};

use super::coarse_field::{small, step_at};
use super::{Deadline, Prepared, carved};
use crate::cameras::EveryFew;
use crate::picture::{Renderer, Settings};
use crate::trainer::Trainer;
use crate::trainer::pixels::rays::{Pixel, RaySource};
use uneven::{Neighbours, Uneven};

/// Steps of the small field between two looks.
const STEPS: u32 = 192;
/// Looks after which is known whether photographs differ ...
const LOOKS: u32 = 2;
/// ... and, where they do, by how much.
const MORE_LOOKS: u32 = 12;
/// Pixels of a view that are compared, about ...
const PIXELS: f64 = 2048.0;
/// ... and of all views together, at most.
const ALL_PIXELS: f64 = 400_000.0;
/// Fewer pixels say nothing of a view.
const FEWEST: usize = 64;
/// Values of a photograph that say something of its gain: not cut off at either end.
const BETWEEN: core::ops::RangeInclusive<u8> = 10..=245;
/// Opacity of a pixel that shows the scene alone.
const OPAQUE: f32 = 0.9;

/// What a view shows beside what the other views say of it, a channel: the median of the
/// logarithms of the ratio of the field's value to the photograph's, and the distance between
/// their quartiles.
type Ratio = Option<[f64; 2]>;

impl Prepared {
    /// Finds a gain for each channel of each photograph by which it is as bright as the others,
    /// and evens the photographs out where these differ by more than chance; gives by how much
    /// then, in stops: the standard deviation of the channel that differs most. Where cameras are
    /// few or far apart, nothing is known and nothing is changed. Trains a small field for about a
    /// second, or for some where photographs differ; after the deadline, no longer.
    ///
    /// # Errors
    /// When the configuration does not make a valid field, or the SIMD level is not there.
    pub fn even_exposure(
        self,
        simd: SimdLevel,
        deadline: Deadline,
    ) -> Result<(Self, Option<f32>), Error> {
        let Some(neighbours) = Neighbours::new(self.source.cameras()) else {
            return Ok((self, None));
        };
        let Self { source, space, candidates, hull, config } = self;
        let mut small = small(&config, &source);
        if let Some(grid) = small.field.hash_grid_mut() {
            grid.sh_degree = 1;
        }
        let mut trainer =
            Trainer::from_prepared(carved(source, hull.as_ref(), space, small), simd)?;
        let mut stops = None;
        'looks: for look in 1..=MORE_LOOKS {
            for step in 0..STEPS {
                if deadline.has_passed() {
                    break 'looks;
                }
                let taken = (look - 1) * STEPS + step;
                step_at(&mut trainer, taken as f32 / (MORE_LOOKS * STEPS) as f32);
            }
            let ratios = ratios(&trainer)?;
            let uneven = [0, 1, 2].map(|c| Uneven::new(&neighbours, &channel(&ratios, c)));
            if look == LOOKS && !uneven.iter().any(Uneven::is_more_than_chance) {
                break;
            }
            let most = uneven.iter().map(|channel| channel.spread).fold(0.0, f64::max);
            stops = (look >= LOOKS).then_some((most * core::f64::consts::LOG2_E) as f32);
            let gains = |view: usize| [0, 1, 2].map(|c| uneven[c].logs[view].exp() as f32);
            trainer.source.even_out((0..ratios.len()).map(gains).collect());
        }
        let mut source = trainer.source;
        if stops.is_none() {
            source.even_out(Vec::new());
        }
        Ok((Self { source, space, candidates, hull, config }, stops))
    }
}

fn channel(ratios: &[[Ratio; 3]], c: usize) -> Vec<Ratio> {
    ratios.iter().map(|ratios| ratios[c]).collect()
}

/// Those of all views.
fn ratios(trainer: &Trainer) -> Result<Vec<[Ratio; 3]>, Error> {
    let model = trainer.model();
    let settings = Settings { simd: trainer.backend.simd(), quality: 1.0, ..Settings::default() };
    let mut renderer = Renderer::new(&model, &settings);
    let views = 0..trainer.source.cameras().len();
    views.map(|view| ratios_of(&trainer.source, view, &mut renderer)).collect()
}

/// Those of a view, from every few of its pixels. Medians: a highlight is no exposure.
fn ratios_of(
    source: &RaySource,
    view: usize,
    renderer: &mut Renderer<'_>,
) -> Result<[Ratio; 3], Error> {
    let whole = &source.cameras()[view];
    let wanted = PIXELS.min(ALL_PIXELS / source.cameras().len() as f64);
    let few = EveryFew::new(whole, EveryFew::apart(std::iter::once(whole), wanted));
    let picture = renderer.render_through(&few.camera, &source.lenses()[view])?;
    let mut logs = [const { Vec::new() }; 3];
    for (model, [x, y]) in picture.rgba.as_chunks::<4>().0.iter().zip(few.pixels()) {
        let photo = source.as_taken(Pixel { view: view as u32, x, y });
        let counts = source.counts(view, (y * whole.width + x) as usize);
        if !counts || photo[3] != u8::MAX || model[3] < OPAQUE {
            continue;
        }
        for c in 0..3 {
            let (expected, found) = (model[c] / model[3], f32::from(photo[c]) / 255.0);
            if BETWEEN.contains(&photo[c]) && 255.0 * expected > f32::from(*BETWEEN.start()) {
                logs[c].push((expected / found).ln());
            }
        }
    }
    Ok(logs.map(|mut logs| {
        logs.sort_by(f32::total_cmp);
        let quarter = |q: usize| f64::from(logs[q * (logs.len() - 1) / 4]);
        (logs.len() >= FEWEST).then(|| [quarter(2), quarter(3) - quarter(1)])
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use crate::dataset::{Dataset, Split};
    use crate::random::Random;
    use crate::trainer::{TrainConfig, prepass};

    /// The still life, photographs multiplied by gains that differ by this share at random.
    fn found(spread: f32) -> (Option<f32>, Vec<[f32; 3]>, Vec<f32>) {
        let mut dataset: Dataset = builtin::dataset(Split::Train, 8);
        let mut random = Random::new(3, [0; 3]);
        let mut gains = Vec::new();
        for view in &mut dataset.views {
            // Of this variance.
            let gain = (spread * 12f32.sqrt() * (random.next_f32() - 0.5)).exp();
            gains.push(gain);
            for pixel in view.rgba.chunks_exact_mut(4) {
                for value in &mut pixel[..2] {
                    *value = (f32::from(*value) * gain).round().min(255.0) as u8;
                }
            }
        }
        let simd = SimdLevel::detect();
        let prepared =
            prepass::run(dataset, TrainConfig::hash_grid(), simd, Deadline::NONE).unwrap();
        let (prepared, stops) = prepared.even_exposure(simd, Deadline::NONE).unwrap();
        (stops, prepared.source.exposure().gains().to_vec(), gains)
    }

    #[test]
    fn gains_are_found_where_there_are_some() {
        let (stops, evened, _) = found(0.0);
        assert!(stops.is_none() && evened.is_empty(), "{stops:?}");
        let (stops, evened, gains) = found(0.15);
        let stops = stops.unwrap();
        println!("{stops}");
        assert!((stops / (0.15 * core::f32::consts::LOG2_E) - 1.0).abs() < 0.3, "{stops}");
        // What is left of the difference; the blue channel is as it was.
        let left = |c: usize, gains: &[f32]| {
            let logs: Vec<f32> =
                evened.iter().zip(gains).map(|(own, gain)| (own[c] * gain).ln()).collect();
            let mean = logs.iter().sum::<f32>() / logs.len() as f32;
            (logs.iter().map(|log| (log - mean).powi(2)).sum::<f32>() / logs.len() as f32).sqrt()
        };
        let one = vec![1.0; gains.len()];
        println!("{} {} {}", left(0, &gains), left(1, &gains), left(2, &one));
        assert!((0..2).all(|c| left(c, &gains) < 0.04) && left(2, &one) < 0.04);
    }
}
