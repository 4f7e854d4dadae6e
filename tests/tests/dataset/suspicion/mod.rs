//! Datasets that load and are wrong all the same: each is named in one line, and sound ones in
//! none.

mod broken;
mod spoil;

use std::path::Path;

use pocketnerf_train::builtin::Scene;
use pocketnerf_train::dataset::{Split, inspect, load, write};

use broken::BROKEN;
use spoil::Data;

/// Writes a built-in scene at 100x100 pixels.
fn write_scene(scene: Scene, folder: &Path) {
    for split in [Split::Train, Split::Test] {
        write(folder, split, &scene.dataset(split, 4).views).unwrap();
    }
}

/// The lines about a dataset: why it is refused, or what is suspicious and noted.
fn lines(folder: &Path) -> Vec<String> {
    let report = match inspect(folder) {
        Err(refusal) => return vec![refusal.to_string()],
        Ok(report) => report,
    };
    let warnings = report.warnings();
    // People see the same lines.
    warnings
        .iter()
        .for_each(|line| assert!(report.to_string().contains(line.as_str()), "{report}"));
    warnings
}

#[test]
fn each_broken_dataset_is_named_in_one_line() {
    let scene = tempfile::tempdir().unwrap();
    write_scene(Scene::StillLife, scene.path());
    assert!(BROKEN.len() >= 25);
    let mut wrong = Vec::new();
    for (name, spoil, expected) in BROKEN {
        let data = Data::copy(scene.path());
        spoil(&data);
        let found = lines(data.path());
        println!("{name}: {}", found.join("\n    "));
        let is_named = found.len() == 1 && found[0].contains(expected) && !found[0].contains('\n');
        if !is_named {
            wrong.push(format!("{name}: expected {expected:?}, found {found:#?}"));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), BROKEN.len(), wrong.join("\n"));
}

#[test]
fn nothing_is_suspicious_about_built_in_scenes() {
    let mut wrong = Vec::new();
    for scene in Scene::ALL {
        let folder = tempfile::tempdir().unwrap();
        write_scene(scene, folder.path());
        assert!(load(folder.path(), Split::Train, 1).is_ok());
        let mut found = lines(folder.path());
        // Nor without the test views, though each photograph has fewer neighbours then.
        std::fs::remove_file(folder.path().join("transforms_test.json")).unwrap();
        std::fs::remove_dir_all(folder.path().join("test")).unwrap();
        found.extend(lines(folder.path()));
        if !found.is_empty() {
            wrong.push(format!("{}: {found:#?}", scene.name()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn nothing_is_suspicious_about_real_scenes() {
    let Some(data) = pocketnerf_tests::data() else { return };
    for scene in ["nerf_synthetic/lego", "llff/fern", "transforms/fox", "colmap/tumbler"] {
        let report = inspect(&data.join(scene)).unwrap();
        assert!(report.suspicions.is_empty(), "{scene}: {:#?}", report.suspicions);
    }
}
