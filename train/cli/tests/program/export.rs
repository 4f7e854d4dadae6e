//! `pocketnerf export`.

use std::path::Path;
use std::process::{Command, Output};

use pocketnerf_formats::{About, PhotographList, Precision};
use pocketnerf_train::builtin;
use pocketnerf_train::dataset::Split;
use serde_json::Value;

const MODEL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../embed-demo/still-life.pnerf");

fn export(options: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pocketnerf"))
        .args(["export", MODEL, "--json"])
        .args(options)
        .output()
        .unwrap()
}

fn json(options: &[&str]) -> Value {
    let output = export(options);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refused(options: &[&str]) -> String {
    let output = export(options);
    assert!(!output.status.success() && output.stdout.is_empty());
    String::from_utf8(output.stderr).unwrap()
}

fn text(path: &Path) -> String {
    path.display().to_string()
}

/// The still life's surface is known.
#[test]
fn the_surface_is_where_the_scene_is() {
    let folder = tempfile::tempdir().unwrap();
    let [mesh, points] = ["mesh.glb", "points.ply"].map(|name| text(&folder.path().join(name)));
    let from_data = ["--data", "builtin", "--downscale-factor", "4", "--resolution", "96"];
    let all = [&from_data[..], &["--mesh", &mesh, "--points", &points]].concat();
    let said = json(&all);
    let error = &said["surface_error"];
    let [chamfer, degrees] =
        ["chamfer_percent", "normal_degrees"].map(|name| error[name].as_f64().unwrap());
    assert!(chamfer < 0.5 && degrees < 15.0, "{error}");
    // Cameras stand upright on z.
    assert_eq!((&said["up"], &said["cameras"]), (&serde_json::json!([0.0, 0.0, 1.0]), &60.into()));
    let glb = std::fs::read(&mesh).unwrap();
    let cloud = std::fs::read(&points).unwrap();
    assert_eq!(said["bytes"], glb.len() + cloud.len());
    let n = format!("element vertex {}\n", said["vertices"]);
    assert!(
        glb.starts_with(b"glTF\x02\0\0\0") && cloud.windows(n.len()).any(|w| w == n.as_bytes())
    );
    // The same again, byte for byte, on one thread.
    let again = text(&folder.path().join("again.glb"));
    json(&[&from_data[..], &["--mesh", &again, "--threads", "1"]].concat());
    assert!(std::fs::read(&again).unwrap() == glb);
}

/// Without a dataset, from all around; and no more than was asked for.
#[test]
fn a_box_of_a_closed_surface_without_a_dataset() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = text(&folder.path().join("mesh.ply"));
    let size = ["--resolution", "48", "--mesh", &mesh];
    let whole = json(&[&size[..], &["--watertight"]].concat());
    let corner =
        |object: &Value, corner: usize, axis: usize| object["bounds"][corner][axis].as_f64();
    assert!(corner(&whole, 0, 0) < Some(-0.7) && corner(&whole, 1, 0) > Some(0.7), "{whole}");
    assert_eq!((&whole["surface_error"], &whole["cameras"]), (&Value::Null, &100.into()));
    let part = json(&[&size[..], &["--crop", "-0.2,-2,-2,2,2,2"]].concat());
    assert!(corner(&part, 0, 0) >= Some(-0.2) && corner(&part, 1, 0) > Some(0.7), "{part}");
    // What is cut and closed has no border: with each edge, its other side.
    let crop = ["--watertight", "--crop", "-0.2,-2,-2,0.3,2,2"];
    let closed = json(&[&size[..], &crop].concat());
    let voxels = 2.0 * 1.8 / 48.0;
    assert!(corner(&closed, 0, 0) > Some(-0.2 - voxels), "{closed}");
    assert!(corner(&closed, 1, 0) < Some(0.3 + voxels), "{closed}");
    let triangles = triangles(&std::fs::read(&mesh).unwrap(), &closed);
    let sides = |[a, b, c]: &[u32; 3]| [[*a, *b], [*b, *c], [*c, *a]];
    let mut there: Vec<[u32; 2]> = triangles.iter().flat_map(sides).collect();
    let mut back: Vec<[u32; 2]> = there.iter().map(|[a, b]| [*b, *a]).collect();
    there.sort_unstable();
    back.sort_unstable();
    assert!(there == back && there.len() > 1000);
    let nothing = refused(&[&size[..], &["--crop", "5,5,5,6,6,6"]].concat());
    assert!(
        nothing.contains("no camera sees a surface in this box; give a larger one"),
        "{nothing}"
    );
}

/// A model that stores where its photographs were taken is looked at from there, in any space.
#[test]
fn from_where_photographs_were_taken() {
    let bytes = std::fs::read(MODEL).unwrap();
    let ordinary = pocketnerf_formats::unpacked(&bytes).unwrap();
    let file = pocketnerf_formats::open(&ordinary).unwrap();
    // Those on one side alone: the other side is not seen.
    let views = builtin::dataset(Split::Train, 20).views;
    let cameras: Vec<_> =
        views.iter().map(|view| view.camera).filter(|c| c.position()[0] > 1.0).collect();
    let list = PhotographList::new(&cameras).unwrap();
    let about = About { photographs: Some(list.view()), ..file.about };
    let folder = tempfile::tempdir().unwrap();
    let [model, mesh] = ["one-side.pnerf", "mesh.ply"].map(|name| text(&folder.path().join(name)));
    let written = pocketnerf_formats::write(&file.model, &about, Precision::F16).unwrap();
    std::fs::write(&model, written).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_pocketnerf"))
        .args(["export", &model, "--json", "--resolution", "48", "--mesh", &mesh])
        .output()
        .unwrap();
    let said: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(said["cameras"], cameras.len());
    let whole = json(&["--resolution", "48", "--mesh", &mesh]);
    let area = |said: &Value| said["area"].as_f64().unwrap();
    assert!(area(&said) < 0.9 * area(&whole), "{} {}", area(&said), area(&whole));
}

/// Those of a PLY file.
fn triangles(ply: &[u8], said: &Value) -> Vec<[u32; 3]> {
    let n = said["triangles"].as_u64().unwrap() as usize;
    let (rows, rest) = ply[ply.len() - 13 * n..].as_chunks::<13>();
    assert!(rest.is_empty() && rows.iter().all(|row| row[0] == 3));
    let corner =
        |row: &[u8; 13], i: usize| u32::from_le_bytes(row[1 + 4 * i..][..4].try_into().unwrap());
    rows.iter().map(|row| [0, 1, 2].map(|i| corner(row, i))).collect()
}

/// A simplified mesh, and what it looks like in an image.
#[test]
fn few_triangles_and_an_image() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let size = ["--resolution", "48", "--watertight"];
    let few = ["--triangles", "2500", "--texture=512"];
    let said = json(&[&size[..], &few, &["--mesh", &text(&at("my scene.obj"))]].concat());
    let triangles = said["triangles"].as_u64().unwrap();
    assert!((2490..=2500).contains(&triangles), "{said}");
    assert_eq!(
        (&said["texture"]["size"], &said["warnings"]),
        (&512.into(), &serde_json::json!([]))
    );
    let [used, charts] = ["used", "charts"].map(|name| said["texture"][name].as_f64().unwrap());
    assert!((0.3..1.0).contains(&used) && (6.0..500.0).contains(&charts), "{said}");
    // Three files, whose names for each other have no space.
    let mut names: Vec<_> =
        std::fs::read_dir(folder.path()).unwrap().map(|file| file.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["my scene.obj", "my_scene.mtl", "my_scene.png"]);
    let bytes = names.iter().map(|name| std::fs::read(folder.path().join(name)).unwrap().len());
    assert_eq!(said["bytes"], bytes.sum::<usize>());
    let obj = std::fs::read_to_string(at("my scene.obj")).unwrap();
    assert!(obj.contains("\nmtllib my_scene.mtl\n"));
    assert!(
        std::fs::read_to_string(at("my_scene.mtl")).unwrap().contains("\nmap_Kd my_scene.png\n")
    );
    let image = image::open(at("my_scene.png")).unwrap().into_rgb8();
    assert_eq!(image.dimensions(), (512, 512));
    // Still closed: with each edge, its other side.
    let vertex = |corner: &str| corner.split('/').next().unwrap().parse::<u32>().unwrap();
    let faces = obj.lines().filter_map(|line| line.strip_prefix("f "));
    let faces: Vec<Vec<u32>> = faces.map(|face| face.split(' ').map(vertex).collect()).collect();
    assert_eq!(faces.len() as u64, triangles);
    let side = |i: usize, j: usize| faces.iter().map(move |face| [face[i], face[j]]);
    let sides = |turn: [[usize; 2]; 3]| {
        let mut all: Vec<[u32; 2]> = turn.into_iter().flat_map(|[i, j]| side(i, j)).collect();
        all.sort_unstable();
        all
    };
    assert!(sides([[0, 1], [1, 2], [2, 0]]) == sides([[1, 0], [2, 1], [0, 2]]));
    // Fewer than its parts can have.
    let least =
        json(&[&size[..], &["--triangles", "4", "--mesh", &text(&at("least.glb"))]].concat());
    let warning = least["warnings"][0].as_str().unwrap();
    let expected =
        format!("the surface has {} triangles, expected at most 4: ", least["triangles"]);
    assert!(warning.contains(&expected), "{warning}");
}

#[test]
fn other_files_are_refused_before_any_work() {
    let said = refused(&["--mesh", "scene.stl"]);
    assert!(said.contains("scene.stl: the file's name ends in \"stl\", expected .glb, .ply, .obj"));
    let said = refused(&["--points", "scene.obj"]);
    assert!(said.contains("scene.obj: the file's name ends in \"obj\", expected .ply"), "{said}");
    assert!(refused(&[]).contains("--mesh"));
    let said = refused(&["--mesh", "scene.ply", "--points", "scene.ply"]);
    assert!(said.contains("scene.ply: --mesh and --points, expected a file each"), "{said}");
    assert!(
        refused(&["--mesh", "nowhere/scene.ply"]).contains("the folder nowhere does not exist")
    );
    let said = refused(&["--mesh", "scene.ply", "--texture"]);
    let expected =
        "scene.ply: --texture, but a .ply file has no place for one, expected .glb or .obj";
    assert!(said.contains(expected), "{said}");
    let said = refused(&["--mesh", "scene.glb", "--texture=1000"]);
    assert!(said.contains("expected a power of two from 256 to 8192"), "{said}");
    assert!(refused(&["--points", "scene.ply", "--texture"]).contains("--mesh <FILE>"));
    // What lies beside an OBJ file is looked at too.
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("scene.png")).unwrap();
    let said = refused(&["--mesh", &text(&folder.path().join("scene.obj")), "--texture"]);
    assert!(said.contains("scene.png: this is a folder, expected a file to write"), "{said}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
