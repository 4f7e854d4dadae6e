//! The page and the package in a browser, where there is one.

mod api;
mod common;
mod gpu;
mod three;
mod views;

use base64::Engine;
use common::chromium::Page;
use pocketnerf_core::reference::render_ray;
use pocketnerf_core::{Camera, SimdLevel};
use pocketnerf_view::view::View;
use pocketnerf_web::Scene;
use serde_json::{Value, json};

const STILL_LIFE: &[u8] = include_bytes!("../../../still-life.pnerf");
const PLANES: &[u8] = include_bytes!("../../../../tests/golden/planes-i8-packed.pnerf");
const NERF: &[u8] = include_bytes!("../../../../tests/golden/nerf-f16.pnerf");
const AT_REST: &str = "picture.dataset.state === 'rest'";

/// The bytes of the canvas, as text; those of an `ImageData` with `data`.
const BYTES: &str = "globalThis.text = (data) => {
    let text = '';
    for (const byte of data) text += String.fromCharCode(byte);
    return btoa(text);
}; globalThis.seen = () =>
    text(picture.getContext('2d').getImageData(0, 0, picture.width, picture.height).data); true";

#[test]
fn the_page_follows_the_hand() {
    let Some(dist) = common::dist() else { return };
    let home = common::server::serve(&dist);
    let Some(mut page) = Page::new(&home, [400, 518]) else { return };
    page.go(&home);
    page.until(AT_REST);
    page.value(BYTES);
    let first = page.value("performance.getEntriesByName('whole picture')[0].startTime");
    let size = page.value("[picture.width, picture.height]");
    let [width, height] = [0, 1].map(|i| size[i].as_u64().unwrap() as u32);
    assert!(width == 400 && (300..518).contains(&height), "{size}");

    println!("the whole picture, {size}, was there {first} ms after the page was asked for");

    // At rest the canvas shows the bytes of every host.
    let first = seen(&mut page);
    let scene = Scene::open(STILL_LIFE, four_lanes()).unwrap();
    let own = scene.own_camera(width, height);
    assert_eq!(difference(&first, &native(STILL_LIFE, &own)), 0);
    let label = page.value("picture.ariaLabel");
    assert!(label.as_str().unwrap().contains("hash-grid"), "{label}");
    says(&mut page, ": CPU, ");
    says(&mut page, "ms for the whole picture, 400");

    // A drag turns; the way back leads to the same picture.
    let left = json!({ "button": "left", "buttons": 1, "clickCount": 1 });
    page.mouse("mousePressed", [200.0, 150.0], left.clone());
    page.mouse("mouseMoved", [260.0, 150.0], left.clone());
    page.until("picture.dataset.state === 'moving' || figures.textContent.includes('whole')");
    page.mouse("mouseReleased", [260.0, 150.0], left.clone());
    let turned = changed(&mut page, &first);
    page.value("document.getElementById('reset').click()");
    assert!(changed(&mut page, &turned) == first);

    // The wheel approaches, a right drag goes aside, two fingers do both.
    page.mouse("mouseWheel", [200.0, 150.0], json!({ "deltaX": 0, "deltaY": -200 }));
    let near = changed(&mut page, &first);
    let right = json!({ "button": "right", "buttons": 2, "clickCount": 1 });
    page.mouse("mousePressed", [200.0, 150.0], right.clone());
    page.mouse("mouseMoved", [230.0, 170.0], right.clone());
    page.mouse("mouseReleased", [230.0, 170.0], right);
    let aside = changed(&mut page, &near);
    page.resize([400, 518], 1.0, true);
    page.touch("touchStart", &[[180.0, 150.0], [220.0, 150.0]]);
    page.touch("touchMove", &[[170.0, 160.0], [240.0, 160.0]]);
    page.touch("touchEnd", &[]);
    changed(&mut page, &aside);
    page.resize([400, 518], 1.0, false);

    // A click tells a distance.
    page.value("document.getElementById('reset').click()");
    page.until(AT_REST);
    let (at, _) = hit(&own);
    let at = at.map(f64::from);
    page.mouse("mousePressed", at, left.clone());
    page.mouse("mouseReleased", at, left);
    page.until("figures.textContent.includes(' away, at (')");

    // A broken file is a line; the picture stays. A good one is shown.
    let before = seen(&mut page);
    drop_file(&mut page, "broken.pnerf", &STILL_LIFE[..1000]);
    page.until("message.textContent !== ''");
    let said = page.value("message.textContent");
    let expected = pocketnerf_formats::open_verified(&STILL_LIFE[..1000]).unwrap_err();
    assert_eq!(said, format!("broken.pnerf: {expected}"));
    assert!(seen(&mut page) == before);
    drop_file(&mut page, "paper.pnerf", NERF);
    page.until("message.textContent.startsWith('paper.pnerf: ')");
    let said = page.value("message.textContent");
    assert!(said.as_str().unwrap().contains("nerf`"), "{said}");
    drop_file(&mut page, "other.pnerf", STILL_LIFE);
    page.until(&format!("{AT_REST} && figures.textContent.startsWith('other.pnerf: ')"));
    assert_eq!(page.value("message.textContent"), "");
    assert!(seen(&mut page) == first);

    // Other sizes of the window: a phone, and a screen.
    page.resize([390, 760], 2.0, true);
    page.until(&format!("picture.width === 780 && {AT_REST}"));
    keep(&mut page, "phone");
    page.resize([1000, 700], 1.0, false);
    page.go(&format!("{home}/?model=still-life.pnerf"));
    page.until(&format!("picture.width === 1000 && {AT_REST}"));
    keep(&mut page, "screen");
    assert_eq!(page.complaints, [""; 0]);
}

#[test]
fn other_pages_can_use_it() {
    const SIZE: [u32; 2] = [160, 120];
    let Some(dist) = common::dist() else { return };
    let home = common::server::serve(&dist);
    let Some(mut page) = Page::new(&home, [300, 300]) else { return };
    page.go(&format!("{home}/package.json"));
    page.value(BYTES);
    page.value(
        "(async () => {
            const { load } = await import('/pocketnerf.js');
            const bytes = await (await fetch('/still-life.pnerf')).arrayBuffer();
            Object.assign(globalThis, { load, bytes, scene: await load(bytes) });
        })()",
    );
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let own = file.about.camera.unwrap();
    assert_eq!(page.value("scene.info.camera.width"), own.width);
    assert_eq!(page.value("scene.info.name"), file.about.scene.name.unwrap_or_default());

    // The golden view: the oracle's, and the bytes of the same code compiled for this machine.
    let native_scene = Scene::open(STILL_LIFE, four_lanes()).unwrap();
    let camera = native_scene.own_camera(SIZE[0], SIZE[1]);
    let found = decode(
        &page.value("(async () => text((await scene.render(scene.camera(160, 120))).data))()"),
    );
    let truth: Vec<u8> = (0..SIZE[0] * SIZE[1])
        .flat_map(|i| {
            let ray = camera.ray((i % SIZE[0]) as f32 + 0.5, (i / SIZE[0]) as f32 + 0.5);
            let seen = render_ray(&file.model, &ray).unwrap();
            let [r, g, b] = seen.rgb;
            let [r, g, b] = file.model.display.rgb8([r, g, b, seen.opacity]);
            [r, g, b, 255]
        })
        .collect();
    let finest = decode(&page.value(
        "(async () => text((await scene.render(scene.camera(160, 120), { quality: 1 })).data))()",
    ));
    println!(
        "golden view: {:.1} dB; in the finest quality {:.1} dB",
        psnr(&found, &truth),
        psnr(&finest, &truth)
    );
    assert_eq!(difference(&found, &native(STILL_LIFE, &camera)), 0);
    assert!(psnr(&finest, &truth) >= 50.0, "{} dB", psnr(&finest, &truth));

    // The page's camera turns as the window's does.
    let mut view = View::new(&file);
    view.drag([30.0, -20.0], 120);
    view.pull([10.0, 5.0], [160, 120]);
    view.approach(0.7);
    let expected = file.about.scene.camera_to_dataset(&view.camera(160, 120)).camera_to_world;
    let found = page.value(
        "(async () => {
            const { Orbit } = await import('/orbit.js');
            const orbit = new Orbit(scene);
            orbit.drag(30, -20, 120);
            orbit.pull(10, 5, 160, 120);
            orbit.approach(0.7);
            return orbit.camera(160, 120).pose;
        })()",
    );
    for (i, expected) in expected.into_iter().enumerate() {
        let found = found[i].as_f64().unwrap();
        assert!((found - f64::from(expected)).abs() < 1e-5, "{i}: {found} {expected}");
    }

    // A canvas, tiles, the newest picture alone.
    let size = "(async () => {
        const canvas = new OffscreenCanvas(1, 1);
        let pixels = 0;
        const onTile = (tile) => { pixels += tile.width * tile.height; };
        await scene.render(scene.camera(50, 40), { canvas, onTile });
        return [canvas.width, canvas.height, pixels];
    })()";
    assert_eq!(page.value(size), json!([50, 40, 2000]));
    let overtaken =
        "Promise.all([900, 800, 30].map((side) => scene.render(scene.camera(side, side))))
        .then((all) => all.map((image) => image && image.width))";
    assert_eq!(page.value(overtaken), json!([null, null, 30]));

    // Questions.
    let ([x, y], [depth, at @ ..]) = hit(&camera);
    let found = page.value(&format!("scene.pick({x}, {y}, scene.camera(160, 120))"));
    assert_eq!(found["depth"].as_f64(), Some(depth.into()));
    at.iter()
        .enumerate()
        .for_each(|(a, v)| assert_eq!(found["point"][a].as_f64(), Some((*v).into())));
    assert_eq!(page.value("scene.pick(0, 0, scene.camera(160, 120))"), Value::Null);
    let beside = page.value("scene.stats.memory - bytes.byteLength");
    assert!(beside.as_f64().unwrap() < 16e6, "{beside}");

    // What fails says why; the page keeps its own copy of the bytes.
    let why = |page: &mut Page, what: &str| {
        let said = page.value(&format!("{what}.then(() => 'done', (error) => error.message)"));
        said.as_str().unwrap().to_owned()
    };
    let cut = pocketnerf_formats::open_verified(&STILL_LIFE[..1000]).unwrap_err().to_string();
    assert_eq!(why(&mut page, "load(bytes.slice(0, 1000))"), cut);
    assert!(why(&mut page, "load(new ArrayBuffer(0))").len() > 10);
    assert!(
        why(&mut page, "scene.render({ ...scene.camera(9, 9), pose: Array(16).fill(0) })")
            .contains("pose")
    );
    assert_eq!(page.value("bytes.byteLength"), STILL_LIFE.len());
    assert_eq!(why(&mut page, "(scene.close(), scene.render())"), "the scene is closed");
    assert_eq!(page.complaints, [""; 0]);
}

/// Screenshots to look at, where somebody wants them: a folder in this variable.
fn keep(page: &mut Page, name: &str) {
    if let Some(folder) = std::env::var_os("POCKETNERF_SCREENSHOTS") {
        let path = std::path::Path::new(&folder).join(format!("{name}.jpg"));
        std::fs::write(path, page.screenshot("jpeg")).unwrap();
    }
}

fn says(page: &mut Page, expected: &str) {
    let said = page.value("figures.textContent");
    assert!(said.as_str().unwrap().contains(expected), "{said}");
}

/// The picture at rest, which is another than this one.
#[track_caller]
fn changed(page: &mut Page, before: &[u8]) -> Vec<u8> {
    page.value(&format!("globalThis.before = '{}'; true", encode(before)));
    page.until(&format!("{AT_REST} && seen() !== before"));
    let after = seen(page);
    assert!(difference(before, &after) > 20);
    after
}

/// A point where this camera sees something, and what a pick finds there.
fn hit(camera: &Camera) -> ([f32; 2], [f32; 4]) {
    let mut scene = Scene::open(STILL_LIFE, four_lanes()).unwrap();
    let [x, y] = [camera.width / 2, camera.height / 2].map(|half| half as f32);
    let mut points = (0..camera.height / 2).map(|down| [x, y + down as f32]);
    let found = points.find_map(|at| {
        let found = scene.pick(camera, at).unwrap();
        found[0].is_finite().then_some((at, found))
    });
    found.expect("something below the middle")
}

fn drop_file(page: &mut Page, name: &str, bytes: &[u8]) {
    page.value(&format!(
        "(() => {{
            const bytes = Uint8Array.from(atob('{}'), (c) => c.charCodeAt(0));
            const dataTransfer = new DataTransfer();
            dataTransfer.items.add(new File([bytes], '{name}'));
            const how = {{ dataTransfer, bubbles: true, cancelable: true }};
            picture.dispatchEvent(new DragEvent('drop', how));
        }})()",
        encode(bytes)
    ));
}

fn seen(page: &mut Page) -> Vec<u8> {
    decode(&page.value("seen()"))
}

fn encode(bytes: &[u8]) -> String {
    base64::prelude::BASE64_STANDARD.encode(bytes)
}

fn decode(text: &Value) -> Vec<u8> {
    base64::prelude::BASE64_STANDARD.decode(text.as_str().unwrap()).unwrap()
}

/// The level with as many lanes as WebAssembly has.
fn four_lanes() -> SimdLevel {
    let levels = [SimdLevel::Sse42, SimdLevel::Neon];
    levels.into_iter().find(|level| level.is_available()).unwrap_or(SimdLevel::Portable)
}

fn native(bytes: &'static [u8], camera: &Camera) -> Vec<u8> {
    let mut scene = Scene::open(bytes, four_lanes()).unwrap();
    let mut picture = vec![0; (4 * camera.width * camera.height) as usize];
    let quality = scene.facts().quality();
    for number in 0..scene.begin(camera, quality).unwrap() {
        let (tile, pixels) = scene.tile(number, false).unwrap();
        for (row, line) in pixels.chunks_exact(4 * tile.width as usize).enumerate() {
            let at = 4 * ((tile.y as usize + row) * camera.width as usize + tile.x as usize);
            picture[at..at + line.len()].copy_from_slice(line);
        }
    }
    picture
}

/// The largest difference of two bytes.
#[track_caller]
fn difference(a: &[u8], b: &[u8]) -> u8 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

/// Over red, green and blue.
fn psnr(a: &[u8], b: &[u8]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2));
    // Alpha is 255 in both.
    let mean = squares.sum::<f64>() / (0.75 * a.len() as f64);
    10.0 * (255.0f64.powi(2) / mean.max(1e-9)).log10()
}
