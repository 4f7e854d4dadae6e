//! What the page shows beside a hand's own view: a path through keyframes, normals, photographs.

use std::path::Path;

use pocketnerf_core::Camera;
use pocketnerf_core::camera::{Keyframe, KeyframePath};
use pocketnerf_formats::{About, PhotographList, Precision, Scene as Coordinates};
use pocketnerf_view::view::View;
use serde_json::{Value, json};

use crate::common::{self, chromium::Page};
use crate::{AT_REST, BYTES, STILL_LIFE, changed, decode, drop_file, encode, native, seen};

/// The page at rest, and the size of its picture.
fn page(home: &str) -> Option<(Page, [u32; 2])> {
    let mut page = Page::new(home, [320, 420])?;
    page.go(home);
    page.until(AT_REST);
    page.value(BYTES);
    let size = page.value("[picture.width, picture.height]");
    Some((page, [0, 1].map(|i| size[i].as_u64().unwrap() as u32)))
}

fn click(page: &mut Page, button: &str) {
    page.value(&format!("document.getElementById('{button}').click()"));
}

fn key(page: &mut Page, key: &str) {
    for kind in ["keyDown", "keyUp"] {
        page.call("Input.dispatchKeyEvent", json!({ "type": kind, "key": key }));
    }
}

/// The file that the page saves into this folder.
fn saved(page: &mut Page, folder: &Path) -> Value {
    let file = folder.join("camera_path.json");
    let how = json!({ "behavior": "allow", "downloadPath": folder });
    page.call("Page.setDownloadBehavior", how);
    click(page, "save");
    let begun = std::time::Instant::now();
    loop {
        // It has its name when it is whole.
        if let Ok(bytes) = std::fs::read(&file) {
            std::fs::remove_file(file).unwrap();
            return serde_json::from_slice(&bytes).unwrap();
        }
        assert!(begun.elapsed().as_secs() < 60, "the page saves nothing");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
}

#[track_caller]
fn assert_near(found: &Value, expected: &[f32]) {
    assert_eq!(found.as_array().map(Vec::len), Some(expected.len()), "{found}");
    for (i, expected) in expected.iter().enumerate() {
        let found = found[i].as_f64().unwrap();
        assert!((found - f64::from(*expected)).abs() < 1e-4, "{i}: {found} {expected}");
    }
}

#[test]
fn keyframes_become_a_path_and_return() {
    let Some(dist) = common::dist() else { return };
    let home = common::server::serve(&dist);
    let Some((mut page, [width, height])) = page(&home) else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let mut view = View::new(&file);
    let shown = |view: &View| file.about.scene.camera_to_dataset(&view.camera(width, height));

    // Two keyframes, a third one that goes again, and what is between them.
    let first = seen(&mut page);
    click(&mut page, "play");
    page.until("figures.textContent.endsWith('a path takes two keyframes')");
    key(&mut page, "k");
    let left = json!({ "button": "left", "buttons": 1, "clickCount": 1 });
    page.mouse("mousePressed", [100.0, 100.0], left.clone());
    page.mouse("mouseMoved", [160.0, 110.0], left.clone());
    page.mouse("mouseReleased", [160.0, 110.0], left);
    let turned = changed(&mut page, &first);
    view.drag([60.0, 10.0], height);
    let mut keyframes = [shown(&View::new(&file)), shown(&view)].map(|camera| Keyframe {
        pose: camera.camera_to_world,
        fov_y: 2.0 * (0.5 * f64::from(height) / f64::from(camera.focal[1])).atan().to_degrees(),
        seconds: 2.0,
    });
    click(&mut page, "add");
    click(&mut page, "add");
    page.until("figures.textContent.includes('3 keyframes, 4 seconds')");
    key(&mut page, "Backspace");
    page.until("figures.textContent.includes('2 keyframes, 2 seconds')");
    let found = saved(&mut page, folder.path());
    let path = KeyframePath { keyframes: &keyframes, is_cycle: false, fps: 30.0 };
    for (key, expected) in [
        ("camera_type", json!("perspective")),
        ("render_width", json!(width)),
        ("render_height", json!(height)),
        ("fps", json!(30)),
        ("seconds", json!(2)),
        ("is_cycle", json!(false)),
    ] {
        assert_eq!(found[key], expected, "{key}");
    }
    assert_eq!(found["keyframes"].as_array().map(Vec::len), Some(2));
    assert_eq!(found["camera_path"].as_array().map(Vec::len), Some(60));
    for (keyframe, found) in keyframes.iter().zip(found["keyframes"].as_array().unwrap()) {
        assert_near(&found["matrix"], &keyframe.pose);
    }
    for ((pose, fov), found) in path.pictures().zip(found["camera_path"].as_array().unwrap()) {
        assert_near(&found["camera_to_world"], &pose);
        assert!((found["fov"].as_f64().unwrap() - fov).abs() < 1e-4, "{found}");
    }

    // Played from where the first one is to the last; a key on the way ends it, and begins where
    // it was.
    click(&mut page, "reset");
    page.until(AT_REST);
    click(&mut page, "play");
    key(&mut page, "k");
    let ended = saved(&mut page, folder.path());
    let third = ended["keyframes"][2]["matrix"].clone();
    let is_near = |pose: [f32; 16]| {
        (0..16).all(|i| (third[i].as_f64().unwrap() - f64::from(pose[i])).abs() < 1e-4)
    };
    assert!(path.pictures().any(|(pose, _)| is_near(pose)), "{third}");
    click(&mut page, "remove");
    page.until(AT_REST);
    click(&mut page, "play");
    page.until("document.getElementById('play').ariaPressed === 'false'");
    let last = changed(&mut page, &first);
    assert!(far(&last, &turned) < 100, "{}", far(&last, &turned));

    // A file that other programs have written: the matrix as text, column after column, another
    // field of view, three keyframes around.
    keyframes[1].fov_y = 30.0;
    let columns = |pose: &[f32; 16]| {
        let columns: Vec<f32> = (0..16).map(|i| pose[i % 4 * 4 + i / 4]).collect();
        serde_json::to_string(&columns).unwrap()
    };
    let other = json!({ "is_cycle": true, "fps": 24, "seconds": 3, "keyframes": [
        { "matrix": columns(&keyframes[1].pose), "fov": 30 },
        { "matrix": keyframes[0].pose, "fov": keyframes[0].fov_y }] });
    drop_file(&mut page, "other.json", other.to_string().as_bytes());
    page.until(&format!("{AT_REST} && figures.textContent.includes('other.json, 2 keyframes')"));
    let focal = (0.5 * f64::from(height) / 15f64.to_radians().tan()) as f32;
    let camera = Camera { focal: [focal; 2], ..shown(&view) };
    let expected = native(STILL_LIFE, &camera);
    assert!(far(&seen(&mut page), &expected) < 100);
    let found = saved(&mut page, folder.path());
    assert_eq!(json!([found["is_cycle"], found["fps"], found["seconds"]]), json!([true, 24, 3]));
    keyframes.reverse();
    keyframes.iter_mut().for_each(|keyframe| keyframe.seconds = 1.5);
    let path = KeyframePath { keyframes: &keyframes, is_cycle: true, fps: 24.0 };
    assert_eq!(found["camera_path"].as_array().map(Vec::len), Some(path.len()));
    for ((pose, fov), found) in path.pictures().zip(found["camera_path"].as_array().unwrap()) {
        assert_near(&found["camera_to_world"], &pose);
        assert!((found["fov"].as_f64().unwrap() - fov).abs() < 1e-4, "{found}");
    }

    // What is none is a line, and the keyframes stay.
    let pose = json!(keyframes[0].pose);
    for (file, expected) in [
        (json!([1]), "no keyframes in it"),
        (json!({ "camera_type": "fisheye", "keyframes": [] }), "camera type fisheye, expected"),
        (json!({ "keyframes": [{ "matrix": [1, 2], "fov": 50 }] }), "keyframe 0: its matrix is no"),
        (json!({ "keyframes": [{ "matrix": pose, "fov": 180 }] }), "keyframe 0: fov 180, expected"),
        (json!({ "keyframes": [{ "matrix": pose, "fov": 50 }], "fps": 0 }), "0 pictures each"),
    ] {
        drop_file(&mut page, "bad.json", file.to_string().as_bytes());
        page.until("message.textContent !== ''");
        let said = page.value("message.textContent");
        let said = said.as_str().unwrap();
        assert!(said.starts_with("bad.json: ") && said.contains(expected), "{said}");
    }
    assert_eq!(saved(&mut page, folder.path())["fps"], 24);
    assert_eq!(page.complaints, [""; 0]);
}

/// Bytes that differ by more than rounding makes them.
fn far(a: &[u8], b: &[u8]) -> usize {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 2).count()
}

/// The still life in other coordinates, with photographs.
fn with_photographs() -> &'static [u8] {
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let scene = Coordinates {
        scale: 2.0,
        rotation: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [10.0, 20.0, 30.0],
        ..file.about.scene
    };
    let orbit = View::new(&file).orbit(20);
    let cameras: Vec<Camera> = orbit.iter().map(|view| view.camera(80, 60)).collect();
    let photographs = PhotographList::new(&cameras).unwrap();
    let about = About { scene, photographs: Some(photographs.view()), ..file.about };
    pocketnerf_formats::write(&file.model, &about, Precision::I8).unwrap().leak()
}

#[test]
fn photographs_and_normals() {
    let Some(dist) = common::dist() else { return };
    let home = common::server::serve(&dist);
    let Some((mut page, [width, height])) = page(&home) else { return };
    let is_hidden = "document.getElementById('photographs').hidden";
    assert_eq!(page.value(is_hidden), true);
    let bytes = with_photographs();
    let file = pocketnerf_formats::open(bytes).unwrap();
    let scene = &file.about.scene;
    let own = View::new(&file).camera(width, height);
    let poses: Vec<[f32; 16]> = file.about.photographs.unwrap().poses().collect();
    drop_file(&mut page, "photographed.pnerf", bytes);
    page.until(&format!("{AT_REST} && figures.textContent.startsWith('photographed.pnerf: ')"));
    assert_eq!(page.value(is_hidden), false);
    for (key_of, number) in [(".", 0), (".", 1), (",", 0), (",", 19)] {
        key(&mut page, key_of);
        let said = format!("photograph {} of 20", number + 1);
        page.until(&format!("{AT_REST} && figures.textContent.includes('{said} ')"));
        let camera = Camera { camera_to_world: poses[number], ..own };
        let expected = native(bytes, &scene.camera_to_dataset(&camera));
        let off = far(&seen(&mut page), &expected);
        assert!(off < 100, "{number}: {off}");
    }

    // Normals are those of the picture's distances.
    click(&mut page, "reset");
    page.until(AT_REST);
    let colours = seen(&mut page);
    key(&mut page, "n");
    let found = changed(&mut page, &colours);
    let expected = page.value(&format!(
        "(async () => {{
            const [{{ load }}, {{ normals }}] =
                await Promise.all(['/pocketnerf.js', '/normals.js'].map((name) => import(name)));
            const scene = await load(Uint8Array.from(atob('{}'), (c) => c.charCodeAt(0)));
            const camera = scene.camera(picture.width, picture.height);
            const {{ data }} = normals(await scene.layer(camera), camera, scene.info);
            scene.close();
            return text(data);
        }})()",
        encode(bytes)
    ));
    assert!(found == decode(&expected));
    key(&mut page, "n");
    assert!(changed(&mut page, &found) == colours);
    assert_eq!(page.complaints, [""; 0]);
}

/// A ball before a wall that leans, whose distances and normals are known, seen by a camera that is
/// turned.
#[test]
fn normals_of_known_surfaces() {
    let Some(dist) = common::dist() else { return };
    let home = common::server::serve(&dist);
    let Some(mut page) = Page::new(&home, [200, 200]) else { return };
    page.go(&format!("{home}/package.json"));
    let found = page.value(
        "(async () => {
            const { normals } = await import('/normals.js');
            const [width, height, focal] = [120, 90, 110];
            const pixels = new Uint8ClampedArray(4 * width * height).fill(255);
            const depth = new Float32Array(width * height);
            const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            const unit = (v) => v.map((x) => x / Math.hypot(...v));
            const wall = unit([0.5, -0.3, 1]);
            const truth = [...depth].map((_, i) => {
                const across = (i % width) + 0.5 - 55;
                const ray = unit([across / focal, (40 - Math.floor(i / width) - 0.5) / focal, -1]);
                // The ball has the radius 1, five units ahead; the wall is eight ahead.
                const along = -5 * ray[2];
                const inside = along * along - 24;
                const isBall = inside > 0;
                depth[i] = isBall ? along - Math.sqrt(inside) : (-8 * wall[2]) / dot(wall, ray);
                const at = ray.map((v) => v * depth[i]);
                return { isBall, n: isBall ? [at[0], at[1], at[2] + 5] : wall };
            });
            // Nothing in a corner, behind which is grey.
            for (let i = 0; i < 5; i += 1) {
                depth[i] = Infinity;
                pixels.fill(0, 4 * i, 4 * i + 4);
            }
            const pose = [0, 0, 1, 7, 1, 0, 0, 8, 0, 1, 0, 9, 0, 0, 0, 1];
            const info = { background: [0.2, 0.4, 0.6], isLinear: false };
            const camera = { focal: [focal, focal], center: [55, 40], pose };
            const { data } = normals({ width, height, pixels, depth }, camera, info);
            const off = truth.slice(5).map(({ isBall, n }, k) => {
                const color = data.slice(4 * (k + 5), 4 * (k + 5) + 3);
                const seen = unit([...color].map((v) => v / 127.5 - 1));
                // Right is y, up is z and back is x.
                const degrees = (Math.acos(Math.min(dot(seen, [n[2], n[0], n[1]]), 1)) * 180) / Math.PI;
                return { isBall, degrees };
            });
            const list = (which) => off.filter(({ isBall }) => isBall === which)
                .map(({ degrees }) => degrees).sort((a, b) => a - b);
            const [ball, plane] = [true, false].map(list);
            const at = (list, part) => list[Math.floor(part * (list.length - 1))];
            return [[...data.slice(0, 4)], ball.length, at(ball, 0.5), at(ball, 0.9), plane.length, at(plane, 1)];
        })()",
    );
    println!("{found}");
    assert_eq!(found[0], json!([51, 102, 153, 255]));
    let number = |i: usize| found[i].as_f64().unwrap();
    assert!(number(1) > 1000.0 && number(2) < 1.0 && number(3) < 5.0, "{found}");
    // No pixel of the wall sees the ball's edge.
    assert!(number(4) > 5000.0 && number(5) < 1.0, "{found}");
}
