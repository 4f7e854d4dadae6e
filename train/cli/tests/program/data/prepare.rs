//! `pocketnerf prepare`, with programs that act as COLMAP and ffmpeg.

use std::process::Command;

use pocketnerf_train::picture::image_file;
use serde_json::Value;

use super::shop::{COLMAP, FFMPEG, FFPROBE, Shop};
use crate::place::text;

const ALL: [&str; 3] = ["feature_extractor", "exhaustive_matcher", "mapper"];

#[test]
fn photographs_become_a_dataset_in_stages_that_run_once() {
    let shop = Shop::new(&[("colmap", COLMAP)]);
    let result = shop.ok("prepare photos --out set --json --quiet");
    assert_eq!(shop.calls(), ALL);
    // One camera of images of one size, on the CPU.
    let calls = std::fs::read_to_string(shop.place.path("calls")).unwrap();
    assert!(calls.contains("--ImageReader.single_camera 1 --SiftExtraction.use_gpu 0"), "{calls}");
    let of = |key: &str| result[key].clone();
    assert_eq!(
        [of("photographs"), of("registered"), of("models")],
        [6, 5, 2].map(Value::from),
        "{result}"
    );
    assert_eq!(of("brought"), "copied");
    let warning = "only 5 of 6 photographs are registered, expected nearly all";
    assert!(result["warnings"][0].as_str().unwrap().starts_with(warning), "{result}");
    // It can be loaded, and nothing is done twice.
    assert_eq!(shop.ok("info set --json")["splits"][0]["images_found"], 4);
    let again = shop.run("prepare photos --out set", &[]);
    assert_eq!(shop.calls().len(), 3);
    let said = text(&again.stderr);
    assert_eq!(said.matches("done before").count(), 4, "{said}");
    let said = text(&again.stdout);
    let expected = "set: 6 photographs, 5 registered, in the largest of 2 models; next: \
                    pocketnerf train set --out set.pnerf\n";
    assert_eq!(said, expected);
}

#[test]
fn a_stage_that_fails_is_done_again_and_no_other() {
    let shop = Shop::new(&[("colmap", COLMAP)]);
    let prepare = "prepare photos --out set --quiet --json";
    for stage in ALL {
        let line = shop.line(prepare, &[("FAIL", stage)]);
        let expected = format!(
            "colmap {stage} failed (exit status: 3): ERROR: no more disk; what it said is in \
             set/prepare.log"
        );
        assert_eq!(line, expected);
    }
    let line = shop.line(prepare, &[("NONE", "1")]);
    assert!(line.starts_with("photos: COLMAP has found no cameras: photographs overlap"), "{line}");
    shop.ok(prepare);
    // Each until it had worked.
    let [features, matches, cameras] = ALL;
    let expected = [features, features, matches, matches, cameras, cameras, cameras];
    assert_eq!(shop.calls(), expected);
    let log = std::fs::read_to_string(shop.place.path("set/prepare.log")).unwrap();
    assert!(log.contains("$ colmap mapper") && log.contains("ERROR: no more disk"), "{log}");
}

#[test]
fn ctrl_c_leaves_what_is_done_and_says_how_to_go_on() {
    let shop = Shop::new(&[("colmap", COLMAP)]);
    let slow = shop.place.path("slow");
    let mut child = shop
        .command("prepare photos --out set --quiet")
        .env("SLOW", &slow)
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    while !slow.exists() {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let mut said = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut said).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(said, "pocketnerf: interrupted; run the same command again to continue\n");
    assert_eq!(std::fs::read_dir(shop.place.path("set/images")).unwrap().count(), 6);
    std::fs::remove_file(shop.place.path("calls")).unwrap();
    let result = shop.ok("prepare photos --out set --quiet --json");
    assert_eq!(shop.calls(), ALL);
    let was_done = |i: usize| result["stages"][i]["was_done"].clone();
    assert_eq!([0, 1, 2, 3].map(was_done), [true, false, false, false].map(Value::from));
}

#[test]
fn frames_of_a_video_the_sharpest_of_three() {
    let programs = [("colmap", COLMAP), ("ffmpeg", FFMPEG), ("ffprobe", FFPROBE)];
    let shop = Shop::new(&programs);
    std::fs::write(shop.place.path("walk.mp4"), "a video").unwrap();
    // Six candidates for two frames: three of one picture and three of another. The second and the
    // last are as they were, the others blurred.
    for (i, of) in [(0, 1), (2, 1), (3, 5), (4, 5)] {
        let picture = image_file::open(shop.place.path(&format!("photos/{of}.png"))).unwrap();
        picture.blur(2.0).save(shop.place.path(&format!("photos/{i}.png"))).unwrap();
    }
    let result = shop.ok("prepare walk.mp4 --frames 2 --out set --quiet --json");
    assert_eq!((&result["photographs"], &result["brought"]), (&2.into(), &"taken".into()));
    for (frame, of) in [(1, 1), (2, 5)] {
        let name = format!("set/images/{frame:05}.jpg");
        assert_eq!(
            shop.place.bytes(&name),
            shop.place.bytes(&format!("photos/{of}.png")),
            "{name}"
        );
    }
    assert_eq!(std::fs::read_dir(shop.place.path("set/images")).unwrap().count(), 2);
    // Four seconds: three candidates for each of two frames are 1.5 a second.
    let calls = std::fs::read_to_string(shop.place.path("calls")).unwrap();
    assert!(calls.starts_with("ffmpeg ") && calls.contains("fps=1.500000"), "{calls}");
}

#[test]
fn what_cannot_be_prepared_is_refused_in_a_line() {
    let shop = Shop::new(&[("colmap", COLMAP)]);
    let write = |name: &str, bytes: &[u8]| std::fs::write(shop.place.path(name), bytes).unwrap();
    write("photos.zip", b"PK\x03\x04...");
    write("walk.mov", b"...");
    write("notes.txt", b"...");
    std::fs::create_dir(shop.place.path("empty")).unwrap();
    std::fs::create_dir(shop.place.path("mine")).unwrap();
    write("mine/thesis.txt", b"...");
    for (options, expected) in [
        (
            "photos.zip --out a",
            "photos.zip: an archive, expected a folder; unpack it and give the folder",
        ),
        ("nowhere --out a", "nowhere: no such folder"),
        ("notes.txt --out a", "notes.txt: neither a folder of photographs nor a video"),
        ("empty --out a", "empty: no PNG or JPEG files in this folder"),
        ("walk.mov --out a", "ffmpeg is not installed; Debian and Ubuntu: `apt install ffmpeg`"),
        ("photos --out mine", "mine: the folder is not empty, and `prepare` has not made"),
    ] {
        let line = shop.line(&format!("prepare {options}"), &[]);
        assert!(line.starts_with(expected), "{options}: {line}");
    }
    assert!(!shop.place.path("a").exists());
    assert!(shop.calls().is_empty());
    shop.ok("prepare photos --out set --link --quiet --json");
    let line = shop.line("prepare photos --out set --features 4096", &[]);
    assert!(
        line.starts_with("set: was begun from other photographs or with other options"),
        "{line}"
    );
    std::fs::remove_file(shop.place.path("bin/colmap")).unwrap();
    let line = shop.line("prepare photos --out b", &[]);
    assert!(
        line.starts_with("colmap is not installed; Debian and Ubuntu: `apt install colmap`"),
        "{line}"
    );
}

#[test]
fn train_and_info_name_the_next_step() {
    let shop = Shop::new(&[]);
    std::fs::write(shop.place.path("walk.mp4"), "...").unwrap();
    std::fs::write(shop.place.path("photos.zip"), b"PK\x03\x04...").unwrap();
    for (data, expected) in [
        (
            "photos",
            "photos: 6 photographs without poses; `pocketnerf prepare` makes a dataset of them",
        ),
        ("walk.mp4", "walk.mp4: a video; `pocketnerf prepare` makes a dataset of it"),
        ("photos.zip", "photos.zip: an archive, expected a folder; unpack it"),
    ] {
        let line = shop.place.line(&format!("train {data} --quiet --out x.pnerf"));
        assert!(line.starts_with(expected), "{line}");
        assert_eq!(shop.place.line(&format!("info {data}")), line);
        let others = ["colmap", "ns-process-data", "colmap2nerf.py"];
        assert!(data == "photos.zip" || others.iter().all(|name| line.contains(name)), "{line}");
    }
}
