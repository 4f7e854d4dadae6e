//! The three methods: the one match over them.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::run::At;
use crate::{BaselineError, Photographs, llff, neural_volumes, srn};

/// What is trained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Local light field fusion (Mildenhall et al. 2019): a multiplane image for each photograph,
    /// the nearest blended.
    Llff,
    /// Scene representation networks (Sitzmann et al. 2019).
    Srn,
    /// Neural volumes (Lombardi et al. 2019).
    NeuralVolumes,
}

impl Method {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Llff, Self::Srn, Self::NeuralVolumes];

    /// Its name on a command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Llff => "llff",
            Self::Srn => "srn",
            Self::NeuralVolumes => "neural-volumes",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// What was learnt.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Scene {
    Llff(llff::Llff),
    Srn(srn::Srn),
    NeuralVolumes(neural_volumes::NeuralVolume),
}

impl Scene {
    pub(crate) fn method(&self) -> Method {
        match self {
            Self::Llff(_) => Method::Llff,
            Self::Srn(_) => Method::Srn,
            Self::NeuralVolumes(_) => Method::NeuralVolumes,
        }
    }

    /// Numbers that were learnt.
    pub(crate) fn parameters(&self) -> usize {
        match self {
            Self::Llff(llff) => llff.values(),
            Self::Srn(srn) => srn.parameters.len(),
            Self::NeuralVolumes(volume) => volume.values(),
        }
    }

    pub(crate) fn is_sound(&self) -> bool {
        match self {
            Self::Llff(llff) => llff.is_sound(),
            Self::Srn(srn) => srn.is_sound(),
            Self::NeuralVolumes(volume) => volume.is_sound(),
        }
    }
}

/// Training in progress.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Training {
    Llff(llff::Training),
    Srn(srn::Training),
    NeuralVolumes(neural_volumes::Training),
}

impl Training {
    pub(crate) fn new(
        method: Method,
        photographs: &Photographs,
        seed: u64,
    ) -> Result<Self, BaselineError> {
        if let Some(refusal) = photographs.refusal(method) {
            return Err(refusal);
        }
        Ok(match method {
            Method::Llff => Self::Llff(llff::Training::new()),
            Method::Srn => Self::Srn(srn::Training::new(seed)),
            Method::NeuralVolumes => Self::NeuralVolumes(neural_volumes::Training::new(seed)),
        })
    }

    pub(crate) fn method(&self) -> Method {
        match self {
            Self::Llff(_) => Method::Llff,
            Self::Srn(_) => Method::Srn,
            Self::NeuralVolumes(_) => Method::NeuralVolumes,
        }
    }

    /// One step; gives the mean squared error of its rays.
    pub(crate) fn step(&mut self, photographs: &Photographs, at: At) -> f64 {
        match self {
            Self::Llff(training) => training.step(photographs, at),
            Self::Srn(training) => training.step(photographs, at),
            Self::NeuralVolumes(training) => training.step(photographs, at),
        }
    }

    /// Bytes of what is finished, which take time to be written.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Self::Llff(training) => training.bytes(),
            Self::Srn(_) | Self::NeuralVolumes(_) => 0,
        }
    }

    /// The result so far.
    pub(crate) fn scene(&self) -> Scene {
        match self {
            Self::Llff(training) => Scene::Llff(training.scene()),
            Self::Srn(training) => Scene::Srn(training.srn.clone()),
            Self::NeuralVolumes(training) => Scene::NeuralVolumes(training.scene()),
        }
    }

    pub(crate) fn is_sound(&self) -> bool {
        match self {
            Self::Llff(training) => training.is_sound(),
            Self::Srn(training) => training.is_sound(),
            Self::NeuralVolumes(training) => training.is_sound(),
        }
    }
}
