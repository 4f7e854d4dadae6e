//! The program `pocketnerf-view`, which `pocketnerf view` is too.

use std::borrow::Cow;
use std::path::Path;

#[cfg(feature = "gpu")]
use crate::options::Device;
use crate::options::Options;
use crate::output::Request;
use crate::paint::Painter;
use crate::show::Show;
use crate::view::View;
use crate::window::{self, NoDisplay, Settings, script};
use crate::{Failure, say};

/// The model that `pocketnerf demo --log2-hashmap-size 12` makes of the built-in scene.
const STILL_LIFE: &[u8] = include_bytes!("../../still-life.pnerf");

/// Shows a model as `options` say, on `threads` threads (0: one per core), until its window is
/// closed or its pictures are made.
///
/// # Errors
/// One line: what cannot be read, rendered, shown or written.
pub fn run(options: &Options, threads: usize) -> Result<(), Failure> {
    let (name, bytes) = match &options.model {
        Some(path) => (path.display().to_string(), Cow::Owned(read(path)?)),
        None => ("still life".to_owned(), Cow::Borrowed(STILL_LIFE)),
    };
    let refused = |e| format!("{name}: {e}; give a model that `pocketnerf info` can read");
    let bytes = pocketnerf_formats::unpacked(&bytes).map_err(refused)?;
    let file = pocketnerf_formats::open_verified(&bytes).map_err(refused)?;
    // The same pictures in less time, for some memory.
    let mut table = vec![0; file.model.table_len()];
    let model = file.model.with_table(&mut table)?;
    let view = View::new(&file);
    let quality = options.quality.or(file.about.quality).unwrap_or(0.5);
    let painter = Painter::new(&model, threads)?;
    #[cfg(feature = "gpu")]
    let painter = on_device(painter, options.device);
    let output = &options.output;
    if output.headless || output.out.is_some() || output.orbit.is_some() || output.terminal {
        let (default, terminal) = match output.orbit {
            Some(_) => ("orbit", None),
            None => ("view.png", output.terminal.then(|| output.width.unwrap_or(0))),
        };
        let request = Request {
            mode: options.mode,
            quality,
            size: options.size,
            orbit: output.orbit,
            terminal,
            out: output.out.clone().unwrap_or_else(|| default.into()),
        };
        say(request.run(&painter, &view)?.trim_end_matches('\n'));
        return Ok(());
    }
    let window = &options.window;
    let script = window.script.as_deref().map(script::read).transpose()?;
    let stem = options.model.as_deref().and_then(Path::file_stem);
    let settings = Settings {
        stem: stem.map_or_else(|| "still-life".to_owned(), |stem| stem.to_string_lossy().into()),
        name: stem.map_or(name, |stem| stem.to_string_lossy().into()),
        size: options.size,
        overlay: !window.no_overlay,
        screenshots: window.screenshots.clone(),
        camera_path: window.save_path.clone(),
        script,
        say,
    };
    let show = Show::new(painter, view, options.mode, quality, window.fps);
    window::run(show, settings).map_err(|failure| match failure.downcast::<NoDisplay>() {
        Ok(no_display) => {
            format!("{no_display}, or without one --headless --out FILE.png, or --terminal").into()
        }
        Err(failure) => failure,
    })
}

/// The same painter on a GPU, if one is wanted and there is one; else a warning says why not.
#[cfg(feature = "gpu")]
fn on_device(painter: Painter<'_>, device: Device) -> Painter<'_> {
    if device == Device::Cpu {
        return painter;
    }
    match pocketnerf_gpu::Gpu::open(pocketnerf_gpu::Software::from_environment()) {
        Ok(gpu) => painter.on(&gpu),
        Err(why) => {
            eprintln!("warning: {why}: pictures are rendered on the CPU");
            painter
        }
    }
}

fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let bytes = std::fs::read(path);
    Ok(bytes.map_err(|e| format!("{}: cannot be read: {e}; give a .pnerf file", path.display()))?)
}
