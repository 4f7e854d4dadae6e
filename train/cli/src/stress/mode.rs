//! A way to fail.

use pocketnerf_train::dataset::View;
use pocketnerf_train::random::Random;

use super::{Change, Damage};

/// A way in which radiance fields are known to fail.
#[derive(Clone, Copy, Debug)]
pub struct Mode {
    /// Its name.
    pub name: &'static str,
    /// What is spoilt, a line.
    pub what: &'static str,
    /// The unit of strengths.
    pub unit: &'static str,
    /// Strengths, from weak to strong.
    pub strengths: &'static [f64],
    /// The one of a quick table.
    pub quick: f64,
    /// What the figure may be.
    pub bar: Bar,
    /// Why fields fail at it, and what helps.
    pub cause: &'static str,
    /// What was published of it, with its source; empty where nothing was.
    pub published: &'static str,
    /// What is trained and looked at; `None` where the scene has no such thing.
    pub case: fn(f64, &Context) -> Option<Case>,
}

/// What a mode measures, and what is expected of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bar {
    /// At most so many dB less than what it is compared with: mean PSNR of the test views.
    Loss(f64),
    /// At least so many dB.
    Psnr(f64),
}

impl Bar {
    /// Name of the figure.
    #[must_use]
    pub const fn figure(self) -> &'static str {
        match self {
            Self::Loss(_) => "loss, dB",
            Self::Psnr(_) => "PSNR, dB",
        }
    }

    /// The limit.
    #[must_use]
    pub const fn limit(self) -> f64 {
        match self {
            Self::Loss(limit) | Self::Psnr(limit) => limit,
        }
    }

    /// The figure of a PSNR and of that which it is compared with.
    #[must_use]
    pub fn value(self, psnr: f64, reference: f64) -> f64 {
        match self {
            Self::Loss(_) => reference - psnr,
            Self::Psnr(_) => psnr,
        }
    }

    /// Whether a figure is as expected; NaN is not.
    #[must_use]
    pub fn is_met(self, value: f64) -> bool {
        match self {
            Self::Loss(limit) => value <= limit,
            Self::Psnr(limit) => value >= limit,
        }
    }
}

/// What is known of the scene when a case is made.
#[derive(Clone, Debug)]
pub struct Context {
    /// The box of the unspoilt scene's model, smallest and largest corner; `None` where it has
    /// none.
    pub aabb: Option<[[f32; 3]; 2]>,
    /// Mean distance of the cameras from what they look at, scene units.
    pub distance: f64,
    /// Steps of training.
    pub steps: u32,
    /// The factor by which images are downscaled.
    pub downscale_factor: u32,
    /// Options of training that give each of the field's tables 2^n entries, where it has tables.
    pub entries: Option<fn(f64) -> [String; 2]>,
    /// Whether the images are cut-outs.
    pub has_alpha: bool,
    /// Whether it is a forward-facing capture.
    pub forward_facing: bool,
    /// Whether it is the built-in still life.
    pub still_life: bool,
}

/// What is measured.
#[derive(Clone, Debug)]
pub struct Case {
    /// What is trained.
    pub training: Training,
    /// What is looked at.
    pub viewing: Viewing,
    /// What it is compared with.
    pub reference: (Training, Viewing),
}

/// Where photographs come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Photos {
    /// The scene's, written anew with what is changed.
    #[default]
    Written,
    /// The scene as it was given.
    Given,
    /// Those of a built-in scene.
    BuiltIn(&'static str),
}

/// A run of training.
#[derive(Clone, Debug, Default)]
pub struct Training {
    /// Where photographs come from.
    pub photos: Photos,
    /// Downscaled by so many times more than usual, as a power of two; −1: less.
    pub smaller: i32,
    /// What is changed in all pictures, photographs and truth, before anything else.
    pub all: Option<Change>,
    /// What is changed in the photographs.
    pub change: Option<Change>,
    /// What is changed in their files.
    pub damage: Option<Damage>,
    /// Options of `pocketnerf train`.
    pub options: Vec<String>,
    /// Steps; the usual number where `None`.
    pub steps: Option<u32>,
    /// Added to the seed.
    pub seed: u64,
}

/// A look at a model.
#[derive(Clone, Debug, Default)]
pub struct Viewing {
    /// Downscaled by so many times more than usual, as a power of two; −1: less.
    pub smaller: i32,
    /// What is changed in the truth.
    pub change: Option<Change>,
    /// Cameras so many times as far away as usual, around the built-in still life.
    pub distance: Option<f64>,
    /// Options of `pocketnerf eval`.
    pub options: Vec<String>,
}

impl Case {
    /// Training of another kind, looked at as usual and compared with the usual.
    #[must_use]
    pub fn trained(training: Training) -> Self {
        let reference = (Training::default(), Viewing::default());
        Self { training, viewing: Viewing::default(), reference }
    }

    /// The usual model, looked at in two ways.
    #[must_use]
    pub fn viewed(viewing: Viewing, reference: Viewing) -> Self {
        let training = Training::default();
        Self { training: training.clone(), viewing, reference: (training, reference) }
    }
}

impl Training {
    /// With changed photographs.
    #[must_use]
    pub fn changed(
        name: &'static str,
        strength: f64,
        apply: fn(&mut Vec<View>, f64, &mut Random),
    ) -> Self {
        Self { change: Some(Change { name, strength, apply }), ..Self::default() }
    }

    /// With options.
    #[must_use]
    pub fn with(options: &[&str]) -> Self {
        Self { options: owned(options), ..Self::default() }
    }

    /// What tells it from others: part of a file name.
    #[must_use]
    pub fn id(&self) -> String {
        let photos = match self.photos {
            Photos::Written => "usual",
            Photos::Given => "given",
            Photos::BuiltIn(name) => name,
        };
        let parts = [
            part("size", Some(self.smaller).filter(|smaller| *smaller != 0)),
            changed(self.all),
            changed(self.change),
            self.damage.map(|damage| format!("{}{}", damage.name, damage.strength)),
            part("steps", self.steps),
            part("seed", Some(self.seed).filter(|seed| *seed > 0)),
        ];
        file_name(photos, parts, &self.options)
    }
}

impl Viewing {
    /// With options.
    #[must_use]
    pub fn with(options: &[&str]) -> Self {
        Self { options: owned(options), ..Self::default() }
    }

    /// What tells it from others: part of a file name.
    #[must_use]
    pub fn id(&self) -> String {
        let parts = [
            part("size", Some(self.smaller).filter(|smaller| *smaller != 0)),
            changed(self.change),
            part("distance", self.distance),
        ];
        file_name("seen", parts, &self.options)
    }
}

fn owned(options: &[&str]) -> Vec<String> {
    options.iter().map(|&option| option.to_owned()).collect()
}

/// What a change adds to a file name.
fn changed(change: Option<Change>) -> Option<String> {
    change.map(|change| format!("{}{}", change.name, change.strength))
}

/// What a value that differs from the usual adds to a file name.
fn part(name: &str, value: Option<impl std::fmt::Display>) -> Option<String> {
    value.map(|value| format!("{name}{value}"))
}

/// Parts and options, without characters that a file name may not have.
fn file_name<const N: usize>(
    first: &str,
    parts: [Option<String>; N],
    options: &[String],
) -> String {
    let options = options.iter().map(|option| option.trim_start_matches('-').to_owned());
    let parts = parts.into_iter().flatten().chain(options);
    let name = parts.fold(first.to_owned(), |name, part| name + "." + &part);
    let fits = |c: char| if c.is_ascii_alphanumeric() || "-.".contains(c) { c } else { '_' };
    name.chars().map(fits).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_met_on_their_own_side() {
        assert!(Bar::Loss(1.0).is_met(Bar::Loss(1.0).value(29.5, 30.0)));
        assert!(!Bar::Loss(1.0).is_met(Bar::Loss(1.0).value(28.0, 30.0)));
        assert!(Bar::Psnr(25.0).is_met(Bar::Psnr(25.0).value(26.0, 0.0)));
        assert!(!Bar::Psnr(25.0).is_met(f64::NAN) && !Bar::Loss(1.0).is_met(f64::NAN));
    }
}
