//! `pocketnerf eval`.

use std::process::Command;

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

/// At a quarter of the photographs' size, a ray a pixel sees a sixteenth of it.
#[test]
fn smaller_pictures_are_not_jagged() {
    let eval = |rays: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pocketnerf"));
        command.args(["eval", MODEL, "builtin", "--downscale-factor", "4", "--json"]);
        let output = command.args(["--antialias", rays]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<Value>(&output.stdout).unwrap()
    };
    let [auto, off] = ["auto", "off"].map(eval);
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
