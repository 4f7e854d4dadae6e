//! `pocketnerf train --view`: whoever watches the scene appear.

use std::path::{Path, PathBuf};
use std::thread;
use std::time::Instant;

use pocketnerf_train::trainer::{Run, Trainer};
use pocketnerf_view::live::{Feed, terminal, window};
use pocketnerf_view::window::{Desktop, NoDisplay, Settings, script};

use super::bar::{Line, Screen};
use super::{Bar, Origin};
use crate::commands::{Common, Failure};

/// As much as main threads have.
const STACK: usize = 8 << 20;

/// Where the scene is watched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Place {
    Window,
    Terminal,
}

#[derive(Clone, Debug, clap::Args)]
pub(in crate::commands) struct WatchOptions {
    /// Watch the scene appear: --view opens a window, --view=terminal prints pictures
    ///
    /// Mouse and keys of the window are those of `pocketnerf view`. Closing it lets training go on;
    /// after training it stays open with the finished model. In the terminal, pictures of 24-bit
    /// colours turn slowly, and the last one stays. Without a display, --view prints pictures, too.
    /// Training takes the same steps and gives the same model; painting takes about a twentieth of
    /// the processor's time.
    #[arg(long, value_enum, value_name = "PLACE", num_args = 0..=1, require_equals = true,
        default_missing_value = "window")]
    view: Option<Place>,
    /// Input of the window, to measure what watching costs, as `view --script` takes it
    #[arg(long, value_name = "FILE", hide = true, requires = "view")]
    view_script: Option<PathBuf>,
}

impl WatchOptions {
    /// Whether somebody is to watch.
    pub(super) fn is_asked(&self) -> bool {
        self.view.is_some()
    }

    /// Trains before an audience, if one is wanted: on another thread, because windows belong to
    /// the main one.
    pub(super) fn attend(
        &self,
        out: &Path,
        train: impl FnOnce(Audience) -> Result<(), Failure> + Send,
    ) -> Result<(), Failure> {
        let Some(place) = self.view else { return train(Audience(None)) };
        let script = self.view_script.as_deref().map(script::read).transpose()?;
        let desktop = match place {
            Place::Window => desktop()?,
            Place::Terminal if is_terminal() => None,
            Place::Terminal => {
                return Err("--view=terminal: standard error is no terminal; leave it out".into());
            }
        };
        let feed = Feed::default();
        let in_terminal = desktop.is_none();
        let audience = Audience(Some(Watched { feed: feed.clone(), in_terminal, said: false }));
        let name = out.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let settings = Settings {
            stem: name.clone(),
            name,
            size: None,
            overlay: true,
            screenshots: ".".into(),
            camera_path: "camera_path.json".into(),
            script,
            // Standard output has the result alone.
            say: |line| eprintln!("{line}"),
        };
        let cores = rayon::current_num_threads();
        thread::scope(|scope| {
            let training = thread::Builder::new().stack_size(STACK);
            let training = training.spawn_scoped(scope, || train(audience))?;
            let is_scripted = settings.script.is_some();
            let watched = match desktop {
                Some(desktop) => window::run(&feed, desktop, cores, settings).map(|figures| {
                    if is_scripted {
                        eprintln!("{}", figures.json());
                    }
                }),
                None => terminal::run(&feed, cores),
            };
            feed.leave();
            if let Err(why) = watched {
                eprintln!("warning: --view: {why}; training goes on");
            }
            training.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    }
}

/// The display; `None` without one, where a terminal takes its place.
fn desktop() -> Result<Option<Desktop>, Failure> {
    match Desktop::open() {
        Ok(desktop) => Ok(Some(desktop)),
        Err(why) if is_terminal() => {
            eprintln!("{why}: pictures are printed here, as by --view=terminal");
            Ok(None)
        }
        Err(why) => Err(refusal(&why).into()),
    }
}

fn refusal(why: &NoDisplay) -> String {
    format!("--view: {why}, or a terminal for --view=terminal; leave it out")
}

fn is_terminal() -> bool {
    std::io::IsTerminal::is_terminal(&std::io::stderr())
}

/// Who watches a run.
pub(super) struct Audience(Option<Watched>);

struct Watched {
    feed: Feed,
    in_terminal: bool,
    /// Whether the user knows that nobody watches any more.
    said: bool,
}

impl Audience {
    /// The progress of the run, which the audience sees too.
    pub(super) fn bar(&self, common: &Common) -> Bar {
        let Some(Watched { feed, in_terminal, .. }) = &self.0 else { return Bar::new(common) };
        let (told, said) = (feed.clone(), feed.clone());
        let line = move |line: &str| match said.is_left() {
            true => eprintln!("{line}"),
            false => said.say(line),
        };
        Bar::beside(
            common,
            Screen {
                status: Box::new(move |status| told.tell(status)),
                line: in_terminal.then(|| Box::new(line) as Line),
            },
        )
    }

    /// Shows the model as it stands, where the audience has seen the one before.
    pub(super) fn after_step(&mut self, trainer: &Trainer, run: &Run, origin: &Origin, bar: &Bar) {
        let Some(Watched { feed, in_terminal, said }) = &mut self.0 else { return };
        if feed.is_wanted() {
            let begun = Instant::now();
            let bytes = trainer.snapshot(&origin.about(trainer, run));
            // What cannot be written makes the run restart.
            feed.give(bytes.ok(), begun.elapsed());
        } else if feed.is_left() && !std::mem::replace(said, true) && !*in_terminal {
            bar.say("the window is closed; training goes on");
        }
    }

    /// Shows the finished model's file; in a terminal, waits until it is seen.
    pub(super) fn finish(&self, out: &Path) {
        let Some(Watched { feed, in_terminal, .. }) = &self.0 else { return };
        feed.tell("trained");
        // Whoever removes the file at once sees the model before.
        if let Ok(bytes) = std::fs::read(out) {
            feed.finish(bytes);
        }
        if *in_terminal {
            feed.end();
            feed.wait_until_left();
        }
    }

    /// Whether the program goes on after training.
    pub(super) fn stays(&self) -> bool {
        self.0.as_ref().is_some_and(|watched| !watched.feed.is_left())
    }
}

impl Drop for Audience {
    fn drop(&mut self) {
        if let Some(Watched { feed, .. }) = &self.0 {
            feed.end();
        }
    }
}
