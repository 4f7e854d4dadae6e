//! `pocketnerf repack` and `pocketnerf unpack`.

use std::path::PathBuf;

use pocketnerf_formats::pack;
use pocketnerf_train::output;
use serde_json::json;

use super::model_file::ModelBytes;
use super::{Common, Failure, print_json, print_line, read_model};

/// A model file, and where its copy goes.
#[derive(Debug, clap::Args)]
pub(super) struct Repack {
    /// Model file
    input: PathBuf,
    /// Model file to write
    out: PathBuf,
}

impl Repack {
    /// Packs the model.
    pub(super) fn pack(&self, common: &Common) -> Result<(), Failure> {
        let bytes = self.read()?;
        let packed = pack(&bytes).map_err(|e| format!("{}: {e}", self.input.display()))?;
        self.write(&bytes, &packed, common)
    }

    /// Makes an ordinary file of it.
    pub(super) fn unpack(&self, common: &Common) -> Result<(), Failure> {
        let bytes = self.read()?;
        self.write(&bytes, &bytes, common)
    }

    fn read(&self) -> Result<ModelBytes, Failure> {
        output::check_output(&self.out)?;
        let bytes = read_model(&self.input)?;
        super::open(&self.input, &bytes)?;
        Ok(bytes)
    }

    fn write(&self, from: &ModelBytes, to: &[u8], common: &Common) -> Result<(), Failure> {
        output::write_atomic(&self.out, to)?;
        let (before, after) = (from.stored().len(), to.len());
        if common.json {
            let out = self.out.display().to_string();
            print_json(json!({ "bytes_before": before, "bytes": after, "out": out }), &[]);
        } else {
            print_line(format_args!("{}: {after} bytes, {before} before", self.out.display()));
        }
        Ok(())
    }
}
