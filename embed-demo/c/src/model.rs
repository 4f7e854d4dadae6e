//! Opening and closing.

use std::borrow::Cow;
use std::ffi::{CStr, c_char, c_void};
use std::fs::File;
use std::io::Read;
use std::path::Path;

use pocketnerf_core::query::Similarity;
use pocketnerf_formats::{ModelFile, Scene, open, open_verified, unpacked};
use self_cell::self_cell;

use crate::border;
use crate::status::{Error, Failure, Status, call};

/// For `pnrf_open_bytes`: the bytes are not copied. They must stay in place, unchanged, until
/// the model is closed. (A packed file is unpacked to memory of the model's own.)
pub const OPEN_BORROWED: u32 = 1;
/// Skip the check of checksums and weights: opening takes no time, whatever the size. Damaged
/// weights then give wrong pictures, but never a crash.
pub const OPEN_UNVERIFIED: u32 = 2;
/// Do not build the empty-space skip table: less memory (`table_bytes` of `PnrfInfo`), the
/// same pictures, 10 to 15 % more time.
pub const OPEN_WITHOUT_TABLE: u32 = 4;
/// Use the model's own coordinates and units for cameras, points and lengths, instead of
/// those of the photographs it was made from.
pub const OPEN_MODEL_COORDINATES: u32 = 8;

/// The largest file that is read, far larger than any model.
const MOST_BYTES: u64 = 1 << 30;

/// An open model. It never changes, so any number of threads may use it at the same time.
#[derive(Debug)]
pub struct Model {
    opened: Opened,
    /// From the model's coordinates to the caller's.
    scene: Scene<'static>,
}

// The header promises that threads may share it.
const _: fn() = || {
    const fn is_shared<T: Send + Sync>() {}
    is_shared::<Model>();
};

impl Model {
    pub(crate) fn file(&self) -> &ModelFile<'_> {
        self.opened.borrow_dependent()
    }

    /// The caller's coordinates.
    pub(crate) const fn scene(&self) -> &Scene<'static> {
        &self.scene
    }

    /// What is up, a unit vector in the caller's coordinates.
    pub(crate) fn up(&self) -> [f32; 3] {
        let about = &self.file().about;
        let up = about.world.up();
        if self.scene.similarity() == about.scene.similarity() {
            return up;
        }
        // The caller's coordinates are the model's.
        about.scene.to_model_direction(up)
    }

    /// How long the caller's unit is; 0 where the file says nothing.
    pub(crate) fn metres_per_unit(&self) -> f32 {
        let about = &self.file().about;
        about.world.metres.map_or(0.0, |metres| metres * about.scene.scale / self.scene.scale)
    }

    pub(crate) fn similarity(&self) -> Similarity {
        self.scene.similarity()
    }

    pub(crate) fn n_bytes(&self) -> usize {
        self.opened.borrow_owner().bytes.get().len()
    }

    pub(crate) fn table_len(&self) -> usize {
        self.opened.borrow_owner().table.len()
    }
}

self_cell!(
    /// A file with the memory that it borrows.
    struct Opened {
        owner: Memory,
        #[covariant]
        dependent: ModelFile,
    }

    impl {Debug}
);

#[derive(Debug)]
struct Memory {
    bytes: Bytes,
    /// The empty-space skip table; empty without one.
    table: Box<[u8]>,
}

enum Bytes {
    Borrowed(&'static [u8]),
    Owned(Box<[u8]>),
}

impl Bytes {
    const fn get(&self) -> &[u8] {
        match self {
            Self::Borrowed(bytes) => bytes,
            Self::Owned(bytes) => bytes,
        }
    }

    /// The ordinary file of a packed one, in memory of its own; other files as they are.
    fn unpacked(self) -> Result<Self, Failure> {
        let unpacked = match unpacked(self.get())? {
            Cow::Owned(bytes) => Some(bytes),
            Cow::Borrowed(_) => None,
        };
        Ok(unpacked.map_or(self, |bytes| Self::Owned(bytes.into())))
    }
}

impl std::fmt::Debug for Bytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} bytes", self.get().len())
    }
}

impl Model {
    fn open(bytes: Bytes, flags: u32) -> Result<Self, Failure> {
        let bytes = bytes.unpacked()?;
        let opened = match flags & OPEN_UNVERIFIED {
            0 => open_verified(bytes.get())?,
            _ => open(bytes.get())?,
        };
        let Scene { scale, rotation, translation, .. } = opened.about.scene;
        let scene = match flags & OPEN_MODEL_COORDINATES {
            0 => Scene { scale, rotation, translation, name: None },
            _ => Scene::default(),
        };
        scene.similarity().validate()?;
        let mut table = Vec::new();
        if let (0, Some(occupancy)) = (flags & OPEN_WITHOUT_TABLE, &opened.model.occupancy) {
            table.resize(occupancy.table_len(), 0);
            occupancy.write_table(&mut table)?;
        }
        let memory = Memory { bytes, table: table.into() };
        let opened = Opened::try_new(memory, |memory| {
            let mut file = open(memory.bytes.get())?;
            if let Some(occupancy) = &mut file.model.occupancy
                && !memory.table.is_empty()
            {
                *occupancy = occupancy.with_table(&memory.table)?;
            }
            Ok::<_, Failure>(file)
        })?;
        Ok(Self { opened, scene })
    }
}

fn check_flags(flags: u32, known: u32) -> Result<(), Failure> {
    if flags & !known == 0 {
        return Ok(());
    }
    let text = format_args!("flags: {flags:#x}, expected bits of {known:#x}");
    Err(Failure::new(Status::Argument, text))
}

/// Writes the model's address, or null if there is none.
unsafe fn give(
    to: *mut *mut Model,
    open: impl FnOnce() -> Result<Model, Failure>,
) -> Result<(), Failure> {
    // SAFETY: the promise of the caller's caller.
    unsafe { border::write(to, std::ptr::null_mut(), "model")? };
    let model = Box::into_raw(Box::new(open()?));
    // SAFETY: as above.
    unsafe { border::write(to, model, "model") }
}

/// Opens a file. All of it is read, so it may change or be deleted afterwards.
///
/// `path` is UTF-8 on Windows, any bytes elsewhere. `flags` are `PNRF_OPEN_…`, or 0. `model`
/// receives the model, to be closed with `pnrf_close`, or null if the call fails.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_open_file(
    path: *const c_char,
    flags: u32,
    model: *mut *mut Model,
    error: *mut Error,
) -> Status {
    let work = || {
        let open = || {
            check_flags(flags, OPEN_UNVERIFIED | OPEN_WITHOUT_TABLE | OPEN_MODEL_COORDINATES)?;
            // SAFETY: a string of the caller's.
            let path = unsafe { CStr::from_ptr(border::read(path, "path")?) };
            let path = to_path(path)?;
            let named = |failure: Failure| {
                Failure::new(failure.status, format_args!("{}: {}", path.display(), failure.text))
            };
            read(&path).and_then(|bytes| Model::open(Bytes::Owned(bytes), flags)).map_err(named)
        };
        // SAFETY: the caller's promise.
        unsafe { give(model, open) }
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

#[cfg(unix)]
fn to_path(path: &CStr) -> Result<Cow<'_, Path>, Failure> {
    use std::os::unix::ffi::OsStrExt;
    Ok(Path::new(std::ffi::OsStr::from_bytes(path.to_bytes())).into())
}

#[cfg(not(unix))]
fn to_path(path: &CStr) -> Result<Cow<'_, Path>, Failure> {
    let text = path.to_str().map_err(|_| Failure::new(Status::File, "path: not UTF-8"))?;
    Ok(Path::new(text).into())
}

fn read(path: &Path) -> Result<Box<[u8]>, Failure> {
    let failed = |error: std::io::Error| Failure::new(Status::File, error);
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(failed)?;
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > MOST_BYTES {
        let text = format_args!("more than {MOST_BYTES} bytes, expected a model");
        return Err(Failure::new(Status::NotAModel, text));
    }
    Ok(bytes.into())
}

/// Opens a model in memory: `length` bytes, at any alignment. They are copied, unless `flags`
/// has `PNRF_OPEN_BORROWED`.
///
/// `flags` are `PNRF_OPEN_…`, or 0. `model` receives the model, to be closed with `pnrf_close`,
/// or null if the call fails.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_open_bytes(
    bytes: *const c_void,
    length: usize,
    flags: u32,
    model: *mut *mut Model,
    error: *mut Error,
) -> Status {
    let work = || {
        let open = || {
            let known = OPEN_UNVERIFIED | OPEN_WITHOUT_TABLE | OPEN_MODEL_COORDINATES;
            check_flags(flags, known | OPEN_BORROWED)?;
            // SAFETY: the caller's promise, for as long as the model is open.
            let bytes: &'static [u8] =
                unsafe { border::list(bytes.cast::<u8>(), length, "bytes")? };
            let bytes = match flags & OPEN_BORROWED {
                0 => Bytes::Owned(bytes.into()),
                _ => Bytes::Borrowed(bytes),
            };
            Model::open(bytes, flags)
        };
        // SAFETY: the caller's promise.
        unsafe { give(model, open) }
    };
    // SAFETY: the caller's promise.
    unsafe { call(error, work) }
}

/// Closes a model that is no longer in use. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pnrf_close(model: *mut Model) {
    if !model.is_null() {
        // SAFETY: it comes from `give`, and the caller closes it once.
        drop(unsafe { Box::from_raw(model) });
    }
}
