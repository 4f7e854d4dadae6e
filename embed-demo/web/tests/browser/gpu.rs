//! WebGPU on a software GPU: it runs what a real one runs, slowly.

use pocketnerf_core::space::Contracted;
use pocketnerf_core::{Model, Space};
use pocketnerf_formats::Precision;
use pocketnerf_view::view::View;
use pocketnerf_web::Scene;
use serde_json::{Value, json};

use crate::common::{self, chromium::Page};
use crate::{AT_REST, BYTES, PLANES, STILL_LIFE, decode, difference, encode, four_lanes};
use crate::{native, psnr, seen};

/// Until the GPU has rendered a picture of this scene.
const ON_GPU: &str = "(async () => {
    for (;;) {
        await scene.render(scene.camera(8, 8));
        if (scene.stats.device === 'gpu') return true;
        await new Promise((resolve) => setTimeout(resolve, 50));
    }
})()";

#[test]
fn a_gpu_renders_what_the_cpu_does() {
    let Some(dist) = common::dist() else { return };
    let home = common::server::serve(&dist);
    let Some(mut page) = Page::with_gpu(&home, [200, 200]) else { return };
    page.go(&format!("{home}/package.json"));
    page.value(BYTES);
    page.value(
        "(async () => {
            const { load } = await import('/pocketnerf.js');
            const bytes = await (await fetch('/still-life.pnerf')).arrayBuffer();
            globalThis.cpu = await load(bytes, { gpu: 'off' });
            globalThis.refused = await load(bytes);
            globalThis.scene = await load(bytes, { gpu: 'software' });
        })()",
    );
    assert_eq!(page.value(ON_GPU), true);
    for quality in [0.0, 1.0] {
        let mut picture = |scene: &str| {
            let render =
                format!("{scene}.render({scene}.camera(90, 70), {{ quality: {quality} }})");
            decode(&page.value(&format!("{render}.then((image) => text(image.data))")))
        };
        let (found, expected) = (picture("scene"), picture("cpu"));
        let least = if quality == 1.0 { 50.0 } else { 30.0 };
        let psnr = psnr(&found, &expected);
        println!("quality {quality}: {psnr:.1} dB");
        assert!(psnr >= least, "quality {quality}: {psnr} dB");
        let stats = page.value("[scene.stats, cpu.stats]");
        assert_eq!(json!([stats[0]["device"], stats[1]["device"]]), json!(["gpu", "cpu"]));
        assert_eq!(stats[0]["rays"], 6300);
        assert!(stats[0]["samples"].as_f64() > Some(1e4), "{stats}");
    }

    // Layers: the same colours, and the same distances but at edges.
    let apart = page.value(
        "Promise.all([scene, cpu].map((one) => one.layer(one.camera(90, 70), { quality: 1 })))
        .then(([a, b]) => {
            const far = a.depth.filter((t, i) => !(t === b.depth[i] || Math.abs(t - b.depth[i]) < 1e-2));
            const off = a.pixels.filter((v, i) => Math.abs(v - b.pixels[i]) > 3);
            return [far.length, off.length, scene.stats.device, a.depth.filter(isFinite).length > 1000];
        })",
    );
    println!("{apart}");
    assert!(apart[0].as_u64() < Some(63) && apart[1].as_u64() < Some(63), "{apart}");
    assert_eq!(json!([apart[2], apart[3]]), json!(["gpu", true]));

    // Without being asked for it, no such program counts.
    page.value("refused.render(refused.camera(90, 70)).then(() => true)");
    assert_eq!(page.value("refused.stats.device"), "cpu");

    // Only the newest picture.
    let overtaken =
        "Promise.all([500, 400, 30].map((side) => scene.render(scene.camera(side, side))))
        .then((all) => [...all.map((image) => image && image.width), scene.stats.device])";
    assert_eq!(page.value(overtaken), json!([null, null, 30, "gpu"]));

    // Questions wait for no picture.
    let asked = "(async () => {
        const picture = scene.render(scene.camera(300, 300)).then(() => 'picture');
        return Promise.race([picture, scene.pick(0, 0, scene.camera(300, 300))]);
    })()";
    assert_eq!(page.value(asked), Value::Null);

    // A GPU that is lost in the middle of a picture: the CPU renders it.
    page.value("globalThis.last = scene.render(scene.camera(400, 400)); true");
    page.call("Browser.crashGpuProcess", json!({}));
    assert_eq!(page.value("last.then((image) => image.width)"), 400);
    assert_eq!(page.value("scene.stats.device"), "cpu");
    assert_eq!(page.complaints, [""; 0]);
}

/// Loads a file for the GPU, as `scene`, and for the CPU, and compares a picture by each.
fn assert_alike(page: &mut Page, home: &str, bytes: &[u8]) {
    page.go(&format!("{home}/package.json"));
    page.value(BYTES);
    page.value(&format!(
        "(async () => {{
            const {{ load }} = await import('/pocketnerf.js');
            const bytes = Uint8Array.from(atob('{}'), (c) => c.charCodeAt(0)).buffer;
            globalThis.cpu = await load(bytes.slice(), {{ gpu: 'off' }});
            globalThis.scene = await load(bytes, {{ gpu: 'software' }});
        }})()",
        encode(bytes)
    ));
    assert_eq!(page.value(ON_GPU), true);
    let [found, expected] = ["scene", "cpu"].map(|scene| {
        let render = format!("{scene}.render({scene}.camera(90, 70), {{ quality: 1 }})");
        decode(&page.value(&format!("{render}.then((image) => text(image.data))")))
    });
    let psnr = psnr(&found, &expected);
    println!("{psnr:.1} dB");
    assert!(psnr >= 50.0, "{psnr} dB");
}

/// What `train` learns in a box: the browser's own compiler takes the program.
#[test]
fn planes() {
    let Some(dist) = common::dist() else { return };
    let home = common::server::serve(&dist);
    let Some(mut page) = Page::with_gpu(&home, [200, 200]) else { return };
    assert_alike(&mut page, &home, PLANES);
    assert_eq!(page.complaints, [""; 0]);
}

/// The still life as if it reached to infinity: the browser's own compiler takes the program, and
/// the page's camera turns as the window's does.
#[test]
fn a_scene_without_an_end() {
    let Some(dist) = common::dist() else { return };
    let home = common::server::serve(&dist);
    let Some(mut page) = Page::with_gpu(&home, [200, 200]) else { return };
    let file = pocketnerf_formats::open(STILL_LIFE).unwrap();
    let space = Space::Contracted(Contracted { center: [0.2, -0.1, 0.3], radius: 1.5 });
    let about = pocketnerf_formats::About { camera: None, ..file.about };
    let model = Model { space, ..file.model };
    let bytes = pocketnerf_formats::write(&model, &about, Precision::I8).unwrap();
    assert_alike(&mut page, &home, &bytes);
    let mut view = View::new(&pocketnerf_formats::open(&bytes).unwrap());
    view.drag([30.0, -20.0], 120);
    view.approach(0.7);
    let expected = file.about.scene.camera_to_dataset(&view.camera(160, 120)).camera_to_world;
    let found = page.value(
        "(async () => {
            const { Orbit } = await import('/orbit.js');
            const orbit = new Orbit(scene);
            orbit.drag(30, -20, 120);
            orbit.approach(0.7);
            return orbit.camera(160, 120).pose;
        })()",
    );
    for (i, expected) in expected.into_iter().enumerate() {
        let found = found[i].as_f64().unwrap();
        assert!((found - f64::from(expected)).abs() < 1e-5, "{i}: {found} {expected}");
    }
    assert_eq!(page.complaints, [""; 0]);
}

#[test]
fn a_gpu_that_miscomputes_is_found() {
    let Some(dist) = common::dist() else { return };
    let home = common::server::serve(&dist);
    let Some(mut page) = Page::with_gpu(&home, [200, 200]) else { return };
    page.go(&format!("{home}/package.json"));
    // Opens a file after a change of what the GPU is given.
    page.value(
        "globalThis.opened = async (change) => {
            const { Gpu } = await import('/gpu.js');
            const module = await WebAssembly.compileStreaming(fetch('/pocketnerf.wasm'));
            const bytes = await (await fetch('/still-life.pnerf')).arrayBuffer();
            const { writeBuffer } = GPUQueue.prototype;
            GPUQueue.prototype.writeBuffer = function (buffer, offset, data) {
                writeBuffer.call(this, buffer, offset, change(data));
            };
            return Gpu.open(module, new Uint8Array(bytes), 'software')
                .then(() => 'opened', (error) => error.message)
                .finally(() => Object.assign(GPUQueue.prototype, { writeBuffer }));
        }; true",
    );
    assert_eq!(page.value("opened((data) => data)"), "opened");
    // A model of zeros; a camera of zeros.
    for change in [
        "data.length > 144 ? data.slice().fill(0) : data",
        "data.length === 36 ? data.slice().fill(0, 0, 16) : data",
    ] {
        let said = page.value(&format!("opened((data) => {change})"));
        assert_eq!(said, "the GPU miscomputes", "{change}");
    }
}

#[test]
fn the_page_says_what_renders() {
    let Some(dist) = common::dist() else { return };
    let home = common::server::serve(&dist);
    let Some(mut page) = Page::with_gpu(&home, [120, 200]) else { return };
    let [mut width, mut height] = [0; 2];
    let mut pictures = ["?gpu=off", "", "?gpu=software"].map(|asked| {
        page.go(&format!("{home}/{asked}"));
        page.until(AT_REST);
        page.value(BYTES);
        if asked.contains("software") {
            let again = format!("{AT_REST} && (document.getElementById('reset').click(), false)");
            page.until(&format!("figures.textContent.includes(': GPU, ') || {again}"));
            page.until(AT_REST);
        } else {
            // Time enough for a GPU to be found, were it to count.
            page.value("new Promise((resolve) => setTimeout(resolve, 1000))");
            page.value("document.getElementById('reset').click()");
            page.until(AT_REST);
            let said = page.value("figures.textContent");
            assert!(said.as_str().unwrap().contains(": CPU, "), "{said}");
        }
        [width, height] = ["width", "height"]
            .map(|side| page.value(&format!("picture.{side}")).as_u64().unwrap() as u32);
        seen(&mut page)
    });
    let scene = Scene::open(STILL_LIFE, four_lanes()).unwrap();
    let expected = native(STILL_LIFE, &scene.own_camera(width, height));
    let [off, refused, gpu] = &mut pictures;
    assert_eq!((difference(off, &expected), difference(refused, &expected)), (0, 0));
    assert!(psnr(gpu, &expected) >= 35.0, "{} dB", psnr(gpu, &expected));
    assert!(gpu != off);
    assert_eq!(page.complaints, [""; 0]);
}
