//! Clearing: thin fog is removed while the field learns.
//!
//! Opaque photographs leave thin fog wherever no other camera sees it against something else. Once
//! its cells are empty, surfaces take over what it showed, other views no longer look through it,
//! and rays take fewer samples. So the density below which a cell counts as empty rises, slowly, and
//! the field learns on. But glass and smoke are thin, too: where training views become worse, the
//! usual density counts again.

use crate::trainer::Trainer;

/// The share of a run after which cells are cleared, ...
const BEGIN: f32 = 0.4;
/// ... this one at the latest, so that surfaces have time to follow, ...
const LATEST: f32 = 0.5;
/// ... and the one after which no more are.
const END: f32 = 0.8;
/// Optical thickness of a step up to which a cell counts as empty in the end, times the usual.
const MOST: f32 = 8.0;
/// What training views may lose on the way, dB.
const LOSS: f64 = 0.3;

/// How far a field is cleared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clearing {
    /// Optical thickness of a step from which on a cell is occupied, times the usual.
    pub(crate) factor: f32,
    /// The share of the run after which that began; 1: not yet, or given up.
    since: f32,
    /// PSNR of the training views when it was best since then, dB.
    best: f32,
}

impl Clearing {
    /// Not yet.
    pub(crate) const NONE: Self = Self { factor: 1.0, since: 1.0, best: 0.0 };
    /// No more.
    const GIVEN_UP: Self = Self { best: f32::INFINITY, ..Self::NONE };

    /// After this share of a run, training views having this PSNR, dB.
    fn after(self, progress: f32, psnr: f64) -> Self {
        let has_begun = self.since < 1.0;
        if !(has_begun || (BEGIN..=LATEST).contains(&progress)) || self == Self::GIVEN_UP {
            return self;
        }
        if has_begun && psnr < f64::from(self.best) - LOSS {
            return Self::GIVEN_UP;
        }
        let since = self.since.min(progress);
        let share = ((progress - since) / (END - since)).clamp(0.0, 1.0);
        Self { factor: MOST.powf(share), since, best: self.best.max(psnr as f32) }
    }

    /// As a checkpoint has it.
    pub(crate) fn to_bytes(self) -> [u8; 12] {
        bytemuck::must_cast([self.factor, self.since, self.best].map(f32::to_le_bytes))
    }

    /// The same from its bytes; `None` where no run comes to this.
    pub(crate) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (numbers, []) = bytes.as_chunks::<4>() else { return None };
        let numbers: [_; 3] = numbers.try_into().ok()?;
        let [factor, since, best] = numbers.map(f32::from_le_bytes);
        let is_sound = (1.0..=MOST).contains(&factor)
            && ((BEGIN..=LATEST).contains(&since) || since == 1.0)
            && best >= 0.0;
        is_sound.then_some(Self { factor, since, best })
    }
}

impl Trainer {
    /// Whether cells count as empty that are denser than usual, see
    /// [`TrainConfig::clear_fog`](crate::trainer::TrainConfig::clear_fog).
    #[must_use]
    pub fn has_cleared_fog(&self) -> bool {
        self.clearing.factor > 1.0
    }

    /// Whether that was given up, because training views became worse.
    #[must_use]
    pub fn gave_up_clearing(&self) -> bool {
        self.clearing == Clearing::GIVEN_UP
    }

    /// Clears cells after this share of a run, training views having this PSNR, dB, once their
    /// scene has taken shape.
    pub(crate) fn clear_fog(&mut self, progress: f32, psnr: f64) {
        if self.config.clear_fog && self.step >= self.config.settled() {
            self.clearing = self.clearing.after(progress, psnr);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cleared_by_hand() {
        let after = |found: &[(f32, f64)]| {
            found.iter().fold(Clearing::NONE, |all, (progress, psnr)| all.after(*progress, *psnr))
        };
        assert_eq!(after(&[(0.2, 20.0), (0.39, 10.0)]), Clearing::NONE);
        let half_way = after(&[(0.4, 20.0), (0.6, 19.8)]);
        assert_eq!(half_way.best, 20.0);
        assert!((half_way.factor - MOST.sqrt()).abs() < 1e-3);
        assert_eq!(after(&[(0.4, 20.0), (0.8, 21.0), (0.9, 21.0)]).factor, MOST);
        // As slowly where it begins later, and never too late.
        assert_eq!(after(&[(0.45, 20.0)]).factor, 1.0);
        assert!((after(&[(0.45, 20.0), (0.625, 20.0)]).factor - MOST.sqrt()).abs() < 1e-3);
        assert_eq!(after(&[(0.51, 20.0), (0.8, 21.0)]), Clearing::NONE);
        // Training views become worse: never again.
        assert_eq!(after(&[(0.4, 20.0), (0.6, 19.6), (0.7, 25.0)]), Clearing::GIVEN_UP);
    }

    #[test]
    fn bytes_of_a_checkpoint() {
        let found = Clearing { factor: 3.0, since: 0.45, best: 30.0 };
        for clearing in [Clearing::NONE, Clearing::GIVEN_UP, found] {
            assert_eq!(Clearing::from_bytes(&clearing.to_bytes()), Some(clearing));
        }
        for factor in [0.5, f32::NAN, 100.0] {
            assert_eq!(Clearing::from_bytes(&Clearing { factor, ..found }.to_bytes()), None);
        }
        for since in [0.1, f32::NAN, 2.0] {
            assert_eq!(Clearing::from_bytes(&Clearing { since, ..found }.to_bytes()), None);
        }
        let best = f32::NAN;
        assert_eq!(Clearing::from_bytes(&Clearing { best, ..found }.to_bytes()), None);
        assert_eq!(Clearing::from_bytes(&[0; 7]), None);
        assert_eq!(Clearing::from_bytes(&[0; 16]), None);
    }
}
