//! Other programs: found, run, logged and stopped.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::mpsc::{Sender, channel};
use std::thread;

use crate::commands::Failure;
use crate::commands::stop::{Interrupted, Stop};

/// A program that is used where it is installed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tool {
    pub(super) name: &'static str,
    /// How to get it.
    install: &'static str,
}

pub(super) const COLMAP: Tool = Tool {
    name: "colmap",
    install: "Debian and Ubuntu: `apt install colmap`; macOS: `brew install colmap`; Windows: \
              colmap.github.io/install.html",
};
pub(super) const FFMPEG: Tool = Tool { name: "ffmpeg", install: FFMPEG_INSTALL };
pub(super) const FFPROBE: Tool = Tool { name: "ffprobe", install: FFMPEG_INSTALL };
const FFMPEG_INSTALL: &str = "Debian and Ubuntu: `apt install ffmpeg`; macOS: `brew install \
                              ffmpeg`; Windows: `winget install ffmpeg`";

/// Runs programs, and keeps what they say in a log.
pub(super) struct Runner<'a> {
    pub(super) log: PathBuf,
    pub(super) stop: &'a Stop,
}

impl Tool {
    /// What the program says when it is asked something quick.
    pub(super) fn ask(self, arguments: &[&str]) -> Result<String, Failure> {
        let asked = Command::new(self.name).args(arguments).stdin(Stdio::null()).output();
        let output = asked.map_err(|error| self.missing(&error))?;
        let [out, err] = [&output.stdout, &output.stderr].map(|b| String::from_utf8_lossy(b));
        Ok(format!("{out}{err}"))
    }

    pub(super) fn missing(self, error: &std::io::Error) -> Failure {
        let Self { name, install } = self;
        match error.kind() {
            std::io::ErrorKind::NotFound => format!("{name} is not installed; {install}").into(),
            _ => format!("{name} cannot be run: {error}").into(),
        }
    }
}

impl Runner<'_> {
    /// Runs a program to its end, and gives each line that it says to `hear`.
    ///
    /// # Errors
    /// It is missing, fails, or is interrupted.
    pub(super) fn run(
        &self,
        tool: Tool,
        arguments: &[String],
        mut hear: impl FnMut(&str),
    ) -> Result<(), Failure> {
        self.stop.check()?;
        let mut log = File::options()
            .append(true)
            .create(true)
            .open(&self.log)
            .map_err(|error| format!("{}: cannot be written: {error}", self.log.display()))?;
        // A log that cannot be written to is no reason to stop.
        let _ = writeln!(log, "\n$ {} {}", tool.name, arguments.join(" "));
        let mut child = Command::new(tool.name)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| tool.missing(&error))?;
        self.stop.child(Some(&child));
        let (sender, receiver) = channel();
        let readers =
            [child.stdout.take().map(boxed), child.stderr.take().map(boxed)].map(|stream| {
                let sender = sender.clone();
                stream.map(|stream| thread::spawn(move || pass_lines(stream, &sender)))
            });
        drop(sender);
        let mut problem = String::new();
        for line in receiver {
            let _ = writeln!(log, "{line}");
            hear(&line);
            let line = line.trim();
            // The first that says so, else the last.
            let says_so = |text: &str| text.to_lowercase().contains("error");
            if !line.is_empty() && !says_so(&problem) {
                line.clone_into(&mut problem);
            }
        }
        for reader in readers.into_iter().flatten() {
            let _ = reader.join();
        }
        let status = child.wait();
        self.stop.child(None);
        if self.stop.is_asked() {
            return Err(Interrupted.into());
        }
        let status = status.map_err(|error| format!("{}: {error}", tool.name))?;
        if status.success() {
            return Ok(());
        }
        let what = arguments.first().filter(|first| !first.starts_with('-'));
        let what = what.map_or_else(String::new, |what| format!(" {what}"));
        Err(format!(
            "{}{what} failed ({status}): {}; what it said is in {}",
            tool.name,
            pocketnerf_train::json::escape(&problem),
            self.log.display()
        )
        .into())
    }
}

fn boxed(stream: impl Read + Send + 'static) -> Box<dyn Read + Send> {
    Box::new(stream)
}

fn pass_lines(stream: Box<dyn Read + Send>, sender: &Sender<String>) {
    let mut reader = BufReader::new(stream);
    let mut line = Vec::new();
    // Lines need not be UTF-8.
    while reader.read_until(b'\n', &mut line).is_ok_and(|n| n > 0) {
        let text = String::from_utf8_lossy(&line).trim_end().to_owned();
        if sender.send(text).is_err() {
            return;
        }
        line.clear();
    }
}
