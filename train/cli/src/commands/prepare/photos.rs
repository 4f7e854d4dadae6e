//! The images of the dataset: photographs that are copied or linked.

use std::fs;
use std::path::Path;

use pocketnerf_train::json::escape;

use crate::commands::progress::Progress;
use crate::commands::stop::Stop;
use crate::commands::{Common, Failure};

/// Copies photographs to a folder, or links them.
pub(super) fn bring(
    (from, names): (&Path, &[String]),
    to: &Path,
    links: bool,
    common: &Common,
    stop: &Stop,
) -> Result<(), Failure> {
    fill(to, |part| {
        let what = if links { "linking photographs" } else { "copying photographs" };
        let mut progress = Progress::new(what, names.len(), common);
        for (i, name) in names.iter().enumerate() {
            stop.check()?;
            let (from, to) = (from.join(name), part.join(name));
            let brought = if links { fs::hard_link(&from, &to) } else { copy(&from, &to) };
            brought.map_err(|error| {
                let (from, to) = (from.display().to_string(), to.display().to_string());
                let hint = if links { "; leave --link out, which copies" } else { "" };
                let [from, to] = [escape(&from), escape(&to)];
                format!("{from}: cannot be brought to {to}: {error}{hint}")
            })?;
            progress.done(i + 1);
        }
        Ok(())
    })
}

fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    fs::copy(from, to).map(|_| ())
}

/// Fills a folder that is there afterwards, or not at all: what was half done before is done again.
pub(super) fn fill(
    to: &Path,
    work: impl FnOnce(&Path) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let part = to.with_extension("part");
    let failed = |path: &Path, error: std::io::Error| -> Failure {
        format!("{}: cannot be written: {error}", path.display()).into()
    };
    for path in [&part, to] {
        if path.exists() {
            fs::remove_dir_all(path).map_err(|error| failed(path, error))?;
        }
    }
    fs::create_dir_all(&part).map_err(|error| failed(&part, error))?;
    work(&part)?;
    fs::rename(&part, to).map_err(|error| failed(to, error))
}
