//! The window: events in, pictures out.

mod app;
mod content;
pub mod input;
mod keyframes;
pub mod overlay;
pub mod script;
mod status;

use std::fmt;
use std::path::PathBuf;

use softbuffer::Context;
use winit::event_loop::{EventLoop, EventLoopProxy, OwnedDisplayHandle};

use crate::Failure;
use crate::show::Show;

use app::App;
pub use content::Content;
use input::Input;
use script::Line;
pub(crate) use status::KEYS;

/// The window at its start.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The model's name in the title.
    pub name: String,
    /// Width and height, pixels of the screen; the model's own if `None`.
    pub size: Option<[u32; 2]>,
    /// Whether figures are shown.
    pub overlay: bool,
    /// Folder of screenshots.
    pub screenshots: PathBuf,
    /// File of the camera path.
    pub camera_path: PathBuf,
    /// Start of the names of screenshots.
    pub stem: String,
    /// Input to play.
    pub script: Option<Vec<Line>>,
    /// Prints what has been saved, or why it has not.
    pub say: fn(&str),
}

/// There is no display.
#[derive(Debug)]
pub struct NoDisplay(String);

impl fmt::Display for NoDisplay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no window: {}; a display is needed", self.0)
    }
}

impl std::error::Error for NoDisplay {}

impl NoDisplay {
    fn new(reason: impl fmt::Display) -> Self {
        let text = reason.to_string().replace('\n', " ");
        // Before the reason are lines of winit's source.
        let reason = text.rsplit(": ").next().unwrap_or_default();
        Self(reason.trim_end_matches('.').to_owned())
    }
}

/// A display on which a window can be opened. It belongs to the main thread.
#[derive(Debug)]
pub struct Desktop {
    events: EventLoop<Input>,
    context: Context<OwnedDisplayHandle>,
}

impl Desktop {
    /// Finds the display.
    ///
    /// # Errors
    /// Why there is none.
    pub fn open() -> Result<Self, NoDisplay> {
        let events = EventLoop::with_user_event().build().map_err(NoDisplay::new)?;
        let context = Context::new(events.owned_display_handle()).map_err(NoDisplay::new)?;
        Ok(Self { events, context })
    }

    /// Sends input to its window from another thread.
    #[must_use]
    pub fn proxy(&self) -> EventLoopProxy<Input> {
        self.events.create_proxy()
    }

    /// Shows a window until it is closed, and gives back what it showed.
    ///
    /// # Errors
    /// One line: what the window system or the renderer reported.
    pub fn show<C: Content>(self, mut content: C, settings: Settings) -> Result<C, Failure> {
        if let Some(lines) = settings.script.clone() {
            content.figures().keep();
            let proxy = self.proxy();
            let send = move |input| proxy.send_event(input).is_ok();
            std::thread::spawn(move || script::play(&lines, send));
        }
        let mut app = App::new(content, settings, self.context);
        self.events.run_app(&mut app).map_err(NoDisplay::new)?;
        match app.failure {
            Some(failure) => Err(failure),
            None => Ok(app.content),
        }
    }
}

/// Shows a model in a window until it is closed; prints timings where a script was played.
///
/// # Errors
/// One line: no display, or what the window system or the renderer reported.
pub fn run(show: Show<'_>, settings: Settings) -> Result<(), Failure> {
    let is_scripted = settings.script.is_some();
    let show = Desktop::open()?.show(show, settings)?;
    if is_scripted {
        crate::say(&show.figures.json());
    }
    Ok(())
}
