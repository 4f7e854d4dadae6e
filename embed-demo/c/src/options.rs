//! How to render and to ask.

use pocketnerf_core::{RenderOptions, SimdLevel, Tuning};

use crate::border;
use crate::model::Model;
use crate::status::{Error, Failure, Status, call};

/// Vector instructions. Asking for some that the machine lacks is an error.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simd {
    /// The best that this machine has.
    Detect = 0,
    /// What every machine has that the library is for.
    Portable = 1,
    /// x86-64-v2: 4 lanes.
    Sse42 = 2,
    /// x86-64-v3: 8 lanes.
    Avx2 = 3,
    /// Ice Lake and Zen 4 upwards: 16 lanes.
    Avx512 = 4,
    /// AArch64: 4 lanes.
    Neon = 5,
}

/// Where along a ray the field is asked.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// In occupied cells, until next to no light passes.
    Occupancy = 0,
    /// As in the paper, or as the model says; quality changes nothing. Much slower.
    Paper = 1,
}

/// How much memory a call works in.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// Up to 1.2 MB for a grid: what a core's second-level cache holds.
    Fast = 0,
    /// A few tens of kilobytes. Tiles are smaller, so that pictures differ a little (within
    /// what the quality allows); slower.
    Small = 1,
}

/// How to render and to ask. Filled in by `pnrf_default_options`; null instead means just
/// these.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// A `PnrfSimd`.
    pub simd: u32,
    /// A `PnrfSampling`.
    pub sampling: u32,
    /// A `PnrfMemory`.
    pub memory: u32,
    /// From 0, the fastest, to 1, the finest; below 0: what the file says, 0.5 as a rule.
    pub quality: f32,
}

impl Options {
    const DEFAULT: Self = Self {
        simd: Simd::Detect as u32,
        sampling: Sampling::Occupancy as u32,
        memory: Memory::Fast as u32,
        quality: -1.0,
    };

    /// # Safety
    /// As [`border::read`], or null.
    pub(crate) unsafe fn read(options: *const Self) -> Result<Self, Failure> {
        // SAFETY: the caller's promise.
        Ok(unsafe { border::read_or_none(options, "options")? }.copied().unwrap_or(Self::DEFAULT))
    }

    pub(crate) fn simd(&self) -> Result<SimdLevel, Failure> {
        let level = match self.simd {
            0 => SimdLevel::detect(),
            1 => SimdLevel::Portable,
            2 => SimdLevel::Sse42,
            3 => SimdLevel::Avx2,
            4 => SimdLevel::Avx512,
            5 => SimdLevel::Neon,
            other => return Err(unknown("simd", other)),
        };
        level.token()?;
        Ok(level)
    }

    pub(crate) fn memory(&self) -> Result<Memory, Failure> {
        match self.memory {
            0 => Ok(Memory::Fast),
            1 => Ok(Memory::Small),
            other => Err(unknown("memory", other)),
        }
    }

    pub(crate) fn tuning(&self) -> Result<Tuning, Failure> {
        Ok(match self.memory()? {
            Memory::Fast => Tuning::FAST,
            Memory::Small => Tuning::SMALL,
        })
    }

    pub(crate) fn render(&self, model: &Model) -> Result<RenderOptions, Failure> {
        let file = model.file();
        if self.quality.is_nan() {
            return Err(Failure::new(Status::Argument, "quality: not a number, expected 0 to 1"));
        }
        let own = file.about.quality.unwrap_or(0.5);
        let quality = if self.quality < 0.0 { own } else { self.quality };
        let options = RenderOptions::new(&file.model, self.simd()?, self.tuning()?);
        let options = RenderOptions { detail: file.model.detail(quality), ..options };
        match self.sampling {
            0 => Ok(options),
            1 => Ok(options.with_sampling(file.model.hierarchical_sampling())),
            other => Err(unknown("sampling", other)),
        }
    }
}

/// An error that names a code which is none of its kind.
pub(crate) fn unknown(what: &str, code: u32) -> Failure {
    Failure::new(Status::Argument, format_args!("{what}: {code} is no code of it"))
}

/// The usual options, for whoever wants to change some of them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_default_options(options: *mut Options, error: *mut Error) -> Status {
    // SAFETY: the caller's promise.
    unsafe { call(error, || border::write(options, Options::DEFAULT, "options")) }
}

/// How many `float` values of scratch a call needs, for any picture of this model and for
/// all questions. Each thread needs its own; they may hold anything, and hold nothing of
/// use afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_scratch_length(
    model: *const Model,
    options: *const Options,
    length: *mut usize,
    error: *mut Error,
) -> Status {
    let work = || {
        // SAFETY: the caller's promise.
        let (model, options) = unsafe { (border::read(model, "model")?, Options::read(options)?) };
        let needed = crate::render::scratch_len(&options, &options.render(model)?)?;
        // SAFETY: the caller's promise.
        unsafe { border::write(length, needed, "length") }
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}
