//! What is in a model file, as a table for people.

use std::fmt::Write as _;

use pocketnerf_train::json::escape;
use serde_json::Value;

/// The table of the values that `info --json` prints.
pub(super) fn table(path: &str, value: &Value) -> String {
    let mut table = String::new();
    let mut row = |label: &str, text: String| _ = writeln!(table, "{label:<11} {text}");
    let kind = if value["checkpoint"].is_null() { "model" } else { "checkpoint" };
    let unpacked = match value["bytes"] == value["unpacked_bytes"] {
        true => String::new(),
        false => format!(", {} unpacked", grouped(&value["unpacked_bytes"])),
    };
    row(kind, format!("{path}, {} bytes{unpacked}", grouped(&value["bytes"])));
    row("method", plain(&value["method"]));
    let [parameters, precision] = [grouped(&value["parameters"]), plain(&value["precision"])];
    row("parameters", format!("{parameters}, in {precision}"));
    for (name, network) in
        ["coarse", "fine"].map(|name| (name, &value["networks"][name])).into_iter().rev()
    {
        if !network.is_null() {
            row(name, layers(network));
        }
    }
    let sampling = &value["paper_sampling"];
    if !sampling.is_null() {
        let [coarse, fine] = [&sampling["n_coarse"], &sampling["n_fine"]];
        row("sampling", format!("{coarse} coarse and {fine} fine samples per ray"));
    }
    row("space", space(value));
    if let Some(up) = value["world"]["up"].as_array() {
        let up: Vec<String> =
            up.iter().filter_map(Value::as_f64).map(|v| format!("{v:.3}")).collect();
        row("up", format!("{} in the dataset's coordinates", up.join(", ")));
    }
    if let Some(metres) = value["world"]["metres"].as_f64() {
        row("unit", format!("{metres} metres"));
    }
    let percent = |fraction: &Value| fraction.as_f64().map(|f| format!("{:.2} %", 100.0 * f));
    row("occupied", percent(&value["occupancy_fraction"]).unwrap_or_else(|| "all".to_owned()));
    if !value["quality"].is_null() {
        row("quality", format!("{} by default", value["quality"]));
    }
    let trained = &value["trained_on"];
    if !trained.is_null() {
        let name = |key: &str| plain(&trained[key]);
        row("trained on", format!("{}, fingerprint {}", name("dataset"), name("fingerprint")));
        let (steps, seed) = (grouped(&trained["steps"]), &trained["seed"]);
        if let Some(n) = value["photographs"].as_u64() {
            row("photographs", format!("the cameras of {n} are stored"));
        }
        row("trained by", format!("{}: {steps} steps, seed {seed}", name("program")));
    }
    if let Some(psnr) = value["metrics"]["train_psnr"].as_f64() {
        row("PSNR", format!("{psnr:.2} dB on training rays"));
    }
    let run = &value["checkpoint"];
    if !run.is_null() {
        let seconds = run["seconds"].as_f64().unwrap_or(0.0);
        let end = if run["steps"].is_null() { "?".to_owned() } else { grouped(&run["steps"]) };
        let (step, restarts) = (grouped(&run["step"]), &run["restarts"]);
        row("run", format!("step {step} of {end}, {seconds:.1} s, {restarts} restarts"));
        row("images", format!("downscaled by {}", run["downscale_factor"]));
    }
    let sections = value["sections"].as_array().map_or(&[][..], Vec::as_slice);
    for (i, section) in sections.iter().enumerate() {
        let label = if i == 0 { "sections" } else { "" };
        let name = format!("{} {}", plain(&section["kind"]), section["index"]);
        row(label, format!("{name:<14} {:>12} bytes", grouped(&section["bytes"])));
    }
    table
}

/// Depth and widths of a network.
fn layers(network: &Value) -> String {
    let [trunk, color] = [&network["widths"], &network["color"]].map(|widths| {
        let widths = widths.as_array().map_or(&[][..], Vec::as_slice);
        widths.iter().map(Value::to_string).collect::<Vec<_>>().join(", ")
    });
    format!("layers of {trunk}; colour: {color}; {} parameters", grouped(&network["parameters"]))
}

fn space(value: &Value) -> String {
    let ndc = &value["space"]["ndc"];
    if !ndc.is_null() {
        let near = ndc["near"].as_f64().unwrap_or(f64::NAN);
        return format!("normalised device coordinates beyond z = {:.3}", -near);
    }
    let contracted = &value["space"]["contracted"];
    if !contracted.is_null() {
        let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
        let [x, y, z] = [0, 1, 2].map(|a| number(&contracted["center"][a]));
        let radius = number(&contracted["radius"]);
        return format!("contracted beyond {radius:.3} from ({x:.3}, {y:.3}, {z:.3})");
    }
    let corner = |i: usize| {
        let of = |a: usize| value["aabb"][i][a].as_f64().unwrap_or(f64::NAN);
        format!("({:.3}, {:.3}, {:.3})", of(0), of(1), of(2))
    };
    format!("box from {} to {}", corner(0), corner(1))
}

/// Text without its quotes, on one line.
fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), escape)
}

/// A number with its thousands apart: `1,234,567`.
pub(super) fn grouped(value: &Value) -> String {
    let digits = value.to_string();
    let groups: Vec<&str> = digits
        .as_bytes()
        .rchunks(3)
        .rev()
        .map(|group| std::str::from_utf8(group).unwrap_or_default())
        .collect();
    groups.join(",")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_row_for_everything_that_is_there() {
        let value = json!({
            "checkpoint": null, "method": "hash-grid", "bytes": 1_234_567, "unpacked_bytes": 2_000_000, "parameters": 999,
            "networks": null, "paper_sampling": null, "precision": "i8 tables, f16 networks",
            "sections": [{"kind": "META", "index": 0, "bytes": 1000}],
            "space": "box", "aabb": [[-1.0, -1.0, -1.0], [1.0, 2.0, 3.5]], "tolerance": 0.1,
            "quality": null, "occupancy_fraction": 0.0625,
            "trained_on": {"dataset": "lego", "fingerprint": "00ff", "seed": 3, "steps": 2000,
                "program": "pocketnerf 0.1.0"},
            "metrics": {"train_psnr": 31.456},
        });
        let expected = "\
model       m.pnerf, 1,234,567 bytes, 2,000,000 unpacked
method      hash-grid
parameters  999, in i8 tables, f16 networks
space       box from (-1.000, -1.000, -1.000) to (1.000, 2.000, 3.500)
occupied    6.25 %
trained on  lego, fingerprint 00ff
trained by  pocketnerf 0.1.0: 2,000 steps, seed 3
PSNR        31.46 dB on training rays
sections    META 0                1,000 bytes
";
        assert_eq!(table("m.pnerf", &value), expected);
    }
}
