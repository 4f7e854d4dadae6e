//! The functions that a page calls. They take and return numbers; longer data is in memory
//! that the module owns, at an address that it returns.

#![allow(unsafe_code, reason = "exported names; nothing else here is unsafe")]

use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
#[cfg(not(target_family = "wasm"))]
use std::cell::RefCell;

use pocketnerf_core::SimdLevel;
use pocketnerf_core::render::RenderStats;

use crate::facts::{Facts, LENGTH};
use crate::gpu::Parts;
use crate::scene::{Scene, View};

#[cfg(target_family = "wasm")]
static INSTANCE: crate::runtime::Single<Instance> = crate::runtime::Single::new(Instance::new());
#[cfg(not(target_family = "wasm"))]
std::thread_local! {
    static INSTANCE: RefCell<Instance> = const { RefCell::new(Instance::new()) };
}

/// The state of an instance of the module.
struct Instance {
    input: Vec<u8>,
    scene: Option<Scene>,
    /// Until the instance is dropped.
    parts: Option<&'static Parts>,
    frame: [u32; 36],
    facts: [f32; LENGTH],
    /// A camera, from the page: pose (16), focal lengths, principal point.
    view: [f32; 20],
    /// Distance and position of a pick, or place and statistics of a tile.
    answer: [f32; 6],
    text: String,
}

impl Instance {
    const fn new() -> Self {
        Self {
            input: Vec::new(),
            scene: None,
            parts: None,
            frame: [0; 36],
            facts: [0.0; LENGTH],
            view: [0.0; 20],
            answer: [0.0; 6],
            text: String::new(),
        }
    }

    fn scene(&mut self) -> Result<&mut Scene, String> {
        self.scene.as_mut().ok_or_else(|| "no file is open".into())
    }

    fn view(&self, width: u32, height: u32) -> View {
        let mut pose = [0.0; 16];
        pose.copy_from_slice(&self.view[..16]);
        let [fx, fy, cx, cy] = [16, 17, 18, 19].map(|i| self.view[i]);
        View { width, height, focal: [fx, fy], center: [cx, cy], camera_to_world: pose }
    }

    fn open(&mut self) -> Result<u32, String> {
        if self.scene.is_some() {
            return Err("a file is open already: another file needs another instance".into());
        }
        // Until the instance is dropped.
        let bytes = core::mem::take(&mut self.input).leak();
        let scene = Scene::open(bytes, SimdLevel::compiled())?;
        let Facts(facts) = scene.facts();
        (self.facts, self.scene) = (facts, Some(scene));
        Ok(1)
    }

    /// The result of `work`, or 0 and a message.
    fn try_to<T: Default>(&mut self, work: impl FnOnce(&mut Self) -> Result<T, String>) -> T {
        // Freed first: see `runtime`.
        self.say(String::new());
        work(self).unwrap_or_else(|why| {
            self.say(why);
            T::default()
        })
    }

    // Once in the code.
    #[inline(never)]
    fn say(&mut self, text: String) {
        self.text = text;
    }
}

fn with<T>(work: impl FnOnce(&mut Instance) -> T) -> T {
    INSTANCE.with_borrow_mut(work)
}

/// Allocates room for a file of `length` bytes, and returns its address, or 0 if there is not
/// enough memory.
#[unsafe(no_mangle)]
pub extern "C" fn input(length: usize) -> *mut u8 {
    with(|instance| {
        let mut room = Vec::new();
        if room.try_reserve_exact(length).is_err() {
            instance.text = "not enough memory for a file of this size".into();
            return core::ptr::null_mut();
        }
        room.resize(length, 0);
        instance.input = room;
        instance.input.as_mut_ptr()
    })
}

/// Opens the file that was written there, once. Returns 1, or 0 and a [`message`].
#[unsafe(no_mangle)]
pub extern "C" fn open() -> u32 {
    with(|instance| instance.try_to(Instance::open))
}

/// Address of the [`Facts`].
#[unsafe(no_mangle)]
pub extern "C" fn facts() -> *const f32 {
    with(|instance| instance.facts.as_ptr())
}

/// Reads a [`Scene::text`], and returns its length; [`message`] is its address.
#[unsafe(no_mangle)]
pub extern "C" fn text(which: u32) -> usize {
    with(|instance| {
        instance.text = String::new();
        instance.text = instance.scene.as_ref().map_or("", |scene| scene.text(which)).into();
        instance.text.len()
    })
}

/// Address of the last text, in UTF-8: an error, or that of [`text`].
#[unsafe(no_mangle)]
pub extern "C" fn message() -> *const u8 {
    with(|instance| instance.text.as_ptr())
}

/// Length of that text, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn message_length() -> usize {
    with(|instance| instance.text.len())
}

/// Address of 20 numbers to which the page writes a camera: pose, row after row, focal lengths,
/// principal point, in the dataset's coordinates.
#[unsafe(no_mangle)]
pub extern "C" fn view() -> *mut f32 {
    with(|instance| instance.view.as_mut_ptr())
}

/// Starts the picture of that camera, and returns the number of its tiles, or 0 and a
/// [`message`].
#[unsafe(no_mangle)]
pub extern "C" fn begin(width: u32, height: u32, quality: f32) -> u32 {
    with(|instance| {
        let view = instance.view(width, height);
        instance.try_to(|instance| instance.scene()?.begin(&view, quality))
    })
}

/// Renders a tile of it, with depth unless that is 0, and returns the number of its bytes, or 0 and
/// a [`message`]. Its colours are then at [`colors`], and its depths, scene units, after those of
/// the largest tile.
#[unsafe(no_mangle)]
pub extern "C" fn tile(number: u32, with_depth: u32) -> usize {
    with(|instance| {
        instance.try_to(|instance| {
            let scene = instance.scene()?;
            let (tile, pixels) = scene.tile(number, with_depth != 0)?;
            let length = pixels.len();
            let RenderStats { rays, samples, .. } = scene.stats();
            let numbers = [tile.x, tile.y, tile.width, tile.height, rays as u32, samples as u32];
            instance.answer = numbers.map(|n| n as f32);
            Ok(length)
        })
    })
}

/// Address of the tile's bytes: red, green, blue and 255 for each pixel.
#[unsafe(no_mangle)]
pub extern "C" fn pixels() -> *const u8 {
    with(|instance| instance.scene.as_ref().map_or(core::ptr::null(), Scene::pixels))
}

/// Writes the program that renders the file on a GPU, and lays the model out for it, until the
/// instance is dropped. Returns 1, or 0 and a [`message`].
#[unsafe(no_mangle)]
pub extern "C" fn pack() -> u32 {
    with(|instance| {
        instance.try_to(|instance| {
            instance.parts = Some(Box::leak(Box::new(instance.scene()?.parts()?)));
            Ok(1)
        })
    })
}

/// Address of a part of that: 0 the program's text, in UTF-8, 1 to 3 the buffers of its first
/// group with these numbers.
#[unsafe(no_mangle)]
pub extern "C" fn part(which: u32) -> *const u8 {
    with(|instance| instance.parts.as_ref().map_or(core::ptr::null(), |parts| parts.part(which).0))
}

/// Length of a part, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn part_length(which: u32) -> usize {
    with(|instance| instance.parts.as_ref().map_or(0, |parts| parts.part(which).1))
}

/// Address of the 144 bytes of buffer 0, for the picture that was started. Words 29 and 30 are the
/// first row that is rendered and the number of rows.
#[unsafe(no_mangle)]
pub extern "C" fn frame() -> *const u32 {
    with(|instance| {
        instance.frame = instance.scene.as_ref().and_then(Scene::frame).unwrap_or([0; 36]);
        instance.frame.as_ptr()
    })
}

/// Address of the numbers to which the page writes colours that a GPU computed, those of a tile
/// at most, and where those of a [`tile`] are: premultiplied, in the model's colour space.
#[unsafe(no_mangle)]
pub extern "C" fn colors() -> *mut f32 {
    with(|instance| {
        instance.scene.as_mut().map_or(core::ptr::null_mut(), |scene| scene.colors().as_mut_ptr())
    })
}

/// Makes so many of them [`pixels`], and returns the number of their bytes.
#[unsafe(no_mangle)]
pub extern "C" fn show(count: usize) -> usize {
    with(|instance| instance.scene.as_mut().map_or(0, |scene| scene.show(count).len()))
}

/// The distance of what the camera in [`view`] sees at this point, infinite if there is
/// nothing, or -1 and a [`message`].
#[unsafe(no_mangle)]
pub extern "C" fn pick(width: u32, height: u32, x: f32, y: f32) -> f32 {
    with(|instance| {
        let view = instance.view(width, height);
        let found = instance.try_to(|instance| instance.scene()?.pick(&view, [x, y]).map(Some));
        instance.answer[..4].copy_from_slice(&found.unwrap_or([-1.0; 4]));
        instance.answer[0]
    })
}

/// Address of the result of [`pick`]: distance and position in the dataset's coordinates. After
/// [`tile`]: its leftmost column, topmost row, width and height, and how many rays and samples it
/// took.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const f32 {
    with(|instance| instance.answer.as_ptr())
}
