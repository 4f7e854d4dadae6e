//! What is done already: a file in the folder that is prepared.

use std::path::{Path, PathBuf};

use pocketnerf_train::output;
use serde::{Deserialize, Serialize};

use crate::commands::{Failure, make_folder};

/// The file's name.
const FILE: &str = "prepare.json";

/// What is done already, and of what.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct State {
    /// What the dataset is made from, and how.
    pub(super) of: String,
    /// Names of the stages that are done.
    pub(super) done: Vec<String>,
    #[serde(skip)]
    folder: PathBuf,
}

impl State {
    /// Opens the folder of a dataset that is prepared: a new one, an empty one, or one in which the
    /// same was begun.
    pub(super) fn open(folder: &Path, of: String) -> Result<Self, Failure> {
        make_folder(folder)?;
        let file = folder.join(FILE);
        let shown = folder.display();
        if !file.is_file() {
            let mut entries = std::fs::read_dir(folder)
                .map_err(|error| format!("{shown}: cannot be listed: {error}"))?;
            if entries.next().is_some() {
                return Err(format!(
                    "{shown}: the folder is not empty, and `prepare` has not made what is in it; \
                     give a new folder"
                )
                .into());
            }
            let state = Self { of, done: Vec::new(), folder: folder.to_owned() };
            state.save()?;
            return Ok(state);
        }
        let read = std::fs::read_to_string(&file).map_err(|error| error.to_string());
        let state: Self = read
            .and_then(|text| serde_json::from_str(&text).map_err(|error| error.to_string()))
            .map_err(|error| {
                format!("{}: {error}; give a new folder, or empty this one", file.display())
            })?;
        if state.of != of {
            return Err(format!(
                "{shown}: was begun from other photographs or with other options ({}); give the \
                 same, or a new folder",
                pocketnerf_train::json::escape(&state.of)
            )
            .into());
        }
        Ok(Self { folder: folder.to_owned(), ..state })
    }

    /// A stage: its work, unless that is done already. Gives whether there was work.
    pub(super) fn stage(
        &mut self,
        name: &str,
        work: impl FnOnce() -> Result<(), Failure>,
    ) -> Result<bool, Failure> {
        if self.done.iter().any(|done| done == name) {
            return Ok(false);
        }
        work()?;
        self.done.push(name.to_owned());
        self.save()?;
        Ok(true)
    }

    fn save(&self) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(self)?;
        Ok(output::write_atomic(&self.folder.join(FILE), text.as_bytes())?)
    }
}
