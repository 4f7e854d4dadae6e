//! `pocketnerf train`: options that do not fit are said before training.

use crate::place::Place;

/// Part of the lines about boxes.
const BOX: &str = "its box";

/// What is said before the first step of a run on the still life, which is 1.7 units wide and
/// reaches from -0.7 to 0.95.
fn said(options: &str, about: &str) -> Vec<String> {
    let train = "train builtin --downscale-factor 8 --json --quiet --out x.pnerf";
    let result = Place::new().ok(&format!("{train} --steps 1 {options}"));
    let warnings = result["warnings"].as_array().unwrap().iter();
    let all = warnings.map(|line| line.as_str().unwrap().to_owned());
    all.filter(|line| line.contains(about)).collect()
}

#[test]
fn learning_rates_at_which_runs_stop_converging_are_said() {
    assert_eq!(said("--learning-rate 2", "--learning-rate"), [""; 0]);
    for times in ["4", "8"] {
        let found = said(&format!("--learning-rate {times}"), "--learning-rate");
        let expected = format!("{times}: runs may not converge");
        assert!(found.len() == 1 && found[0].contains(&expected), "{found:?}");
    }
}

#[test]
fn a_box_that_does_not_fit_is_said_before_training() {
    for options in ["", "--aabb=-1,-1,-1,1,1,1.1", "--aabb=-1.2,-1.2,-1.2,1.2,1.2,1.2"] {
        assert_eq!(said(options, BOX), [""; 0], "{options}");
    }
    let cut = said("--aabb=-1,-1,-1,0.7,1,1.1", BOX);
    assert!(cut.len() == 1 && cut[0].starts_with("the scene reaches beyond its box by"), "{cut:?}");
    // What is proposed fits.
    let box_found = cut[0].rsplit_once("give ").unwrap().1;
    assert_eq!(said(box_found, BOX), [""; 0], "{box_found}");
    let large = said("--aabb=-3,-3,-3,3,3,3", BOX);
    assert!(large.len() == 1 && large[0].starts_with("the scene fills "), "{large:?}");
}
