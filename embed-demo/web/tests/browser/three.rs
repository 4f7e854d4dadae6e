//! The example with three.js: the nearer one is seen, pixel by pixel.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{self, chromium::Page};

/// The package three in this version, fetched once by npm to the target folder.
fn three(version: &str) -> Option<PathBuf> {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("npm");
    let package = target.join("node_modules/three");
    let described = std::fs::read_to_string(package.join("package.json")).unwrap_or_default();
    if described.contains(&format!("\"version\": \"{version}\"")) {
        return Some(package.join("build"));
    }
    std::fs::create_dir_all(&target).unwrap();
    let mut npm = Command::new("npm");
    npm.args(["install", "--no-save", "--no-audit", "--no-fund", "--ignore-scripts"]);
    npm.arg("--prefix").arg(&target).arg(format!("three@{version}"));
    match npm.output() {
        Ok(output) if output.status.success() => Some(package.join("build")),
        Ok(output) => common::skip(&String::from_utf8_lossy(&output.stderr)),
        Err(error) => common::skip(&format!("npm: {error}")),
    }
}

/// The example beside the package, as one folder.
fn site(dist: &Path) -> Option<tempfile::TempDir> {
    const PACKAGE: &str = "https://cdn.jsdelivr.net/npm/three@";
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/three");
    let page = std::fs::read_to_string(example.join("index.html")).unwrap();
    let (_, after) = page.split_once(PACKAGE).unwrap();
    let version = after.split('/').next().unwrap();
    let three = three(version)?;
    let site = tempfile::tempdir().unwrap();
    let copy = |from: &Path| {
        let to = site.path().join(from.file_name().unwrap());
        std::fs::copy(from, to).unwrap();
    };
    for entry in std::fs::read_dir(dist).unwrap() {
        copy(&entry.unwrap().path());
    }
    ["main.js", "field.js"].iter().for_each(|name| copy(&example.join(name)));
    ["three.module.js", "three.core.js"].iter().for_each(|name| copy(&three.join(name)));
    let own =
        page.replace(&format!("{PACKAGE}{version}/build/"), "./").replace("../../dist/", "./");
    std::fs::write(site.path().join("index.html"), own).unwrap();
    Some(site)
}

/// Counts pixels at which the ring is well in front of the model, and well behind it, and those of
/// them that do not show what polygons alone, or the field alone, shows. Distances are those of
/// three's ray casts, and of picks.
const COUNT: &str = "(async () => {
    const { Raycaster, Vector2 } = await import('three');
    const { camera, field, model, renderer, ring, scene } = await import('/main.js');
    renderer.setAnimationLoop(null);
    ring.rotation.set(1.3, 0.2, 0);
    const gl = renderer.getContext();
    const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    const picture = (withRing, withField) => {
        [ring.visible, field.mesh.visible] = [withRing, withField];
        renderer.render(scene, camera);
        const bytes = new Uint8Array(4 * w * h);
        gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
        return (x, y) => bytes.subarray(4 * ((h - 1 - y) * w + x)).slice(0, 3);
    };
    const [polygons, alone, both] = [picture(true, false), picture(false, true), picture(true, true)];
    const seen = model.orbit(0.6, 0.4, { width: w, height: h });
    const layer = await model.layer(seen, { quality: 1 });
    const caster = new Raycaster();
    const far = (x, y) => {
        caster.setFromCamera(new Vector2(2 * (x + 0.5) / w - 1, 1 - 2 * (y + 0.5) / h), camera);
        return caster.intersectObject(ring)[0]?.distance ?? Infinity;
    };
    const found = { ring: 0, model: 0, wrong: [] };
    for (let y = 4; y < h - 4; y += 5) {
        for (let x = 4; x < w - 4; x += 5) {
            // Not at edges, where pixels are blended.
            const around = [[-4, 0], [4, 0], [0, -4], [0, 4], [0, 0]];
            if (far(x, y) === Infinity) continue;
            const rings = around.map(([a, b]) => far(x + a, y + b));
            if (rings.includes(Infinity)) continue;
            const places = around.map(([a, b]) => (y + b) * w + x + a);
            if (places.some((i) => layer.pixels[4 * i + 3] < 255)) continue;
            const picked = await model.pick(x + 0.5, y + 0.5, seen);
            const depths = [picked?.depth ?? Infinity, ...places.map((i) => layer.depth[i])];
            const gap = 0.05 * model.info.size;
            const isRing = Math.max(...rings) + gap < Math.min(...depths);
            const isModel = Math.max(...depths) + gap < Math.min(...rings);
            if (!isRing && !isModel) continue;
            found[isRing ? 'ring' : 'model'] += 1;
            const expected = (isRing ? polygons : alone)(x, y);
            const other = (isRing ? alone : polygons)(x, y);
            const shown = both(x, y);
            const off = (a, b) => Math.max(...a.map((v, i) => Math.abs(v - b[i])));
            if (off(expected, other) < 9 || off(shown, expected) > 2) {
                found.wrong.push([x, y, ...shown, ...expected]);
            }
        }
    }
    return found;
})()";

#[test]
fn a_field_among_polygons() {
    let Some(dist) = common::dist() else { return };
    let Some(site) = site(&dist) else { return };
    let home = common::server::serve(site.path());
    let Some(mut page) = Page::with_webgl(&home, [240, 240]) else { return };
    page.go(&home);
    page.until("import('/main.js').then(({ field }) => field.mesh.visible || message.textContent)");
    let found = page.value(COUNT);
    println!("{found}");
    crate::keep(&mut page, "three");
    assert_eq!(found["wrong"], serde_json::json!([]));
    for front in ["ring", "model"] {
        assert!(found[front].as_u64() > Some(10), "{found}");
    }
    assert_eq!(page.value("message.textContent"), "");
    assert_eq!(page.complaints, [""; 0]);
}
