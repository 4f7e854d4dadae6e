//! RealityCapture's CSV.

use super::{all, near};
use crate::fixture::{Folder, unit};
use crate::mutated::mutations;
use crate::refusals::refusal;

const NAMES: &str = "#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2";

/// Three photographs of what is at (500001, 4000002, 3) on a map, 4 away in the south, east and
/// west, looking north, west and east with the horizon level.
fn table() -> String {
    let optics = "18,0.0625,-0.0625,0.1,0,0,0,0.02,0.01";
    format!(
        "{NAMES}\n\
         a.jpg,500001,3999998,3,0,90,0,{optics}\n\
         b.jpg,500005,4000002,3,270,90,0,{optics}\n\
         \"c d.jpg\",499997,4000002,3,90,90,0,{optics}\n"
    )
}

fn export(text: &str) -> Folder {
    let folder = Folder::new();
    folder.write("cameras.csv", text);
    for name in ["a.jpg", "images/b.png", "flight/c d.jpg"] {
        folder.image(name, [16, 8], 9);
    }
    folder
}

/// Moved and turned, the side of the cameras is +x: camera a is at (4, 0, 0), looks along -x, and
/// right is +y.
#[test]
fn hand_computed_rays() {
    let dataset = all(&export(&table()));
    assert_eq!((dataset.format, dataset.views.len()), ("reality-capture", 3));
    let view = &dataset.views[0];
    assert_eq!((view.camera.focal, view.camera.center), ([8.0, 8.0], [9.0, 3.0]));
    // 0.5 to the right: 0.5 (1 + 0.1 0.25) + t2 0.75 = 0.52, and t1 0.25 = 0.005 below.
    let ray = view.ray(9.0 + 0.52 * 8.0, 3.0 + 0.005 * 8.0);
    assert!(near(ray.origin, [4.0, 0.0, 0.0]), "{ray:?}");
    assert!(near(ray.direction, unit([-1.0, 0.5, 0.0])), "{ray:?}");
    // b was in the east, where a's right is.
    let east = &dataset.views[1];
    assert!(near(east.camera.position(), [0.0, 4.0, 0.0]), "{:?}", east.camera.position());
    // Columns in another order, and only those that must be there.
    let text = "#name,f,x,y,alt,roll,pitch,heading\n\
                a.jpg,18,0,-4,0,0,90,0\nb.jpg,18,4,0,0,0,90,270\nc d.jpg,18,-4,0,0,0,90,90\n";
    let view = &all(&export(text)).views[0];
    assert!(near(view.ray(12.0, 4.0).direction, unit([-1.0, 0.5, 0.0])));
}

#[test]
fn wrong_and_partial_exports() {
    let hint = "; export Registration from RealityCapture as \"Internal/External camera \
                parameters\", in a local coordinate system";
    let table = table();
    for (text, expected) in [
        (format!("{NAMES}\n"), "no camera, expected a line for each"),
        (NAMES.replace(",f,", ",F1,"), {
            "no column f, expected name, x, y, alt, heading, pitch, roll, f"
        }),
        (NAMES.replace(',', ";"), "columns between semicolons, expected commas"),
        (table.replace(",0.02,0.01\nb", ",0.02\nb"), "line 2: 15 values, expected 16"),
        (table.replace("270", "west"), "line 3: heading is \"west\", expected a number"),
        (table.replace("270", "inf"), "line 3: heading is \"inf\", expected a number"),
        (table.replace("b.jpg", "a.jpg"), "a.jpg is there twice, expected once"),
        (table.replacen("18", "0", 1), "a.jpg: its focal length is 0, expected pixels above 0"),
        (table.replacen("0.1", "1e9", 1), {
            "a.jpg: a lens coefficient is 1000000000, expected a small one"
        }),
    ] {
        let message = refusal(export(&text).path());
        assert_eq!(message, format!("D/cameras.csv: {expected}{hint}"));
    }
    let folder = export(&table);
    folder.remove("a.jpg");
    folder.remove("images/b.png");
    assert_eq!(
        refusal(folder.path()),
        "D/cameras.csv: 2 of its 3 cameras have no photograph (first: a.jpg); put the photographs \
         beside it, or into images there"
    );
    // Positions in degrees.
    let degrees = table
        .replace("500001,3999998,3", "14.40001,50.10001,3")
        .replace("500005,4000002,3", "14.40005,50.10004,9")
        .replace("499997,4000002,3", "14.39997,50.10004,3");
    let notes = all(&export(&degrees)).notes;
    assert!(notes[0].starts_with("x and y differ by little, alt by much: are they degrees?"));
}

#[test]
fn damaged_files() {
    mutations(&export(&table()), &["cameras.csv"], 10_000);
}
