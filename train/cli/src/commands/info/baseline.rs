//! What is in the file of a baseline.

use std::path::Path;

use pocketnerf_baselines::{Baseline, Run};
use pocketnerf_train::trainer::Length;
use serde_json::{Value, json};

use super::table::grouped;
use crate::commands::{Common, Failure, print_line};

/// Shows a baseline, or a checkpoint of its run.
pub(super) fn show(path: &Path, bytes: &[u8], common: &Common) -> Result<(), Failure> {
    let value = match (Baseline::from_bytes(bytes), Run::read(bytes)) {
        (Ok(baseline), _) => of_baseline(&baseline, bytes.len()),
        (_, Ok(run)) => json!({
            "checkpoint": {
                "step": run.steps(),
                "steps": match run.length() {
                    Length::Steps(steps) => Some(steps),
                    Length::Seconds(_) => None,
                },
                "seconds": run.seconds(),
                "downscale_factor": run.origin().downscale_factor,
            },
            "method": run.method().name(),
            "bytes": bytes.len(),
            "trained_on": trained_on(run.origin(), run.steps()),
        }),
        (Err(why), Err(_)) => return Err(format!("{}: {why}", path.display()).into()),
    };
    if common.json {
        common.print_json(value, &[]);
        return Ok(());
    }
    let number = |key: &str| grouped(&value[key]);
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let row = |label: &str, text: String| print_line(format_args!("{label:<11} {text}"));
    let run = &value["checkpoint"];
    let kind = if run.is_null() { "baseline" } else { "checkpoint" };
    row(kind, format!("{}, {} bytes", path.display(), number("bytes")));
    row("method", text(&value["method"]));
    if run.is_null() {
        row("parameters", number("parameters"));
        row("PSNR", format!("{:.2} dB on training rays", value["metrics"]["train_psnr"]));
    } else {
        let end = if run["steps"].is_null() { "?".to_owned() } else { grouped(&run["steps"]) };
        let seconds = run["seconds"].as_f64().unwrap_or(0.0);
        row("run", format!("step {} of {end}, {seconds:.1} s", grouped(&run["step"])));
    }
    let trained = &value["trained_on"];
    let [name, fingerprint] = ["dataset", "fingerprint"].map(|key| text(&trained[key]));
    row("trained on", format!("{name}, fingerprint {fingerprint}"));
    row("trained for", format!("{} steps, seed {}", grouped(&trained["steps"]), trained["seed"]));
    Ok(())
}

fn of_baseline(baseline: &Baseline, bytes: usize) -> Value {
    json!({
        "checkpoint": null,
        "method": baseline.method().name(),
        "bytes": bytes,
        "parameters": baseline.parameters(),
        "aabb": baseline.space().bounds(),
        "photographs": baseline.origin().poses.len(),
        "trained_on": trained_on(baseline.origin(), baseline.steps()),
        "metrics": { "train_psnr": baseline.train_psnr() },
    })
}

fn trained_on(origin: &pocketnerf_baselines::Origin, steps: u32) -> Value {
    json!({
        "dataset": origin.dataset,
        "fingerprint": format!("{:016x}", origin.fingerprint),
        "seed": origin.seed,
        "steps": steps,
    })
}
