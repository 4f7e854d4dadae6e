//! Commands of the program, in Python's process.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use pocketnerf_cli::{Host, Refusal};
use pocketnerf_train::trainer::Progress;
use pyo3::exceptions::{PyKeyError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;

use crate::dataset::Dataset;
use crate::errors::{DatasetError, Error, Interrupted, with_checkpoint};
use crate::threads;

/// Between two looks at signals, which Python's own thread must take.
const LOOK: Duration = Duration::from_millis(50);
/// Between two reports of progress.
const TELL: Duration = Duration::from_millis(100);
/// Stands for the dataset in memory among arguments.
const DATASET: &str = "memory:";
/// As much stack as the main thread of a program has.
const STACK: usize = 8 << 20;

/// What a command says while it runs.
enum Event {
    Phase(String),
    Progress(Progress),
    Tasks(String, usize, usize),
    Warning(String),
}

/// The command's side.
struct Relay {
    events: Sender<Event>,
    stop: Arc<AtomicBool>,
    result: Mutex<Option<Value>>,
    told: Mutex<Option<Instant>>,
}

impl Relay {
    fn send(&self, event: Event) {
        // Nobody listens any more where Python has gone on.
        let _ = self.events.send(event);
    }

    /// Whether it is time to report again.
    fn is_time(&self) -> bool {
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        let is_time = told.is_none_or(|told| told.elapsed() >= TELL);
        if is_time {
            *told = Some(Instant::now());
        }
        is_time
    }
}

impl Host for Relay {
    fn phase(&self, what: &str) {
        self.send(Event::Phase(what.to_owned()));
    }

    fn progress(&self, progress: &Progress) {
        if self.is_time() || progress.steps == Some(progress.step) {
            self.send(Event::Progress(*progress));
        }
    }

    fn tasks(&self, what: &str, done: usize, all: usize) {
        if self.is_time() || done == all {
            self.send(Event::Tasks(what.to_owned(), done, all));
        }
    }

    fn warning(&self, warning: &str) {
        self.send(Event::Warning(warning.to_owned()));
    }

    fn result(&self, result: Value) {
        *self.result.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
    }

    fn is_asked_to_stop(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Python's side.
struct Listener<'a, 'py> {
    py: Python<'py>,
    events: Receiver<Event>,
    stop: &'a AtomicBool,
    on_event: Option<&'a Bound<'py, PyAny>>,
    /// Why the command was asked to stop.
    why: Option<PyErr>,
}

impl Listener<'_, '_> {
    /// Passes events on. Whether the command has ended: who asks twice does not wait for that.
    fn listen(&mut self) -> bool {
        loop {
            let events = &mut self.events;
            let event = self.py.detach(move || events.recv_timeout(LOOK));
            let told = match event {
                Ok(event) => self.tell(event),
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => return true,
            };
            if let Err(error) = told.and_then(|()| self.py.check_signals()) {
                let again = self.why.is_some();
                self.why.get_or_insert(error);
                self.stop.store(true, Ordering::Relaxed);
                if again {
                    return false;
                }
            }
        }
    }

    fn tell(&self, event: Event) -> PyResult<()> {
        let Some(on_event) = self.on_event.filter(|_| self.why.is_none()) else { return Ok(()) };
        let facts = PyDict::new(self.py);
        let kind = match event {
            Event::Phase(phase) => {
                facts.set_item("phase", phase)?;
                "phase"
            }
            Event::Progress(progress) => {
                facts.set_item("step", progress.step)?;
                facts.set_item("steps", progress.steps)?;
                facts.set_item("train_psnr", progress.train_psnr)?;
                facts.set_item("held_out_psnr", progress.held_out_psnr)?;
                facts.set_item("restarts", progress.restarts)?;
                "progress"
            }
            Event::Tasks(what, done, all) => {
                facts.set_item("phase", what)?;
                facts.set_item("step", done)?;
                facts.set_item("steps", all)?;
                "tasks"
            }
            Event::Warning(warning) => {
                facts.set_item("warning", warning)?;
                "warning"
            }
        };
        on_event.call1((kind, facts)).map(|_| ())
    }
}

/// Runs a command of the program in this process, and returns what `--json` prints.
#[pyfunction]
#[pyo3(signature = (arguments, dataset=None, on_event=None, threads=None))]
pub(crate) fn run<'py>(
    py: Python<'py>,
    arguments: Vec<String>,
    dataset: Option<&Bound<'py, Dataset>>,
    on_event: Option<&Bound<'py, PyAny>>,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let held = dataset.map(|dataset| pocketnerf_cli::hold(dataset.get().splits()));
    let place = held.as_ref().map(pocketnerf_cli::HeldDataset::path);
    let replaced = |argument: String| match &place {
        Some(place) if argument == DATASET => place.clone().into_os_string(),
        _ => argument.into(),
    };
    let arguments: Vec<_> = arguments.into_iter().map(replaced).collect();
    let (sender, events) = mpsc::channel();
    let stop = Arc::new(AtomicBool::new(false));
    let relay = Arc::new(Relay {
        events: sender,
        stop: Arc::clone(&stop),
        result: Mutex::default(),
        told: Mutex::default(),
    });
    let work = move || {
        // The listener ends when this thread drops the relay.
        let outcome = threads::beside(threads, || {
            let refusal = pocketnerf_cli::run_for(Arc::clone(&relay) as Arc<dyn Host>, arguments);
            refusal.map(|()| relay.result.lock().unwrap_or_else(PoisonError::into_inner).take())
        });
        drop((held, relay));
        outcome
    };
    let thread = thread::Builder::new().stack_size(STACK).spawn(work)?;
    let mut listener = Listener { py, events, stop: &stop, on_event, why: None };
    let has_ended = listener.listen();
    let why = listener.why.take();
    if let (Some(why), false) = (&why, has_ended) {
        return Err(why.clone_ref(py));
    }
    let outcome = py.detach(|| thread.join());
    let outcome = outcome.map_err(|_| PyRuntimeError::new_err("the command failed: a bug"))??;
    match (outcome, why) {
        (Err(Refusal::Interrupted { line, checkpoint }), why) => {
            let error = match why {
                // What a callback raised is what its caller wants to see.
                Some(error)
                    if !error.is_instance_of::<pyo3::exceptions::PyKeyboardInterrupt>(py) =>
                {
                    error
                }
                _ => Interrupted::new_err(interrupted(&line, checkpoint.as_deref())),
            };
            Err(with_checkpoint(py, error, checkpoint.as_deref()))
        }
        (_, Some(error)) => Err(error),
        (Err(refusal), None) => Err(refused(py, refusal)),
        (Ok(result), None) => {
            let text = result.unwrap_or(Value::Null).to_string();
            py.import("json")?.call_method1("loads", (text,))
        }
    }
}

/// The line of an interrupted run, with what to do in Python.
fn interrupted(line: &str, checkpoint: Option<&Path>) -> String {
    let what = line.split(';').next().unwrap_or(line);
    match checkpoint {
        Some(path) => {
            format!("{what}; resume with train(..., resume={:?})", path.display().to_string())
        }
        None => line.to_owned(),
    }
}

fn refused(py: Python<'_>, refusal: Refusal) -> PyErr {
    match refusal {
        Refusal::Usage(line) => PyValueError::new_err(line),
        Refusal::Dataset(line) => DatasetError::new_err(line),
        Refusal::Interrupted { line, .. } => Interrupted::new_err(line),
        Refusal::Failed { line, checkpoint } => {
            with_checkpoint(py, Error::new_err(line), checkpoint.as_deref())
        }
    }
}

/// Runs the program as the command line does; returns the exit status.
#[pyfunction]
pub(crate) fn main(py: Python<'_>, arguments: Vec<String>, program: Vec<String>) -> u8 {
    pocketnerf_cli::set_program(program.into_iter().map(Into::into).collect());
    let arguments = arguments.into_iter().map(Into::into).collect();
    py.detach(|| pocketnerf_cli::run_arguments(arguments, Instant::now()))
}

/// The long options of a command, and whether each takes no value, one, or several.
#[pyfunction]
pub(crate) fn options(command: &str) -> PyResult<HashMap<String, &'static str>> {
    let found = pocketnerf_cli::options(command);
    let found = found.ok_or_else(|| PyKeyError::new_err(command.to_owned()))?;
    Ok(found.into_iter().collect())
}
