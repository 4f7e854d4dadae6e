//! `pocketnerf train --refine-poses`.

use crate::place::{Place, TRAIN};

#[test]
fn corrections_are_told_and_belong_to_the_run() {
    let place = Place::new();
    let refined = "--steps 40 --refine-poses --save-every 0.000001";
    let result = place.ok(&format!("{TRAIN} {refined} --out whole.pnerf"));
    let cameras = result["refined_cameras"].as_array().unwrap();
    assert_eq!(cameras.len(), 12);
    for camera in cameras {
        // Four rows of four; axes stay at right angles and of length 1.
        let rows = camera["camera_to_world"].as_array().unwrap();
        let at = |row: usize, column: usize| rows[row][column].as_f64().unwrap();
        for (a, b) in [(0, 0), (0, 1), (1, 2), (2, 2)] {
            let dot: f64 = (0..3).map(|row| at(row, a) * at(row, b)).sum();
            assert!((dot - f64::from(u8::from(a == b))).abs() < 1e-5, "{rows:?}");
        }
        assert_eq!((0..4).map(|column| at(3, column)).collect::<Vec<_>>(), [0.0, 0.0, 0.0, 1.0]);
    }
    for figure in ["pose_corrections_degrees", "pose_corrections_shift"] {
        let [mean, max] = ["mean", "max"].map(|which| result[figure][which].as_f64().unwrap());
        assert!(0.0 < mean && mean <= max, "{figure}: {mean} {max}");
    }
    // A run that goes on refines as it did.
    let resume = "train data --json --quiet --resume whole.ckpt.pnerf";
    let again = place.ok(&format!("{resume} --refine-poses --out again.pnerf"));
    assert_eq!(again["refined_cameras"], result["refined_cameras"]);
    assert!(place.bytes("again.pnerf") == place.bytes("whole.pnerf"));

    let plain = place.ok(&format!("{TRAIN} --steps 40 --save-every 0.000001 --out plain.pnerf"));
    assert!(plain["refined_cameras"].is_null());
    assert!(place.bytes("plain.pnerf") != place.bytes("whole.pnerf"));
    let resume = resume.replace("whole", "plain");
    let line = place.line(&format!("{resume} --refine-poses --out x.pnerf"));
    assert!(line.contains("plain.ckpt.pnerf") && line.contains("--refine-poses"), "{line}");
}
