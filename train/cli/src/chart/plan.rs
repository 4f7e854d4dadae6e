//! What a chart trains: a sweep over what decides speed and accuracy.

use pocketnerf_formats::Precision;

/// A model to train.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Recipe {
    /// Its name in the chart.
    pub name: String,
    /// Options of `pocketnerf train`.
    pub options: Vec<String>,
    /// The formats of its weights, one model file each.
    pub precisions: Vec<Precision>,
}

impl Recipe {
    /// From the options as on a command line, which name it too; with tables of eight bits.
    #[must_use]
    pub fn of(options: &str) -> Self {
        let options: Vec<String> = options.split_whitespace().map(str::to_owned).collect();
        Self { name: name(&options), options, precisions: vec![Precision::I8] }
    }

    fn with(options: &str, precisions: &[Precision]) -> Self {
        Self { precisions: precisions.to_vec(), ..Self::of(options) }
    }
}

/// The options, shortened for a file name: `--method nerf --seconds 60` becomes
/// `nerf-60s`, `--log2-hashmap-size 15` becomes `T15`.
fn name(options: &[String]) -> String {
    let mut parts = Vec::new();
    let mut options = options.iter().map(String::as_str).peekable();
    while let Some(option) = options.next() {
        let value = options.next_if(|next| !next.starts_with("--")).unwrap_or_default();
        parts.push(match option {
            "--method" | "--profile" => value.to_owned(),
            "--seconds" => format!("{value}s"),
            "--log2-hashmap-size" => format!("T{value}"),
            "--n-levels" => format!("L{value}"),
            "--components" => format!("C{value}"),
            "--plane-resolution" => format!("R{value}"),
            "--hidden-width" | "--width" => format!("W{value}"),
            "--depth" => format!("D{value}"),
            _ => format!("{}{value}", option.trim_start_matches('-')),
        });
    }
    let fits = |c: char| if c.is_ascii_alphanumeric() || "-.".contains(c) { c } else { '_' };
    let name = parts.join("-").chars().map(fits).collect::<String>();
    if name.is_empty() { "default".to_owned() } else { name }
}

/// A first chart in less than five minutes, even on a half-busy machine.
#[must_use]
pub fn quick() -> Vec<Recipe> {
    vec![
        Recipe::of("--seconds 10 --log2-hashmap-size 11 --n-levels 5 --hidden-width 32"),
        Recipe::of("--seconds 12 --log2-hashmap-size 13 --n-levels 6 --hidden-width 32"),
        Recipe::of("--seconds 12 --method planes --plane-resolution 128"),
        Recipe::with("--seconds 25 --log2-hashmap-size 15", &[Precision::I8, Precision::F16]),
        Recipe::of("--seconds 12 --method nerf --depth 4 --width 64 --batch-rays 1024"),
        Recipe::of("--seconds 30 --method nerf --depth 4 --width 128 --batch-rays 1024"),
    ]
}

/// Models of a method after so many seconds each.
#[must_use]
pub fn of_method(options: &[&str], seconds: &[u32]) -> Vec<Recipe> {
    let options = options.join(" ");
    seconds.iter().map(|s| Recipe::of(&format!("{options} --seconds {s}"))).collect()
}

/// The whole sweep: time, precision and profile of what suits the scene; tables, levels and width
/// of hash grids; components and resolution of planes; vanilla NeRF in three sizes.
#[must_use]
pub fn full() -> Vec<Recipe> {
    use Precision::{F16, F32, I8};
    let mut all = vec![
        Recipe::of("--seconds 15"),
        Recipe::of("--seconds 30"),
        Recipe::with("--seconds 60", &[I8, F16, F32]),
        Recipe::of("--seconds 120"),
        Recipe::of("--seconds 300"),
        Recipe::of("--seconds 60 --profile fast"),
        Recipe::of("--seconds 300 --profile fast"),
    ];
    all.extend([60, 300].map(|s| Recipe::of(&format!("--seconds {s} --method hash-grid"))));
    all.push(Recipe::of("--seconds 300 --components 32"));
    all.push(Recipe::of("--seconds 60 --plane-resolution 160"));
    all.extend(
        [11, 13, 14, 15, 16, 18]
            .map(|n| Recipe::of(&format!("--seconds 60 --log2-hashmap-size {n}"))),
    );
    all.extend([4, 6, 12].map(|n| Recipe::of(&format!("--seconds 60 --n-levels {n}"))));
    all.extend([16, 32, 128].map(|n| Recipe::of(&format!("--seconds 60 --hidden-width {n}"))));
    let nerf = |seconds, depth, width| {
        Recipe::of(&format!(
            "--seconds {seconds} --method nerf --depth {depth} --width {width} --batch-rays 1024"
        ))
    };
    all.extend([nerf(60, 4, 64), nerf(120, 4, 128), nerf(300, 8, 256)]);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_file_names_and_differ() {
        assert_eq!(Recipe::of("").name, "default");
        let nerf = Recipe::of("--method nerf --depth 4 --width 128 --seconds 60 --no-hierarchy");
        assert_eq!(nerf.name, "nerf-D4-W128-60s-no-hierarchy");
        assert_eq!(Recipe::of("--aabb -1,-1,-1,1,1,1").name, "aabb-1_-1_-1_1_1_1");
        for plan in [quick(), full()] {
            let mut names: Vec<_> = plan.iter().map(|recipe| &recipe.name).collect();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), plan.len());
        }
    }
}
