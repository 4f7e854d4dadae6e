//! `pocketnerf info` of a dataset: its picture, and what training costs.

use crate::place::Place;

#[test]
fn a_picture_of_the_cameras_that_needs_nothing_else() {
    let place = Place::new();
    let object = place.ok("info data --picture cameras.svg --json");
    assert_eq!(object["picture"], "cameras.svg");
    let svg = String::from_utf8(place.bytes("cameras.svg")).unwrap();
    let count = |text: &str| svg.matches(text).count();
    // Twice, from above and from the side: 12 cameras of eight lines, the twelve edges of a box, a
    // cross of two lines, a length.
    assert_eq!((count("<title>"), count("<path ")), (2 * 12, 2 * (12 * 8 + 12 + 2 + 1)), "{svg}");
    assert_eq!((count("<g"), count("<svg"), count("</svg>")), (count("</g>"), 1, 1));
    assert!(count("<title>7</title>") == 2 && count("href") == 0 && count("url(") == 0, "{svg}");
    // Nothing is drawn outside of the picture.
    let numbers = svg.split(" d=\"M").skip(1).flat_map(|path| {
        let path = path.split('"').next().unwrap().replace('L', " ");
        path.split(' ').map(|n| n.parse::<f64>().unwrap()).collect::<Vec<_>>()
    });
    assert!(
        numbers.clone().all(|n| (0.0..=480.0).contains(&n)),
        "{:?}",
        numbers.collect::<Vec<_>>()
    );
    let line = place.line("info data/0.png --picture cameras.svg");
    assert!(line.starts_with("data/0.png: --picture is for datasets"), "{line}");
}

#[test]
fn what_training_costs_is_what_it_takes() {
    let place = Place::new();
    let cost = place.ok("info data --json")["cost"].clone();
    assert_eq!(cost["seconds"], 120.0);
    let trained = place.ok("train data --json --quiet --steps 3 --out x.pnerf");
    let expected = cost["memory_bytes"].as_f64().unwrap();
    if let Some(peak) = trained["peak_memory_bytes"].as_f64() {
        // A run of three steps does not touch all of it.
        assert!((1.0..2.0).contains(&(expected / peak)), "{expected} expected, {peak} taken");
    }
    // Of 25 pixels across: six planes of 32 x 32 entries of eight values, six lines, and networks
    // of 48, 64, 16 and 31, 128, 128, 3 values.
    let tables = 6 * 8 * (32 * 32 + 32);
    let networks = 49 * 64 + 65 * 16 + 32 * 128 + 129 * 128 + 129 * 3;
    assert_eq!(cost["model_bytes"], (0.35 * f64::from(tables + networks)) as u64);
    // Without alpha there is no box: a hash grid. Two minutes of the still life, lego, fern or fox
    // make 2.2 to 2.9 MB of one.
    for i in 0..12 {
        let file = place.path(&format!("data/{i}.png"));
        image::open(&file).unwrap().to_rgb8().save(&file).unwrap();
    }
    let cost = place.ok("info data --json")["cost"].clone();
    let bytes = cost["model_bytes"].as_f64().unwrap();
    assert!((2.2e6..2.9e6).contains(&bytes), "{bytes}");
}
