//! The model file of a run, as large as asked for.

use pocketnerf_formats::{open, unpacked};
use pocketnerf_train::compact::Compacted;
use pocketnerf_train::trainer::{HeldOutPsnr, Run, Size, Trainer};
use serde_json::{Value, json};

use super::Bar;
use crate::commands::Failure;

/// What a size that was asked for takes.
pub(super) struct Sized {
    /// What `train --json` prints of it.
    pub(super) facts: Value,
    /// How close the file comes to views that are still held out.
    pub(super) held_out: Option<HeldOutPsnr>,
}

/// The model file, as large as asked for, and what that takes, of which the user hears.
pub(super) fn sized(
    (trainer, run): (&Trainer, &Run),
    file: &[u8],
    bar: &mut Bar,
) -> Result<(Vec<u8>, Option<Sized>), Failure> {
    let Compacted { bytes, steps, network_steps, psnr, .. } = run.sized(trainer, file)?;
    let asked = match run.size() {
        Size::Whole => return Ok((bytes, None)),
        Size::Bytes(most) => format!("--max-bytes {most}"),
        Size::HeldOut(psnr) => format!("--target-psnr {psnr}"),
        Size::Near => "--auto".to_owned(),
    };
    let model = unpacked(&bytes)?;
    let held_out = trainer.held_out_psnr(&open(&model)?.model)?;
    let psnr_of_views = held_out.map(|found| found.mean);
    let list = |steps: &[u16]| steps.iter().map(u16::to_string).collect::<Vec<_>>().join(", ");
    let pictures = match psnr.is_finite() {
        true => format!("differ by {psnr:.1} dB from unrounded ones"),
        false => "are the same".to_owned(),
    };
    let mut said = match steps.iter().chain(&network_steps).any(|step| *step > 1) {
        true => format!(
            "tables are rounded to multiples of {}, networks to multiples \
             of {}; pictures {pictures}",
            list(&steps),
            list(&network_steps),
        ),
        false => "nothing had to be rounded".to_owned(),
    };
    if let Some(found) = psnr_of_views {
        said += &format!("; held-out views have {found:.2} dB");
    }
    bar.say(&format!("{asked}: {} bytes; {said}", bytes.len()));
    if let (Size::HeldOut(least), Some(found)) = (run.size(), psnr_of_views)
        && found < least
    {
        bar.warn(format!(
            "{asked}: not reached, {found:.2} dB on held-out views is the best; train longer or \
             with more entries (--log2-hashmap-size, --plane-resolution)"
        ));
    }
    let facts = json!({
        "asked": asked,
        "steps": steps,
        "network_steps": network_steps,
        "psnr_to_whole": psnr.is_finite().then_some(psnr),
    });
    Ok((bytes, Some(Sized { facts, held_out })))
}
