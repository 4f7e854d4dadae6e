//! Section TRAINER: everything small that a run needs to resume.
//!
//! postcard is positional: the structs here are promises about bytes and never
//! change. What changes gets a successor under the next section version.

use pocketnerf_core::Space;
use serde::{Deserialize, Serialize};

use super::TrainedOn;
use crate::field::FieldConfig;
use crate::trainer::step::{MOST_RAYS, OCCUPANCY_EVERY};
use crate::trainer::{Length, MAX_BATCH_RAYS, MAX_RESTARTS, Plan, Run, TrainConfig, Trainer};

/// How long a run is to be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum LengthV1 {
    Steps(u32),
    Seconds(f64),
}

/// The settings that the model itself does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct ConfigV1 {
    seed: u64,
    aabb: Option<[[f32; 3]; 2]>,
    near: f32,
    far: Option<f32>,
    samples_per_side: f32,
    batch_rays: Option<u32>,
    samples_per_step: u64,
    grid_rate: f32,
    grid_decay: f32,
    network_rate: f32,
    final_rate: f32,
    kept: [f32; 2],
    first_step_scale: f32,
    opaque_backdrop: [f32; 3],
    backdrop: Option<[f32; 3]>,
}

/// Counters, plan and settings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct RecordV1 {
    length: LengthV1,
    /// First step and end.
    plan: Option<[u32; 2]>,
    /// Seconds.
    pub(super) elapsed: f64,
    pub(super) rays: u64,
    pub(super) samples: u64,
    /// Squared error and opacity.
    pub(super) averages: [f64; 2],
    pub(super) restarts: u32,
    pub(super) step: u32,
    pub(super) n_rays: u32,
    pub(super) roulette: f32,
    /// Of the occupancy.
    pub(super) updates: u32,
    /// Steps whose parameters are in section SUM, which is there if this is not 0.
    pub(super) averaged: u32,
    pub(super) fingerprint: u64,
    downscale_factor: u32,
    config: ConfigV1,
}

impl RecordV1 {
    pub(super) fn new(trainer: &Trainer, run: &Run, trained_on: TrainedOn) -> Self {
        Self {
            length: match run.length {
                Length::Steps(n) => LengthV1::Steps(n),
                Length::Seconds(s) => LengthV1::Seconds(s),
            },
            plan: run.plan.map(|plan| [plan.first, plan.end]),
            elapsed: run.elapsed(),
            rays: run.rays,
            samples: run.samples,
            averages: [run.averages.squared_error, run.averages.opacity],
            restarts: trainer.restarts,
            step: trainer.step,
            n_rays: trainer.n_rays as u32,
            roulette: trainer.roulette,
            updates: trainer.grid.state().1,
            averaged: trainer.backend.download().averaged,
            fingerprint: trained_on.fingerprint,
            downscale_factor: trained_on.downscale_factor,
            config: ConfigV1::new(&trainer.config),
        }
    }

    pub(super) fn to_bytes(self) -> Vec<u8> {
        // A vector grows and the structs have a known length: nothing can fail.
        postcard::to_extend(&self, Vec::new()).unwrap_or_default()
    }

    pub(super) fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (record, rest) = postcard::take_from_bytes(bytes).ok()?;
        rest.is_empty().then_some(record)
    }

    pub(super) const fn length(&self) -> Length {
        match self.length {
            LengthV1::Steps(n) => Length::Steps(n),
            LengthV1::Seconds(s) => Length::Seconds(s),
        }
    }

    pub(super) fn plan(&self) -> Option<Plan> {
        self.plan.map(|[first, end]| Plan { first, end })
    }

    pub(super) const fn trained_on(&self) -> TrainedOn {
        TrainedOn { fingerprint: self.fingerprint, downscale_factor: self.downscale_factor }
    }

    /// The settings, with those that the model holds.
    pub(super) fn config(
        &self,
        field: FieldConfig,
        space: Space,
        occupancy_resolution: u32,
        (refine_poses, smooth_surfaces, clear_fog): (bool, f32, bool),
    ) -> TrainConfig {
        let config = &self.config;
        TrainConfig {
            field,
            seed: config.seed,
            aabb: config.aabb,
            ndc: match space {
                Space::Ndc(ndc) => Some(ndc),
                _ => None,
            },
            contracted: match space {
                Space::Contracted(contracted) => Some(contracted),
                _ => None,
            },
            near: config.near,
            far: config.far,
            occupancy_resolution,
            samples_per_side: config.samples_per_side,
            batch_rays: config.batch_rays.map(|n| n as usize),
            samples_per_step: config.samples_per_step as usize,
            grid_rate: config.grid_rate,
            grid_decay: config.grid_decay,
            network_rate: config.network_rate,
            final_rate: config.final_rate,
            kept: config.kept,
            first_step_scale: config.first_step_scale,
            opaque_backdrop: config.opaque_backdrop,
            backdrop: config.backdrop,
            smooth_surfaces,
            clear_fog,
            refine_poses,
        }
    }

    /// Checks that a run may stand like this; says what cannot be.
    pub(super) fn check(&self, config: &TrainConfig) -> Result<(), &'static str> {
        let holds = |what, holds: bool| if holds { Ok(()) } else { Err(what) };
        let positive = |x: f64| x.is_finite() && x >= 0.0;
        let (seconds, planned) = match (self.length, self.plan) {
            (LengthV1::Steps(n), plan) => (0.0, plan == Some([0, n])),
            // Far from the end of the counter, so that it cannot overflow.
            (LengthV1::Seconds(s), None) => (s, self.step < u32::MAX / 2),
            (LengthV1::Seconds(s), Some(_)) => (s, true),
        };
        holds("its length", positive(seconds) && seconds < 1e9)?;
        let [first, end] = self.plan.unwrap_or([0, self.step]);
        holds("its plan", planned && (first..=end).contains(&self.step))?;
        holds("its time", positive(self.elapsed) && self.elapsed < 1e9)?;
        holds("its averages", self.averages.into_iter().all(positive))?;
        holds("its number of restarts", self.restarts <= MAX_RESTARTS)?;
        let n_rays = self.n_rays as usize;
        let rays = match config.batch_rays {
            Some(n) => n == n_rays && (1..=MAX_BATCH_RAYS).contains(&n),
            None => (1..=MOST_RAYS).contains(&n_rays),
        };
        holds("its number of rays", rays)?;
        holds("its roulette", positive(self.roulette.into()))?;
        let most = self.step.div_ceil(OCCUPANCY_EVERY);
        holds("its number of occupancy updates", self.updates <= most)?;
        holds("its downscale factor", self.downscale_factor >= 1)?;
        holds("a setting", self.config.is_finite())
    }
}

impl ConfigV1 {
    fn new(config: &TrainConfig) -> Self {
        // Without `..`: a new setting forces a decision here.
        let TrainConfig {
            field: _,
            seed,
            aabb,
            ndc: _,
            contracted: _,
            near,
            far,
            occupancy_resolution: _,
            samples_per_side,
            batch_rays,
            samples_per_step,
            grid_rate,
            grid_decay,
            network_rate,
            final_rate,
            kept,
            first_step_scale,
            opaque_backdrop,
            backdrop,
            smooth_surfaces: _,
            clear_fog: _,
            refine_poses: _,
        } = *config;
        Self {
            seed,
            aabb,
            near,
            far,
            samples_per_side,
            batch_rays: batch_rays.map(|n| n as u32),
            samples_per_step: samples_per_step as u64,
            grid_rate,
            grid_decay,
            network_rate,
            final_rate,
            kept,
            first_step_scale,
            opaque_backdrop,
            backdrop,
        }
    }

    fn is_finite(&self) -> bool {
        let boxes = self.aabb.iter().flatten().flatten();
        let colors = self.opaque_backdrop.iter().chain(self.backdrop.iter().flatten());
        let numbers = [
            self.near,
            self.far.unwrap_or(0.0),
            self.samples_per_side,
            self.grid_rate,
            self.grid_decay,
            self.network_rate,
            self.final_rate,
            self.first_step_scale,
        ];
        boxes.chain(colors).chain(&self.kept).chain(&numbers).all(|x| x.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPACE: Space = Space::Box { min: [0.0; 3], max: [1.0; 3] };

    const RECORD: RecordV1 = RecordV1 {
        length: LengthV1::Steps(300),
        plan: Some([0, 300]),
        elapsed: 1.0,
        rays: 300,
        samples: 5,
        averages: [0.5, 0.25],
        restarts: 1,
        step: 20,
        n_rays: 1024,
        roulette: 0.0,
        updates: 2,
        averaged: 6,
        fingerprint: 7,
        downscale_factor: 2,
        config: ConfigV1 {
            seed: 3,
            aabb: None,
            near: 0.0,
            far: Some(1.0),
            samples_per_side: 1.0,
            batch_rays: None,
            samples_per_step: 128,
            grid_rate: 0.0,
            grid_decay: 0.0,
            network_rate: 0.0,
            final_rate: 0.0,
            kept: [1.0, 0.0],
            first_step_scale: 0.0,
            opaque_backdrop: [0.0; 3],
            backdrop: None,
        },
    };
    const OTHERS: (bool, f32, bool) = (false, 0.0, false);

    #[test]
    fn bytes_of_record_v1() {
        let f32_one = [0, 0, 0x80, 0x3f];
        let expected = [
            &[0, 0xac, 2, 1, 0, 0xac, 2][..],
            &1f64.to_le_bytes(),
            &[0xac, 2, 5],
            &0.5f64.to_le_bytes(),
            &0.25f64.to_le_bytes(),
            &[1, 20, 0x80, 8, 0, 0, 0, 0, 2, 6, 7, 2],
            &[3, 0, 0, 0, 0, 0, 1],
            &f32_one,
            &f32_one,
            &[0, 0x80, 1],
            &[0; 16],
            &f32_one,
            &[0; 4],
            &[0; 4],
            &[0; 12],
            &[0],
        ]
        .concat();
        assert_eq!(RECORD.to_bytes(), expected);
        assert_eq!(RecordV1::from_bytes(&expected), Some(RECORD));
        assert_eq!(RecordV1::from_bytes(&expected[1..]), None);
        assert_eq!(RecordV1::from_bytes(&[&expected[..], &[0]].concat()), None);
    }

    #[test]
    fn states_that_no_run_has() {
        let check = |change: fn(&mut RecordV1)| {
            let mut record = RECORD;
            change(&mut record);
            record.check(&record.config(TrainConfig::hash_grid().field, SPACE, 128, OTHERS))
        };
        assert_eq!(check(|_| ()), Ok(()));
        assert_eq!(check(|r| r.length = LengthV1::Seconds(f64::NAN)), Err("its length"));
        assert_eq!(check(|r| r.plan = None), Err("its plan"));
        assert_eq!(check(|r| r.plan = Some([0, 299])), Err("its plan"));
        assert_eq!(check(|r| r.step = 301), Err("its plan"));
        assert_eq!(check(|r| r.elapsed = -1.0), Err("its time"));
        assert_eq!(check(|r| r.averages[1] = f64::INFINITY), Err("its averages"));
        assert_eq!(check(|r| r.restarts = 4), Err("its number of restarts"));
        assert_eq!(check(|r| r.n_rays = 0), Err("its number of rays"));
        assert_eq!(check(|r| r.n_rays = 1 << 18), Err("its number of rays"));
        assert_eq!(check(|r| r.config.batch_rays = Some(9)), Err("its number of rays"));
        assert_eq!(check(|r| r.roulette = f32::NAN), Err("its roulette"));
        assert_eq!(check(|r| r.updates = 3), Err("its number of occupancy updates"));
        assert_eq!(check(|r| r.downscale_factor = 0), Err("its downscale factor"));
        assert_eq!(check(|r| r.config.near = f32::NAN), Err("a setting"));
        assert_eq!(check(|r| r.config.backdrop = Some([f32::NAN; 3])), Err("a setting"));
        // A timed run may not know its plan yet; once it does, it is inside it.
        let timed = |r: &mut RecordV1| (r.length, r.plan) = (LengthV1::Seconds(9.0), None);
        let mut record = RECORD;
        timed(&mut record);
        let config = record.config(TrainConfig::hash_grid().field, SPACE, 128, OTHERS);
        assert_eq!(record.check(&config), Ok(()));
        record.plan = Some([21, 90]);
        assert_eq!(record.check(&config), Err("its plan"));
    }
}
