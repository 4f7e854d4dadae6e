//! `pocketnerf eval`.

use std::process::Command;

use pocketnerf_train::builtin::Scene;
use pocketnerf_train::dataset::Split;
use serde_json::Value;

const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../embed-demo/still-life.pnerf");

/// What a mean hides is said: in JSON, in the last line, and by copies of the worst pictures.
#[test]
fn the_worst_views_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let eval = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pocketnerf"));
        command.args(["eval", MODEL, "builtin", "--downscale-factor", "8"]).args(more);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let out = folder.path().to_str().unwrap();
    let found: Value = serde_json::from_str(&eval(&["--json", "--out", out])).unwrap();
    let views = found["per_view"].as_array().unwrap();
    let mut order: Vec<(f64, usize)> =
        views.iter().enumerate().map(|(i, v)| (v["psnr"].as_f64().unwrap(), i)).collect();
    order.sort_by(|a, b| a.partial_cmp(b).unwrap());
    assert_eq!(order.len(), 12);
    let figure = |key: &str| found[key].as_f64().unwrap();
    assert_eq!(figure("psnr_min"), order[0].0);
    assert_eq!(found["worst_view"], views[order[0].1]["name"]);
    assert!((figure("psnr_median") - (order[5].0 + order[6].0) / 2.0).abs() < 1e-9);
    // 0.05 of the way along eleven gaps.
    let p05 = order[0].0 + 0.55 * (order[1].0 - order[0].0);
    assert!((figure("psnr_p05") - p05).abs() < 1e-9);

    let picture = |name: String| std::fs::read(folder.path().join(name)).unwrap();
    for (place, (_, view)) in order.iter().take(3).enumerate() {
        let copy = picture(format!("worst-{}.png", place + 1));
        assert!(copy == picture(format!("{view:03}.png")), "{place}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 15);

    let said = eval(&[]);
    let worst = format!("worst {:.2}: {})", order[0].0, found["worst_view"].as_str().unwrap());
    assert!(said.lines().last().unwrap().contains(&worst), "{said}\n{worst}");
}

/// The score at a quarter of the photographs' size.
fn score(options: [&str; 2]) -> Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pocketnerf"));
    command.args(["eval", MODEL, "builtin", "--downscale-factor", "4", "--json"]);
    let output = command.args(options).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// At a quarter of the photographs' size, a ray a pixel sees a sixteenth of it.
#[test]
fn smaller_pictures_are_not_jagged() {
    let [auto, off] = ["auto", "off"].map(|rays| score(["--antialias", rays]));
    let figure = |found: &Value, key: &str| found[key].as_f64().unwrap();
    assert_eq!((&auto["rays_per_pixel"], &off["rays_per_pixel"]), (&16.into(), &1.into()));
    assert!(auto["warnings"].as_array().unwrap().is_empty(), "{auto}");
    let said = off["warnings"][0].as_str().unwrap();
    assert!(said.contains("edges are jagged; --antialias 4 casts 4x4 rays"), "{said}");
    let [many, one] = [&auto, &off].map(|found| figure(found, "psnr"));
    assert!(many > one + 6.0, "{many} {one}");
    // Every ray counts. Closer to one another, more of them are interpolated.
    let [many, one] = [&auto, &off].map(|found| figure(found, "samples_per_ray"));
    assert!(many < one && 4.0 * many > one, "{many} {one}");
    assert_eq!(auto["depth_error"], off["depth_error"]);
}

/// Fast pictures are not what a model can do.
#[test]
fn a_score_of_fast_pictures_says_so() {
    let eval = |quality: &str| {
        let found = score(["--quality", quality]);
        (found["psnr"].as_f64().unwrap(), found["warnings"].as_array().unwrap().clone())
    };
    let [(fast, said), (some, none), (all, neither)] = ["0", "0.25", "1"].map(eval);
    assert!(fast + 0.3 < all && some + 0.3 > all, "{fast} {some} {all}");
    assert!(said.len() == 1 && said[0].as_str().unwrap().starts_with("--quality 0: "), "{said:?}");
    assert!(none.is_empty() && neither.is_empty(), "{none:?} {neither:?}");
}

/// Far and near parts of opaque photographs have figures of their own, which together make
/// that of the whole picture; a scene that is cut out has none.
#[test]
fn far_and_near_parts_are_told_apart() {
    let eval = |data: &str, more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pocketnerf"));
        command.args(["eval", MODEL, data, "--downscale-factor", "16", "--antialias", "off"]);
        let output = command.args(more).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let json = |data| serde_json::from_str::<Value>(&eval(data, &["--json"])).unwrap();
    let still_life = json("builtin");
    for key in ["psnr_far", "psnr_near"] {
        assert!(still_life.get(key).is_none() && still_life["per_view"][0].get(key).is_none());
    }
    assert!(!eval("builtin", &[]).contains("far parts"));

    // The room's cameras stand 0.95 units from the point that all look at.
    let truth = Scene::Room.dataset(Split::Test, 16).views;
    let found = json("builtin:room");
    let views = found["per_view"].as_array().unwrap();
    let figure = |of: &Value, key: &str| of[key].as_f64().unwrap();
    let mut sums = [0.0; 2];
    for (view, truth) in views.iter().zip(&truth) {
        let depths = truth.depth.as_ref().unwrap();
        let far = depths.iter().filter(|t| **t > 3.0 * 0.95).count() as f64;
        let near = depths.len() as f64 - far;
        assert!(far > 0.0 && near > 0.0, "{}", truth.name);
        let error = |key| 10.0_f64.powf(-0.1 * figure(view, key));
        let whole = (error("psnr_far") * far + error("psnr_near") * near) / (far + near);
        assert!((whole / error("psnr") - 1.0).abs() < 1e-9, "{}", truth.name);
        sums[0] += figure(view, "psnr_far");
        sums[1] += figure(view, "psnr_near");
    }
    let [far, near] = sums.map(|sum| sum / truth.len() as f64);
    assert!((figure(&found, "psnr_far") - far).abs() < 1e-9);
    assert!((figure(&found, "psnr_near") - near).abs() < 1e-9);
    let said = eval("builtin:room", &[]);
    let parts = format!(", far parts {far:.2} dB, near parts {near:.2} dB");
    assert!(said.lines().last().unwrap().contains(&parts), "{said}{parts}");
}
