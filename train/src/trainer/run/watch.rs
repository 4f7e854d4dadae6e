//! Watches the held-out views of a run.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::trainer::Plan;
use crate::trainer::held_out::HeldOutPsnr;

/// Looks at the held-out views in a run whose views are never returned.
const LOOKS: u32 = 20;
/// Progress at which the held-out views come back, as there is time to learn them, or the run is
/// found to overfit: views that fall earlier often recover.
const RETURN: f32 = 0.8;
/// Fall below the best that is more than noise, dB, of the mean of a look and the one before: single
/// looks at smooth scenes differ by 0.4 dB ...
const FALL: f64 = 0.3;
/// ... if it is that low so many times in a row: more often than one low look makes it.
const FALLS: u32 = 3;
/// A run that overfits goes back to its best moment and ends after this share of the steps
/// that it took until then ...
const ENDING: u32 = 8;
/// ... and at least so many: the learning rate is low, and parameters are averaged.
const LEAST: u32 = 128;

/// What has been seen of the held-out views. A checkpoint holds it (section WATCH, version 1) in
/// postcard's order of fields, which never changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Watch {
    /// Whether the views are held out now.
    pub(crate) holding: bool,
    /// Looks taken, or left out.
    looks: u32,
    /// How often in a row looks were much lower than the best.
    falls: u32,
    /// Mean PSNR of the best look and the one before it, and the step after which it was, dB.
    best: Option<(f64, u32)>,
    /// Mean and least of the last look, dB.
    last: Option<[f64; 2]>,
    /// First step and end of what is left of a run that overfits.
    ending: Option<[u32; 2]>,
    /// Whether the views stay held out to the end: whoever goes on says so again.
    #[serde(skip)]
    pub(super) to_the_end: bool,
}

/// What is to be done after a look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Then {
    /// Nothing.
    GoOn,
    /// These parameters are the best so far.
    Remember,
    /// The run goes back to the best parameters and ends soon.
    GoBack,
    /// The views come back.
    Return,
}

/// A run learnt the photographs instead of the scene, and was ended early.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overfitted {
    /// Mean PSNR of the held-out views at their best moment, dB.
    pub best: f64,
    /// The step after which that was.
    pub step: u32,
    /// At the end, dB.
    pub last: f64,
}

impl fmt::Display for Overfitted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { best, step, last } = self;
        write!(
            f,
            "held-out views were best at step {step} ({best:.2} dB) and fell while training went \
             on: the run overfits; it went back there and ended early, with {last:.2} dB; give \
             more photographs"
        )
    }
}

/// A PSNR, dB, with an error of 1/255 added: a white ball on white is learnt to 60 dB, and looks at it
/// differ by decibels that no picture of eight bits shows.
fn visible(psnr: f64) -> f64 {
    let error = 10.0_f64.powf(-psnr / 10.0) + (1.0_f64 / 255.0).powi(2);
    -10.0 * error.log10()
}

impl Watch {
    /// Nothing has been seen yet.
    pub(super) fn new(holding: bool) -> Self {
        Self { holding, ..Self::default() }
    }

    /// The plan of a run that overfits.
    pub(super) fn ending(&self) -> Option<Plan> {
        self.ending.map(|[first, end]| Plan { first, end })
    }

    /// Whether it is time for a look.
    pub(super) fn is_due(&self, plan: Plan, step: u32) -> bool {
        let done = LOOKS as f32 * plan.progress(step);
        self.holding && self.ending.is_none() && done >= (self.looks + 1) as f32
    }

    /// Notes a look after a step of a field that is `settled` or not yet.
    pub(super) fn note(
        &mut self,
        found: HeldOutPsnr,
        (plan, step): (Plan, u32),
        settled: bool,
    ) -> Then {
        self.looks = (LOOKS as f32 * plan.progress(step)) as u32;
        let before = self.last.map_or(found.mean, |[mean, _]| mean);
        let mean = 0.5 * (before + found.mean);
        self.last = Some([found.mean, found.min]);
        let best = self.best.map_or(f64::NEG_INFINITY, |(best, _)| best);
        let fell = settled && visible(mean) < visible(best) - FALL;
        self.falls = if fell { self.falls + 1 } else { 0 };
        let may_decide = plan.progress(step) >= RETURN;
        if let (true, Some((_, best))) = (may_decide && self.falls >= FALLS, self.best) {
            // Where the schedule lowers the rate and averages.
            let left = (best.saturating_sub(plan.first) / ENDING).max(LEAST);
            self.ending = Some([step.saturating_sub(3 * left), step.saturating_add(left)]);
            return Then::GoBack;
        }
        if may_decide && !self.to_the_end {
            return self.end();
        }
        if mean <= best {
            return Then::GoOn;
        }
        self.best = Some((mean, step));
        Then::Remember
    }

    /// The views are held out no longer.
    pub(super) fn end(&mut self) -> Then {
        self.holding = false;
        Then::Return
    }

    /// Notes the look at the finished model of a run that overfits.
    pub(super) fn note_end(&mut self, found: HeldOutPsnr) {
        self.last = Some([found.mean, found.min]);
    }

    /// The last look before the views came back, or at the end.
    pub(super) fn last(&self) -> Option<HeldOutPsnr> {
        self.last.map(|[mean, min]| HeldOutPsnr { mean, min })
    }

    /// Whether and how the run overfits.
    pub(super) fn overfitted(&self) -> Option<Overfitted> {
        let (Some((best, step)), Some([last, _]), Some(_)) = (self.best, self.last, self.ending)
        else {
            return None;
        };
        Some(Overfitted { best, step, last })
    }

    /// Whether a run may stand like this.
    pub(crate) fn is_sound(&self) -> bool {
        let finite = |x: f64| x.is_finite();
        let best = self.best.is_none_or(|(best, _)| finite(best));
        let last = self.last.is_none_or(|last| last.into_iter().all(finite));
        best && last && self.ending.is_none_or(|[first, end]| first < end && end < u32::MAX / 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: Plan = Plan { first: 0, end: 10_000 };

    /// Looks at a run whose held-out views are as good as `psnr` says; what was done last.
    fn watch(psnr: impl Fn(u32) -> f64) -> (Watch, u32, Then) {
        let mut watch = Watch::new(true);
        let mut then = Then::GoOn;
        for step in 1..=PLAN.end {
            if watch.is_due(PLAN, step) {
                let mean = psnr(step);
                then = watch.note(HeldOutPsnr { mean, min: mean - 1.0 }, (PLAN, step), step >= 512);
            }
            if !watch.holding || watch.ending.is_some() {
                return (watch, step, then);
            }
        }
        (watch, PLAN.end, then)
    }

    #[test]
    fn views_that_improve_come_back() {
        let (seen, step, then) = watch(|step| 20.0 + f64::from(step) * 1e-3);
        assert_eq!((step, then, seen.looks), (8000, Then::Return, 16));
        assert_eq!(seen.last(), Some(HeldOutPsnr { mean: 28.0, min: 27.0 }));
        assert_eq!((seen.overfitted(), seen.ending()), (None, None));
        // Noise is no fall: one look that is low, or many that are a little lower.
        assert_eq!(watch(|step| if step == 4000 { 20.0 } else { 25.0 }).1, 8000);
        assert_eq!(watch(|step| if step > 1000 { 24.85 } else { 25.0 }).1, 8000);
        // Nor is what no picture of eight bits shows; a little of what one does show is.
        let fallen = |from: f64| {
            let (_, step, then) = watch(|step| if step > 1000 { from - 1.0 } else { from });
            (step, then)
        };
        let [white, visible] = [55.0, 42.0].map(fallen);
        assert_eq!((white, visible), ((8000, Then::Return), (8000, Then::GoBack)));
    }

    #[test]
    fn a_run_that_overfits_ends_soon() {
        let (mut seen, step, then) = watch(|step| 25.0 - (f64::from(step) - 3000.0).abs() * 1e-3);
        // Where the views would come back.
        assert_eq!(step, 8000);
        let ending = seen.ending().unwrap();
        assert_eq!((ending, then), (Plan { first: 6875, end: 8375 }, Then::GoBack));
        assert!((ending.progress(8000) - 0.75).abs() < 1e-6);
        assert!(!seen.is_due(PLAN, 9999) && seen.is_sound());
        seen.note_end(HeldOutPsnr { mean: 24.9, min: 24.0 });
        let said = seen.overfitted().unwrap().to_string();
        assert!(
            said.starts_with("held-out views were best at step 3000 (24.75 dB) and fell ")
                && said.contains(", with 24.90 dB; "),
            "{said}"
        );
    }

    #[test]
    fn measured_runs() {
        // The built-in fog and leaves at 100x100, 3,000 steps: noise, and photographs learnt.
        let of = |looks: [f64; 16]| {
            let (seen, ..) = watch(|step| looks[(step / 500 - 1) as usize]);
            seen.overfitted().map(|found| found.step)
        };
        let fog = [
            32.9, 34.7, 35.4, 35.5, 35.8, 35.6, 36.1, 35.7, 35.7, 35.6, 36.0, 35.7, 35.7, 36.0,
            35.8, 36.0,
        ];
        assert_eq!(of(fog), None);
        let leaves = [
            24.3, 25.3, 25.9, 25.8, 25.6, 25.7, 25.7, 25.7, 25.6, 25.6, 25.5, 25.5, 25.5, 25.4,
            25.3, 25.4,
        ];
        assert_eq!(of(leaves), Some(2000));
        // A tumbler with smooth surfaces, 16,000 steps: a fall that goes by.
        let tumbler = [
            25.27, 26.30, 26.77, 26.84, 27.68, 26.78, 26.88, 26.87, 26.92, 27.38, 27.90, 27.97,
            27.86, 28.02, 28.18, 28.18,
        ];
        assert_eq!(of(tumbler), None);
        // The fall is the same, and lasts.
        let lasting = core::array::from_fn(|i| tumbler[i].min(if i < 5 { 99.0 } else { 26.9 }));
        assert_eq!(of(lasting), Some(2500));
    }

    #[test]
    fn bytes_of_version_1() {
        let watch = Watch {
            holding: true,
            looks: 300,
            falls: 1,
            best: Some((2.0, 7)),
            last: Some([1.0, 0.5]),
            ending: Some([5, 9]),
            to_the_end: false,
        };
        let [two, one, half] = [2.0f64, 1.0, 0.5].map(f64::to_le_bytes);
        let expected = [&[1, 0xac, 2, 1, 1][..], &two, &[7, 1], &one, &half, &[1, 5, 9]];
        assert_eq!(postcard::to_extend(&watch, Vec::new()).unwrap(), expected.concat());
    }

    #[test]
    fn what_no_run_has_seen_is_not_sound() {
        let unsound = [
            Watch { best: Some((f64::NAN, 1)), ..Watch::default() },
            Watch { last: Some([1.0, f64::INFINITY]), ..Watch::default() },
            Watch { ending: Some([5, 5]), ..Watch::default() },
        ];
        assert!(unsound.iter().all(|watch| !watch.is_sound()) && Watch::default().is_sound());
    }
}
