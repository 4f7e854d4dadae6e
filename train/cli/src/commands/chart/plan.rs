//! What is trained, checked before training starts.

use clap::{Parser, ValueEnum};
use pocketnerf_formats::Precision;
use pocketnerf_train::trainer::Length;

use super::Chart;
use crate::chart::{Recipe, plan};
use crate::commands::Common;
use crate::commands::Failure;
use crate::commands::train::{Method, Train};

/// Options that a recipe may not have, because the chart sets them.
const OURS: [&str; 8] = [
    "--out",
    "--resume",
    "--save-every",
    "--precision",
    "--threads",
    "--simd",
    "--json",
    "--quiet",
];

/// A command line of `pocketnerf train` without the word.
#[derive(Debug, Parser)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct Line {
    #[command(flatten)]
    train: Train,
    #[command(flatten)]
    _common: Common,
}

/// Methods that are compared.
#[derive(Clone, Copy, Debug)]
pub(super) enum Methods {
    All,
    One(Method),
}

pub(super) fn parse_methods(text: &str) -> Result<Methods, String> {
    if text == "all" {
        return Ok(Methods::All);
    }
    Method::from_str(text, false).map(Methods::One).map_err(|_| {
        let names: Vec<&str> = Method::value_variants().iter().map(|m| m.name()).collect();
        format!("expected all, or some of {}", names.join(", "))
    })
}

impl Chart {
    /// What is trained: what was given, nothing if models were given, or the sweep.
    pub(super) fn recipes(&self) -> Result<Vec<Recipe>, Failure> {
        let by_method = |methods: &Methods| {
            let all = Method::value_variants();
            let asked = all.iter().filter(|one| match methods {
                Methods::All => true,
                Methods::One(method) => method == *one,
            });
            asked
                .flat_map(|method| of_method(*method, self.quick, &self.seconds))
                .collect::<Vec<_>>()
        };
        let by_method: Vec<Recipe> = self.methods.iter().flat_map(by_method).collect();
        let mut recipes: Vec<Recipe> = match (&self.train[..], &self.models[..], self.quick) {
            _ if !by_method.is_empty() => by_method,
            ([], [], true) => plan::quick(),
            ([], [], false) => plan::full(),
            (given, ..) => given.iter().map(|options| Recipe::of(options)).collect(),
        };
        for recipe in &mut recipes {
            let precision = line(recipe)?.method(true).precision();
            if !self.precision.is_empty() {
                recipe.precisions.clone_from(&self.precision);
            } else if precision != Precision::I8 {
                recipe.precisions = vec![precision];
            }
        }
        for (i, recipe) in recipes.iter().enumerate() {
            if recipes[..i].iter().any(|other| other.name == recipe.name) {
                return Err(format!("--train {:?}: given twice", recipe.options.join(" ")).into());
            }
        }
        Ok(recipes)
    }
}

/// A method after so many seconds, usually after a minute and after five; or, as small as it is
/// useful, after a few.
fn of_method(method: Method, quick: bool, seconds: &[u32]) -> Vec<Recipe> {
    let usual: &[u32] = if quick { &[12] } else { &[60, 300] };
    let seconds = if seconds.is_empty() { usual } else { seconds };
    match quick {
        true => plan::of_method(method.small(), seconds),
        false => plan::of_method(&method.options(), seconds),
    }
}

/// The length of a recipe's run; refuses what `pocketnerf train` would.
pub(super) fn length(recipe: &Recipe) -> Result<Length, Failure> {
    Ok(line(recipe)?.length())
}

/// The baseline that a recipe trains, if it is one.
pub(super) fn baseline(recipe: &Recipe) -> Result<Option<pocketnerf_baselines::Method>, Failure> {
    Ok(line(recipe)?.baseline_method())
}

/// The command line of a recipe.
fn line(recipe: &Recipe) -> Result<Train, Failure> {
    let text = recipe.options.join(" ");
    let refused = |why: &str| format!("--train {text:?}: {why}");
    let is_ours = |option: &&String| OURS.iter().any(|ours| option.split('=').next() == Some(ours));
    if let Some(option) = recipe.options.iter().find(is_ours) {
        return Err(refused(&format!("{option}: leave it out, the chart says")).into());
    }
    let line = ["DATA", "--out", "m.pnerf"].into_iter().map(str::to_owned);
    let line = Line::try_parse_from(line.chain(recipe.options.iter().cloned()));
    let line = line.map_err(|error| {
        let text = error.to_string();
        let first = text.lines().next().unwrap_or_default();
        refused(first.strip_prefix("error: ").unwrap_or(first))
    })?;
    line.train.check().map_err(|error| refused(&error.to_string()))?;
    Ok(line.train)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recipes_are_checked_like_command_lines() {
        for recipe in plan::quick().iter().chain(&plan::full()) {
            assert!(matches!(length(recipe), Ok(Length::Seconds(_))), "{recipe:?}");
        }
        for method in Method::value_variants() {
            for recipe in [true, false].into_iter().flat_map(|quick| of_method(*method, quick, &[]))
            {
                assert!(matches!(length(&recipe), Ok(Length::Seconds(_))), "{recipe:?}");
            }
            let asked = of_method(*method, false, &[7, 9]);
            let seconds: Vec<_> = asked.iter().map(|recipe| length(recipe).unwrap()).collect();
            assert_eq!(seconds, [Length::Seconds(7.0), Length::Seconds(9.0)]);
        }
        let unknown = parse_methods("mpi").unwrap_err();
        assert_eq!(
            unknown,
            "expected all, or some of hash-grid, planes, plenoxels, nerf, derf, llff, srn, \
             neural-volumes"
        );
        let refused = |options: &str| length(&Recipe::of(options)).unwrap_err().to_string();
        assert_eq!(
            refused("--seconds 5 --precision f16"),
            "--train \"--seconds 5 --precision f16\": --precision: leave it out, the chart says"
        );
        assert!(refused("--out=x").ends_with("--out=x: leave it out, the chart says"));
        assert!(refused("--colour").contains("unexpected argument '--colour' found"));
        assert!(refused("--width 64").ends_with("--width: give --method nerf too"));
        assert_eq!(refused("--seconds x").lines().count(), 1);
        let steps = length(&Recipe::of("--steps 30")).unwrap();
        assert_eq!(steps, Length::Steps(30));
    }
}
