//! What other pages can ask of the package: files from anywhere, cameras, layers, an end to what
//! was begun.

use pocketnerf_core::camera::Orbit;
use pocketnerf_core::{ColorSpace, Display, Model, pixel};
use pocketnerf_formats::Precision;
use serde_json::{Value, json};

use crate::common::{self, chromium::Page};
use crate::{BYTES, STILL_LIFE, decode, encode, four_lanes};

/// A page with `load`, and with `told`, which gives the name and the message of what fails.
fn page() -> Option<Page> {
    let home = common::server::serve(&common::dist()?);
    let mut page = Page::new(&home, [200, 200])?;
    page.go(&format!("{home}/package.json"));
    page.value(BYTES);
    page.value(
        "(async () => {
            globalThis.load = (await import('/pocketnerf.js')).load;
            globalThis.told = (promise) => promise.then(
                (value) => ['done', value === null ? 'null' : typeof value],
                ({ name, message }) => [name, message],
            );
        })()",
    );
    Some(page)
}

fn told(page: &mut Page, what: &str) -> [String; 2] {
    let said = page.value(&format!("told({what})"));
    [0, 1].map(|i| said[i].as_str().unwrap().to_owned())
}

#[test]
fn files_come_from_anywhere() {
    let Some(mut page) = page() else { return };
    page.value(
        "fetch('/still-life.pnerf').then(async (r) => { globalThis.blob = await r.blob(); })",
    );
    for source in [
        "'/still-life.pnerf'",
        "new URL('/still-life.pnerf', location)",
        "await fetch('/still-life.pnerf')",
        "new Response(blob)",
        "blob",
        "await blob.arrayBuffer()",
        "new DataView(await blob.arrayBuffer())",
        "new Uint8Array([7, ...new Uint8Array(await blob.arrayBuffer())]).subarray(1)",
    ] {
        let kind = page.value(&format!(
            "(async () => {{
                const scene = await load({source}, {{ gpu: 'off' }});
                scene.close();
                return scene.info.kind;
            }})()"
        ));
        assert_eq!(kind, "hash-grid", "{source}");
    }
    let seen = page.value(
        "(async () => {
            const seen = [];
            const onProgress = (received, total) => seen.push([received, total]);
            (await load('/still-life.pnerf', { onProgress })).close();
            const grows = seen.every(([n], i) => i === 0 || n > seen[i - 1][0]);
            return [grows, ...seen.at(-1)];
        })()",
    );
    assert_eq!(seen, json!([true, STILL_LIFE.len(), STILL_LIFE.len()]));
    assert_eq!(page.complaints, [""; 0]);

    let [name, message] = told(&mut page, "load('/nothing.pnerf')");
    assert!(name == "Error" && message.ends_with("/nothing.pnerf: 404 Not Found"), "{message}");
    let [name, message] = told(&mut page, "load('http://127.0.0.1:1/none')");
    assert!(name == "Error" && message.starts_with("http://127.0.0.1:1/none: "), "{message}");
    let [_, message] = told(&mut page, "load('/package.json')");
    assert!(message.contains("not a .pnerf file"), "{message}");
    for wrong in ["5", "null", "undefined", "{}"] {
        let [name, message] = told(&mut page, &format!("load({wrong})"));
        assert!(name == "TypeError" && message.starts_with("load: expected"), "{message}");
    }
}

/// Whatever is under way rejects with an `AbortError`, its worker ends, and later calls are answered.
#[test]
fn what_was_begun_can_be_ended() {
    let Some(mut page) = page() else { return };
    page.value(
        "globalThis.ended = 0;
        const { terminate } = Worker.prototype;
        Worker.prototype.terminate = function () { ended += 1; terminate.call(this); }; true",
    );
    for load in [
        "load('/still-life.pnerf', { signal: AbortSignal.abort() })",
        // As the first bytes arrive.
        "((c) => load('/still-life.pnerf', { signal: c.signal, onProgress: () => c.abort() }))
            (new AbortController())",
        "((c) => { const begun = load('/still-life.pnerf', { signal: c.signal }); c.abort(); return begun; })
            (new AbortController())",
    ] {
        assert_eq!(told(&mut page, load)[0], "AbortError", "{load}");
    }
    assert_eq!(page.value("ended"), 0);
    // While the file is opened, in a worker.
    let opening = "fetch('/still-life.pnerf').then(async (response) => {
        const bytes = await response.arrayBuffer();
        const { postMessage } = Worker.prototype;
        const control = new AbortController();
        Worker.prototype.postMessage = function (...all) {
            Worker.prototype.postMessage = postMessage;
            postMessage.apply(this, all);
            control.abort();
        };
        return load(bytes, { signal: control.signal });
    })";
    assert_eq!(told(&mut page, opening)[0], "AbortError");
    assert_eq!(page.value("ended"), 1);

    page.value("load('/still-life.pnerf', { gpu: 'off' }).then((s) => { globalThis.scene = s; })");
    let first_tile = "((c) => scene.render(scene.camera(900, 900), { signal: c.signal, onTile: () => c.abort() }))
        (new AbortController())";
    let layer = "((c) => { const begun = scene.layer(scene.camera(900, 900), { signal: c.signal });
        c.abort(new Error('enough')); return begun; })(new AbortController())";
    assert_eq!(told(&mut page, first_tile)[0], "AbortError");
    assert_eq!(told(&mut page, layer), ["Error", "enough"]);
    // One that waits for its turn, and is not begun.
    let waiting = "(() => {
        const control = new AbortController();
        scene.render(scene.camera(900, 900));
        const begun = scene.render(scene.camera(800, 800), { signal: control.signal });
        control.abort();
        return begun;
    })()";
    assert_eq!(told(&mut page, waiting)[0], "AbortError");
    assert_eq!(page.value("scene.render(scene.camera(30, 20)).then((image) => image.width)"), 30);
    // A signal that is late changes nothing.
    let late = "(async () => {
        const control = new AbortController();
        const image = await scene.render(scene.camera(20, 20), { signal: control.signal });
        control.abort();
        return [image.width, (await scene.render(scene.camera(9, 9))).width];
    })()";
    assert_eq!(page.value(late), json!([20, 9]));
    assert_eq!(page.complaints, [""; 0]);
}

#[test]
fn cameras_go_around_the_centre() {
    let Some(mut page) = page() else { return };
    page.value("load('/still-life.pnerf').then((scene) => { globalThis.scene = scene; })");
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let target = file.about.scene.to_dataset(file.model.space.center());
    let own = file.about.scene.camera_to_dataset(&file.about.camera.unwrap().camera());
    let eye = own.position();
    let far = (0..3).map(|a| (eye[a] - target[a]).powi(2)).sum::<f32>().sqrt();
    let orbits = [
        (
            "0.7, 0.3",
            Orbit {
                target,
                radius: far,
                azimuth: 0.7,
                elevation: 0.3,
                axis: [0.0, 0.0, 1.0],
                up: [0.0, 0.0, 1.0],
            },
        ),
        (
            "-2, -0.4, { distance: 3, up: [0, 2, 0], width: 40, height: 30 }",
            Orbit {
                target,
                radius: 3.0,
                azimuth: -2.0,
                elevation: -0.4,
                axis: [0.0, 1.0, 0.0],
                up: [0.0, 1.0, 0.0],
            },
        ),
        (
            "1, 0, { distance: 2, up: [1, 0, 0] }",
            Orbit {
                target,
                radius: 2.0,
                azimuth: 1.0,
                elevation: 0.0,
                axis: [1.0, 0.0, 0.0],
                up: [1.0, 0.0, 0.0],
            },
        ),
    ];
    for (arguments, orbit) in orbits {
        let found = page.value(&format!("scene.orbit({arguments})"));
        for (i, expected) in orbit.pose().into_iter().enumerate() {
            let found = found["pose"][i].as_f64().unwrap();
            assert!(
                (found - f64::from(expected)).abs() < 1e-5,
                "{arguments} {i}: {found} {expected}"
            );
        }
    }
    let size =
        "((c) => [c.width, c.height, c.center])(scene.orbit(0, 0, { width: 40, height: 30 }))";
    assert_eq!(page.value(size), json!([40, 30, [20, 15]]));
    assert_eq!(page.value("scene.orbit(0, 0).width"), own.width);
}

/// The still life, as if its colours were linear light.
fn linear() -> &'static [u8] {
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let display = Display { color_space: ColorSpace::Linear, ..file.model.display };
    let model = Model { display, ..file.model };
    pocketnerf_formats::write(&model, &file.about, Precision::I8).unwrap().leak()
}

#[test]
fn a_layer_is_what_the_renderer_finds() {
    const SIZE: [u32; 2] = [150, 100];
    let Some(mut page) = page() else { return };
    for bytes in [STILL_LIFE, linear()] {
        let layer = page.value(&format!(
            "(async () => {{
                const bytes = Uint8Array.from(atob('{}'), (c) => c.charCodeAt(0));
                const scene = await load(bytes, {{ gpu: 'off' }});
                const {{ width, height, pixels, depth }} = await scene.layer(scene.camera(150, 100));
                const image = await scene.render(scene.camera(150, 100));
                const isOpaque = image.data.every((v, i) => i % 4 < 3 || v === 255);
                return [width, height, isOpaque, text(pixels), text(new Uint8Array(depth.buffer))];
            }})()",
            encode(bytes)
        ));
        assert_eq!(json!([layer[0], layer[1], layer[2]]), json!([SIZE[0], SIZE[1], true]));
        let [pixels, depth] = [&layer[3], &layer[4]].map(|text: &Value| decode(text));

        let mut scene = pocketnerf_web::Scene::open(bytes, four_lanes()).unwrap();
        let file = pocketnerf_formats::open(bytes).unwrap();
        let color_space = file.model.display.color_space;
        let camera = scene.own_camera(SIZE[0], SIZE[1]);
        let quality = scene.facts().quality();
        let mut seen = 0;
        for number in 0..scene.begin(&camera, quality).unwrap() {
            let (tile, _) = scene.tile(number, true).unwrap();
            let colors = scene.colors().as_chunks::<4>().0[..tile.pixels()].to_vec();
            for (i, (color, t)) in colors.iter().zip(scene.depths()).enumerate() {
                let [x, y] = [tile.x + i as u32 % tile.width, tile.y + i as u32 / tile.width];
                let at = 4 * (y * SIZE[0] + x) as usize;
                let off =
                    crate::difference(&pixels[at..at + 4], &pixel::rgba8(*color, color_space));
                assert!(off <= 1, "{x} {y}: {:?} {color:?}", &pixels[at..at + 4]);
                let found = f32::from_le_bytes(depth[at..at + 4].try_into().unwrap());
                assert_eq!(found, file.about.scene.scale * t, "{x} {y}");
                seen += u32::from(found.is_finite());
            }
        }
        assert!(seen > 1000, "{seen}");
    }
    assert_eq!(page.complaints, [""; 0]);
}
