//! Options of rendering and of queries.

use pocketnerf_core::{RenderOptions, SimdLevel, Tuning};

use crate::border;
use crate::model::Model;
use crate::status::{Error, Failure, Status, call};

/// Vector instructions. Those that the machine lacks are an error.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simd {
    /// The best available.
    Detect = 0,
    /// The baseline of the build target.
    Portable = 1,
    /// x86-64-v2: 4 lanes.
    Sse42 = 2,
    /// x86-64-v3: 8 lanes.
    Avx2 = 3,
    /// Ice Lake, Zen 4 and later: 16 lanes.
    Avx512 = 4,
    /// AArch64: 4 lanes.
    Neon = 5,
}

/// Where the samples of a ray lie.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// At equal steps through occupied cells, until almost no light passes.
    Occupancy = 0,
    /// Hierarchical sampling of vanilla NeRF, coarse then fine; ignores quality. Much slower.
    Hierarchical = 1,
}

/// How much scratch memory a call uses.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// Up to 1.2 MB for a hash grid: the size of a core's L2 cache.
    Fast = 0,
    /// A few tens of kilobytes; slower. Tiles are smaller, so pictures differ slightly, within
    /// the tolerance of the quality.
    Small = 1,
}

/// Options of rendering and of queries. `pnrf_default_options` fills in the defaults, which
/// a null pointer stands for too.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// A `PnrfSimd`.
    pub simd: u32,
    /// A `PnrfSampling`.
    pub sampling: u32,
    /// A `PnrfMemory`.
    pub memory: u32,
    /// From 0, the fastest, to 1, the finest; below 0: as the file says, usually 0.5.
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

/// The error for an unknown code.
pub(crate) fn unknown(what: &str, code: u32) -> Failure {
    Failure::new(Status::Argument, format_args!("{what}: unknown code {code}"))
}

/// Writes the default options to `options`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_default_options(options: *mut Options, error: *mut Error) -> Status {
    // SAFETY: the caller's promise.
    unsafe { call(error, || border::write(options, Options::DEFAULT, "options")) }
}

/// Writes to `length` the number of `float` values of scratch that a call needs, for any
/// picture and any query of this model. Each thread needs its own. Its content does not matter
/// before a call, and is undefined afterwards.
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
