//! The photographs of a run, as the dataset has them.

use pocketnerf_train::dataset::{Dataset, Split};
use pocketnerf_train::trainer::Length;

use super::{Bar, Train};
use crate::commands::{Common, Failure};

impl Train {
    /// Reads the training split; a new run of a certain time gives up where half of that passes.
    /// The user hears what is found; photographs that are there twice count once.
    pub(super) fn photographs(
        &self,
        is_new: bool,
        factor: u32,
        common: &Common,
        bar: &mut Bar,
    ) -> Result<Dataset, Failure> {
        bar.phase("reading the images");
        let mut dataset = match (is_new, self.length()) {
            (true, Length::Seconds(seconds)) => {
                let time = (common.started, seconds);
                self.reading.read_within(time, &self.data, Split::Train, factor)?
            }
            _ => self.reading.read(&self.data, Split::Train, factor)?,
        };
        dataset.notes.iter().for_each(|note| bar.note(note));
        let duplicates = dataset.leave_out_duplicates();
        if let Some(first) = duplicates.first() {
            bar.say(&format!(
                "{first}: the same photograph from the same place as another; it counts once ({} \
                 left out)",
                duplicates.len()
            ));
        }
        if let Some(views) = self.views {
            dataset.thin(views as usize);
        }
        Ok(dataset)
    }
}
