//! Training views that are learnt worse than any other.

use crate::metrics::{mean, median};
use crate::trainer::Trainer;
use crate::trainer::held_out::HeldOut;
use crate::trainer::pixels::importance::UNKNOWN;
use crate::trainer::run::LONG_ENOUGH;

/// A photograph is odd whose error is so many times the median of all ...
const ODD: f64 = 4.0;
/// ... and so many times as far above it as usual on a logarithmic scale.
const FAR: f64 = 6.0;
/// What is learnt as well as this, dB, is not wrong, however well the others are learnt.
const WELL: f64 = 34.0;
/// Half of its tiles are also so many dB worse than those of others, as where a pose is wrong ...
const ALL_OVER: f64 = 8.0;
/// ... or all of it together is so many dB worse than usual, as where something stands in front.
/// Sound photographs from above a mirror, which no other shows so, are up to 11 dB worse.
const IN_PART: f64 = 13.0;
/// A photograph that was held out for most of a long run is odd if it is so many dB worse than
/// usual: it had less time to be learnt.
const HELD_ODD: f64 = 15.0;

impl Trainer {
    /// Views that were held out for most of the run: all long ones have some, even where the
    /// part that was resumed does not know, and short ones whose end the clock decides.
    pub(in crate::trainer) fn held_out_for_long(&self) -> HeldOut {
        match self.step < LONG_ENOUGH {
            true => self.returned.clone(),
            false => HeldOut::choose(&self.source, self.config.seed),
        }
    }

    /// Those of the views that were held out that are far worse than usual, with their PSNR.
    pub(super) fn odd_among(&self, held: &HeldOut, usual: f64) -> Vec<(usize, f64)> {
        let errors = self.errors_of_views(&HeldOut::default()).into_iter().enumerate();
        let held = errors.filter(|(view, error)| held.has(*view) && error.mean > 0.0);
        let values = held.map(|(view, error)| (view, psnr(error.mean)));
        values.filter(|(_, found)| *found < (usual - HELD_ODD).min(WELL)).collect()
    }

    /// The error of what was drawn of each training view; NaN where little was, as of those that
    /// were held out.
    pub(super) fn errors_of_views(&self, held: &HeldOut) -> Vec<ErrorOfView> {
        let mut tiles = vec![Vec::new(); self.source.cameras().len()];
        let [errors, _] = self.sampler.state();
        for (tile, error) in errors.iter().enumerate().filter(|(_, error)| **error != UNKNOWN) {
            tiles[self.visibility.view(tile)].push(f64::from(*error));
        }
        let of = |(view, tiles): (usize, Vec<f64>)| {
            let known = || tiles.iter().copied().filter(|_| !held.has(view));
            let [mean, half] = [mean(known()), median(known())].map(|e| e.unwrap_or(f64::NAN));
            ErrorOfView { mean, half }
        };
        tiles.truncate(self.source.photographs().len());
        tiles.into_iter().enumerate().map(of).collect()
    }
}

/// The squared error of a training view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ErrorOfView {
    /// The mean of all its tiles.
    pub(super) mean: f64,
    /// Their median.
    pub(super) half: f64,
}

/// Of a mean squared error, dB.
pub(super) fn psnr(error: f64) -> f64 {
    -10.0 * error.log10()
}

/// Views whose errors are like no other's, with their PSNR, and the median PSNR.
pub(super) fn odd(errors: &[ErrorOfView]) -> (Vec<(usize, f64)>, f64) {
    let logs = || errors.iter().filter(|error| error.mean > 0.0).map(|error| error.mean.ln());
    let middle = median(logs()).unwrap_or(0.0);
    let spread = median(logs().map(|log| (log - middle).abs())).unwrap_or(0.0);
    let usual = psnr(middle.exp());
    let halves = errors.iter().map(|error| error.half).filter(|half| *half > 0.0);
    let usual_half = median(halves.map(psnr)).unwrap_or(0.0);
    let is_odd = |error: &ErrorOfView| {
        let own = psnr(error.mean);
        let is_far = error.mean.ln() - middle > ODD.ln().max(FAR * spread) && own < WELL;
        is_far && (usual - own > IN_PART || usual_half - psnr(error.half) > ALL_OVER)
    };
    let all = errors.iter().enumerate().filter(|(_, error)| error.mean > 0.0 && is_odd(error));
    let mut odd: Vec<(usize, f64)> = all.map(|(view, error)| (view, psnr(error.mean))).collect();
    odd.sort_by(|a, b| a.1.total_cmp(&b.1));
    (odd, usual)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Views whose tiles have the same error.
    fn even(errors: &[f64]) -> Vec<ErrorOfView> {
        errors.iter().map(|error| ErrorOfView { mean: *error, half: *error }).collect()
    }

    #[test]
    fn an_odd_view_is_like_no_other() {
        let mut errors: Vec<f64> = (0..20).map(|i| 1e-3 * (1.0 + 0.05 * f64::from(i))).collect();
        assert_eq!(odd(&even(&errors)).0, []);
        (errors[7], errors[3]) = (1e-2, f64::NAN);
        let (found, usual) = odd(&even(&errors));
        let [(view, psnr)] = found[..] else { panic!("{found:?}") };
        assert!(view == 7 && (psnr - 20.0).abs() < 1e-9, "{view} {psnr}");
        assert!((28.0..29.0).contains(&usual), "{usual}");
        // 36 dB where the others have 47 is still 36.
        let mut small: Vec<f64> = (0..20).map(|i| 2e-5 * (1.0 + 0.05 * f64::from(i))).collect();
        small[7] = 2.5e-4;
        assert_eq!(odd(&even(&small)).0, []);
        small[7] = 2.5e-3;
        assert_eq!(odd(&even(&small)).0[..], [(7, super::psnr(2.5e-3))]);
        // Where errors differ anyway, more is needed.
        let wide: Vec<f64> = (0..20).map(|i| 1e-4 * 1.6f64.powi(i)).collect();
        assert_eq!(odd(&even(&wide)).0, []);
    }

    /// Of a mirror from above, as the built-in one is after 3,000 steps at 100x100, and of a
    /// square in front of a twentieth of the picture.
    #[test]
    fn a_part_that_is_hard_is_not_odd_and_one_that_is_hidden_is() {
        let mut views = even(&[2e-4; 20]);
        // 29.0 dB beside 37.0.
        views[0].mean = 1.26e-3;
        assert_eq!(odd(&views).0, []);
        // 23.0 dB.
        views[4].mean = 5e-3;
        assert_eq!(odd(&views).0[..], [(4, psnr(5e-3))]);
        // As bad as the first, but all over.
        views[9] = ErrorOfView { mean: 1.3e-3, half: 1.3e-3 };
        let views_found: Vec<usize> = odd(&views).0.into_iter().map(|(view, _)| view).collect();
        assert_eq!(views_found, [4, 9]);
    }
}
