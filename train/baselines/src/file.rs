//! Files of baselines and of runs that go on: a mark, a checksum and what postcard makes of the
//! structs. postcard is positional: whoever changes a struct raises the mark's number.

use pocketnerf_core::Space;
use serde::{Deserialize, Serialize};

use crate::run::Record;
use crate::scene::{Scene, Training};
use crate::{BaselineError, Method, Origin};

/// What a file begins with; the last byte is the version.
const MARK: [u8; 8] = *b"PNBASE\r1";
/// The checksum behind it.
const SUM: usize = 4;

/// A trained baseline.
#[derive(Clone, Debug)]
pub struct Baseline {
    pub(crate) record: Record,
    pub(crate) scene: Scene,
}

/// What may be in a file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Content {
    Baseline(Record, Scene),
    Run(Record, Training),
}

/// Whether bytes begin as the file of a baseline, or of a run.
#[must_use]
pub fn is_baseline(bytes: &[u8]) -> bool {
    bytes.starts_with(&MARK[..7])
}

impl Baseline {
    /// From the bytes of its file.
    ///
    /// # Errors
    /// Where the bytes are another file's, or damaged.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, BaselineError> {
        match read(bytes)? {
            Content::Baseline(record, scene) => Ok(Self { record, scene }),
            Content::Run(..) => {
                let (found, expected) = ("a checkpoint of a run", "a finished baseline");
                Err(BaselineError::Kind { found, expected })
            }
        }
    }

    /// The bytes of its file.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        write(&Content::Baseline(self.record.clone(), self.scene.clone()))
    }

    /// How it was trained.
    #[must_use]
    pub fn method(&self) -> Method {
        self.scene.method()
    }

    /// Where it comes from.
    #[must_use]
    pub fn origin(&self) -> &Origin {
        &self.record.origin
    }

    /// Steps of its training.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.record.step
    }

    /// PSNR of the last rays of its training, dB.
    #[must_use]
    pub fn train_psnr(&self) -> f64 {
        -10.0 * self.record.error.max(1e-10).log10()
    }

    /// Numbers that were learnt.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.scene.parameters()
    }

    /// What the user should know of it, if anything.
    #[must_use]
    pub fn doubt(&self) -> Option<String> {
        let Scene::Llff(llff) = &self.scene else { return None };
        let (found, all) = (llff.len(), self.record.origin.poses.len());
        (found < all).then(|| {
            format!("only {found} of {all} photographs have a multiplane image; train longer")
        })
    }

    /// The colour behind the scene, sRGB.
    #[must_use]
    pub fn background(&self) -> [f32; 3] {
        self.record.place.background
    }

    /// A box around the scene.
    #[must_use]
    pub fn space(&self) -> Space {
        let place = &self.record.place;
        let corner = |sign: f32| place.center.map(|c| c + sign * place.half);
        Space::Box { min: corner(-1.0), max: corner(1.0) }
    }
}

pub(crate) fn write(content: &Content) -> Vec<u8> {
    let start = [&MARK[..], &[0; SUM]].concat();
    // Memory alone could fail, and that aborts.
    let mut bytes = postcard::to_extend(content, start).unwrap_or_default();
    let at = MARK.len();
    let sum = crc32fast::hash(&bytes[at + SUM..]).to_le_bytes();
    bytes[at..at + SUM].copy_from_slice(&sum);
    bytes
}

pub(crate) fn read(bytes: &[u8]) -> Result<Content, BaselineError> {
    if !is_baseline(bytes) {
        return Err(BaselineError::NotABaseline);
    }
    let damaged = BaselineError::Damaged;
    let rest = bytes.strip_prefix(&MARK[..]).ok_or(damaged("another version wrote it"))?;
    let (sum, payload) = rest.split_first_chunk::<SUM>().ok_or(damaged("it is too short"))?;
    if crc32fast::hash(payload) != u32::from_le_bytes(*sum) {
        return Err(damaged("its checksum is wrong"));
    }
    let (content, rest) = postcard::take_from_bytes::<Content>(payload)
        .map_err(|_| damaged("its numbers do not fit each other"))?;
    let is_sound = match &content {
        Content::Baseline(record, scene) => record.is_sound() && scene.is_sound(),
        Content::Run(record, training) => record.is_sound() && training.is_sound(),
    };
    match is_sound && rest.is_empty() {
        true => Ok(content),
        false => Err(damaged("its numbers do not fit each other")),
    }
}

impl Record {
    fn is_sound(&self) -> bool {
        let seconds = self.seconds.is_none_or(f64::is_finite);
        self.origin.is_sound()
            && self.place.is_sound()
            && seconds
            && self.elapsed.is_finite()
            && self.error.is_finite()
    }
}
