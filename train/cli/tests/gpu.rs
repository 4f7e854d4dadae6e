//! `--device gpu`, as a user sees it; a software GPU will do. Without any GPU these tests
//! say so, or fail where `POCKETNERF_REQUIRE_TOOLS` is set.

use std::path::Path;
use std::process::{Command, Output};

use pocketnerf_gpu::{Gpu, Software, adapters};
use pocketnerf_train::lens::Lens;
use pocketnerf_train::picture::image_file;
use pocketnerf_train::picture::{Antialias, Device, Renderer, Settings};
use serde_json::Value;

const SOFTWARE: &str = "POCKETNERF_SOFTWARE_GPU";
/// A software GPU takes half a minute to compile the program of a model of the usual shape.
const SMALL: [&str; 4] = ["--n-levels", "4", "--hidden-width", "16"];

fn program(folder: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pocketnerf"));
    command.current_dir(folder).args(arguments).env_remove(SOFTWARE);
    command.envs(environment.iter().copied()).output().expect("the program starts")
}

/// Its JSON.
fn json(folder: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> Value {
    let output = program(folder, &[arguments, &["--json"]].concat(), environment);
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {error}");
    serde_json::from_slice(&output.stdout).expect("one object")
}

/// A folder with a small model of the built-in scene.
fn with_model() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let train =
        ["train", "builtin", "--out", "m.pnerf", "--downscale-factor", "8", "--steps", "60"];
    json(folder.path(), &[&train[..], &SMALL].concat(), &[]);
    folder
}

/// Whether there is something to test.
fn has_gpu() -> bool {
    let has = !adapters().is_empty();
    if !has {
        let required = std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_some();
        assert!(!required, "no GPU, not even in software, and POCKETNERF_REQUIRE_TOOLS is set");
        println!("no GPU, not even in software: nothing is tested");
    }
    has
}

fn warnings(object: &Value) -> String {
    object["warnings"].to_string()
}

#[test]
fn pictures_and_scores_are_those_of_the_cpu() {
    if !has_gpu() {
        return;
    }
    let folder = with_model();
    let run = |arguments: &[&str], device: &str| {
        json(folder.path(), &[arguments, &["--device", device]].concat(), &[(SOFTWARE, "1")])
    };
    let eval = ["eval", "m.pnerf", "builtin", "--downscale-factor", "8"];
    for quality in ["1", "0.5"] {
        let eval = [&eval[..], &["--quality", quality, "--antialias", "2"]].concat();
        let [gpu, cpu] = ["gpu", "cpu"].map(|device| run(&eval, device));
        assert_eq!((gpu["device"].as_str(), cpu["device"].as_str()), (Some("gpu"), Some("cpu")));
        let psnr = |object: &Value, name: &str| object[name].as_f64().expect("a number");
        for name in ["psnr", "psnr_min", "depth_error"] {
            let (gpu, cpu) = (psnr(&gpu, name), psnr(&cpu, name));
            assert!((gpu - cpu).abs() <= 0.02, "{name} in quality {quality}: {gpu}, {cpu}");
        }
        assert_eq!(gpu["views"], cpu["views"]);
    }
    let render = ["render", "m.pnerf", "--width", "50", "--height", "40", "--depth", "--out"];
    let [gpu, cpu] = ["gpu", "cpu"].map(|device| {
        let picture = format!("{device}.png");
        let object = run(&[&render[..], &[&picture]].concat(), device);
        assert_eq!(object["device"], device);
        let read = |name: String| image_file::open(folder.path().join(name)).expect("a picture");
        (read(picture).into_rgb8(), read(format!("{device}.depth.png")).into_luma16())
    });
    assert_eq!((gpu.0.dimensions(), gpu.1.dimensions()), ((50, 40), (50, 40)));
    let far_off = gpu.0.iter().zip(cpu.0.iter()).filter(|(a, b)| a.abs_diff(**b) > 12).count();
    // The CPU interpolates pixels.
    assert!(far_off < 60, "{far_off} of 6000 values");
    assert!(gpu.1.iter().any(|depth| *depth > 0) && gpu.1.contains(&0));
    // What refines is the CPU's, and said to be.
    let refined = run(&["render", "m.pnerf", "--deadline-ms", "50", "--width", "40"], "gpu");
    assert_eq!(refined["device"], "cpu");
    assert!(warnings(&refined).contains("--deadline-ms is for the CPU"), "{refined}");
}

/// A lens bends rays, and a pixel has several.
#[test]
fn lenses_bend_rays_on_both() {
    if !has_gpu() {
        return;
    }
    let bytes = include_bytes!("../../../embed-demo/still-life.pnerf");
    let bytes = pocketnerf_formats::unpacked(bytes).expect("a model");
    let file = pocketnerf_formats::open(&bytes).expect("a model");
    let own = file.about.camera.expect("a camera").camera();
    let camera = own.downscaled(own.width / 48);
    let lens = Lens::open_cv([0.3, -0.1, 0.0, 0.0], [0.01, 0.0]);
    let settings = Settings {
        quality: 1.0,
        depth: true,
        antialias: Antialias::Rays(2),
        ..Settings::default()
    };
    let gpu = Device::Gpu(Gpu::open(Software::Allowed).expect("a GPU"));
    let render = |device: &Device, lens: &Lens| {
        let mut renderer = Renderer::on(device, &file.model, &settings);
        let picture = renderer.render_through(&camera, lens).expect("a picture").clone();
        assert_eq!(renderer.fallback(), None);
        picture
    };
    let [found, expected] = [&gpu, &Device::Cpu].map(|device| render(device, &lens));
    let straight = render(&Device::Cpu, &Lens::Pinhole);
    let psnr = |other: &[f32]| {
        let squares = found.rgba.iter().zip(other).map(|(a, b)| f64::from(a - b).powi(2));
        -10.0 * (squares.sum::<f64>() / other.len() as f64).log10()
    };
    assert_eq!((found.width, found.height), (expected.width, expected.height));
    assert!(psnr(&expected.rgba) > 50.0, "{} dB", psnr(&expected.rgba));
    assert!(psnr(&straight.rgba) < 30.0, "{} dB", psnr(&straight.rgba));
    assert_eq!(found.stats.rays, 4 * u64::from(camera.width * camera.height));
    let far_off = found.depth.iter().zip(&expected.depth).filter(|(a, b)| (*a - *b).abs() > 0.02);
    assert!(far_off.count() < found.depth.len() / 50);
}

#[test]
fn without_a_gpu_the_cpu_renders() {
    let folder = with_model();
    // No driver can be loaded.
    let none = [("VK_DRIVER_FILES", "/nonexistent"), ("VK_ICD_FILENAMES", "/nonexistent")];
    let render = |out: &str, device: &str, environment: &[(&str, &str)]| {
        let arguments = ["render", "m.pnerf", "--width", "40", "--out", out, "--device", device];
        let object = json(folder.path(), &arguments, environment);
        (object, std::fs::read(folder.path().join(out)).expect("a picture"))
    };
    let (cpu, expected) = render("cpu.png", "cpu", &[]);
    assert_eq!(warnings(&cpu), "[]");
    let (object, picture) = render("none.png", "gpu", &none);
    assert_eq!(object["device"], "cpu");
    assert!(warnings(&object).contains("no GPU was found: pictures are rendered on the CPU"));
    assert!(picture == expected);
    // A software GPU is slower than this program on the CPU.
    let software = adapters().first().is_some_and(|name| name.contains("llvmpipe"));
    if software {
        let (object, picture) = render("software.png", "gpu", &[]);
        assert!(warnings(&object).contains("no GPU was found but llvmpipe"), "{object}");
        assert!(picture == expected);
    }
    let list = |environment: &[(&str, &str)]| json(folder.path(), &["info", "--gpus"], environment);
    assert_eq!(list(&none)["gpus"], serde_json::json!([]));
    assert_eq!(list(&[])["gpus"], serde_json::json!(adapters()));
    let wrong = program(folder.path(), &["render", "m.pnerf", "--device", "tpu"], &[]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&wrong.stderr).contains("[possible values: cpu, gpu]"));
}

/// A run on a GPU, gone on with on the CPU from its checkpoint.
#[test]
fn training_goes_on_wherever_it_began() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let small = ["--log2-hashmap-size", "9", "--batch-rays", "64"];
    let train = ["train", "builtin", "--downscale-factor", "16", "--steps", "48"];
    let train = [&train[..], &small, &SMALL, &["--save-every", "1h"]].concat();
    let on = |device: &str, out: &str| {
        let more = ["--out", out, "--device", device];
        json(folder.path(), &[&train[..], &more].concat(), &[(SOFTWARE, "1")])
    };
    let [gpu, cpu] = [on("gpu", "gpu.pnerf"), on("cpu", "cpu.pnerf")];
    assert_eq!((gpu["device"].as_str(), cpu["device"].as_str()), (Some("gpu"), Some("cpu")));
    let psnr = |object: &Value| object["train_psnr"].as_f64().expect("a number");
    assert!((psnr(&gpu) - psnr(&cpu)).abs() < 1.0, "{} {}", psnr(&gpu), psnr(&cpu));
    let refused = program(
        folder.path(),
        &[&train[..], &["--out", "c.pnerf", "--device", "gpu"]].concat(),
        &[],
    );
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    let is_software = adapters().iter().all(|name| name.contains("llvmpipe"));
    assert!(
        !is_software || said.contains("software GPU") && said.contains("the CPU trains"),
        "{said}"
    );
    assert!(refused.status.success(), "{said}");
    // The end of a run is gone on from: there is nothing left to do but to write the model again.
    let resumed = ["train", "builtin", "--downscale-factor", "16", "--resume", "gpu.ckpt.pnerf"];
    let resumed = [&resumed[..], &["--out", "again.pnerf", "--device", "cpu"]].concat();
    let object = json(folder.path(), &resumed, &[(SOFTWARE, "1")]);
    assert_eq!((object["steps"].as_u64(), object["device"].as_str()), (Some(48), Some("cpu")));
    let read = |name: &str| std::fs::read(folder.path().join(name)).expect("a model");
    assert_eq!(read("again.pnerf").len(), read("gpu.pnerf").len());
}

/// Voxels have no program for GPUs: the CPU renders and trains, and it is said.
#[test]
fn voxels_are_left_to_the_cpu() {
    if !has_gpu() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let train = "train builtin --method plenoxels --voxels 16 --downscale-factor 16 --steps 10";
    let run = |arguments: &str| {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        json(folder.path(), &arguments, &[(SOFTWARE, "1")])
    };
    let trained = run(&format!("{train} --out gpu.pnerf --device gpu"));
    assert_eq!(trained["device"], "cpu");
    let why = warnings(&trained);
    assert!(why.contains("GPUs do not train this kind of field: the CPU trains"), "{why}");
    run(&format!("{train} --out cpu.pnerf --device cpu"));
    let read = |name: &str| std::fs::read(folder.path().join(name)).expect("a file");
    assert!(read("gpu.pnerf") == read("cpu.pnerf"));
    let rendered = run("render gpu.pnerf --width 20 --height 20 --out p.png --device gpu");
    assert_eq!(rendered["device"], "cpu");
    let why = warnings(&rendered);
    assert!(why.contains("GPUs do not render this kind of field: pictures are rendered"), "{why}");
}
