//! Metashape's XML.

use super::{all, near};
use crate::fixture::{Folder, unit};
use crate::mutated::mutations;
use crate::refusals::refusal;

const FRAME: &str = r#"<sensor id="0" label="a camera" type="frame">
    <resolution width="16" height="8"/>
    <calibration type="frame" class="initial"><resolution width="16" height="8"/><f>99</f>
    </calibration>
    <calibration type="frame" class="adjusted"><resolution width="16" height="8"/>
    <f>8</f><cx>1</cx><cy>-1</cy><b1>2</b1><b2>4</b2><k1>0.1</k1><p1>0.01</p1><p2>0.02</p2>
    </calibration></sensor>"#;

/// Leads from right, down, forward to right, forward, up, twice as large, around (1, 2, 3).
const COMPONENT: &str = r#"<component id="0" label="Component 1"><transform>
    <rotation locked="0">1 0 0 0 0 1 0 -1 0</rotation><translation>1 2 3</translation>
    <scale locked="0">2</scale></transform></component>"#;

/// Three cameras, 2 away from the origin at the back, right and left, and one that is not aligned.
const CAMERAS: &str = r#"
    <camera id="0" sensor_id="0" component_id="0" label="a">
    <transform>1 0 0 0  0 1 0 0  0 0 1 -2  0 0 0 1</transform><orientation>1</orientation></camera>
    <group id="0" label="others" type="folder">
    <camera id="1" sensor_id="0" component_id="0" label="b.JPG">
    <transform>0 0 -1 2  0 1 0 0  1 0 0 0  0 0 0 1</transform></camera>
    <camera id="2" sensor_id="0" component_id="0" label="c">
    <transform>0 0 1 -2  0 1 0 0  -1 0 0 0  0 0 0 1</transform></camera></group>
    <camera id="3" sensor_id="0" label="d"/>"#;

fn document(sensor: &str, components: &str, cameras: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<document version=\"2.0.0\">\n\
         <chunk label=\"Chunk 1\" enabled=\"true\"><sensors next_id=\"1\">{sensor}</sensors>\
         <components next_id=\"1\" active_id=\"0\">{components}</components>\
         <cameras next_id=\"4\">{cameras}</cameras></chunk></document>"
    )
}

fn export(text: &str) -> Folder {
    let folder = Folder::new();
    folder.write("cameras.xml", text);
    for name in ["images/a.jpg", "images/b.png", "c.jpg", "d.jpg"] {
        folder.image(name, [16, 8], 9);
    }
    folder
}

fn plain() -> String {
    document(FRAME, COMPONENT, CAMERAS)
}

/// The ray of camera a through a pixel.
fn ray(text: &str, [x, y]: [f32; 2]) -> pocketnerf_core::Ray {
    let dataset = all(&export(text));
    assert_eq!((dataset.format, dataset.views.len()), ("metashape", 3));
    assert_eq!(dataset.views[0].name, "images/a.jpg");
    let view = &dataset.views[0];
    let ray = view.ray(x, y);
    let p = [0, 1, 2].map(|a| ray.origin[a] + 2.0 * ray.direction[a]);
    let back = view.project(p).unwrap();
    assert!((back[0] - x).abs() < 1e-4 && (back[1] - y).abs() < 1e-4, "{back:?}");
    ray
}

/// The world of the component has cameras 4 away from (1, 2, 3), at -y, +x and -x, with z up.
/// Moved and turned, their side is +x: camera a is at (4, 0, 0), looks along -x, right is +y.
#[test]
fn hand_computed_rays() {
    // 0.5 to the right: x' = 0.5 (1 + 0.1 0.25) + P1 0.75 = 0.52, y' = P2 0.25 = 0.005,
    // u = 8 + 1 + 0.52 (8 + 2) + 0.005 4, v = 4 - 1 + 0.005 8.
    let frame = ray(&plain(), [14.22, 3.04]);
    assert!(near(frame.origin, [4.0, 0.0, 0.0]), "{frame:?}");
    assert!(near(frame.direction, unit([-1.0, 0.5, 0.0])), "{frame:?}");
    // The same for the angle 0.5.
    let fisheye = plain().replace("type=\"frame\"", "type=\"fisheye\"");
    let fisheye = ray(&fisheye, [14.22, 3.04]).direction;
    assert!(near(fisheye, [-(0.5f32.cos()), 0.5f32.sin(), 0.0]), "{fisheye:?}");
    let sensor = r#"<sensor id="0" type="spherical"><resolution width="16" height="8"/></sensor>"#;
    let spherical = document(sensor, COMPONENT, CAMERAS);
    // A quarter turn to the right, and an eighth up.
    let right = ray(&spherical, [12.0, 4.0]).direction;
    assert!(near(right, [0.0, 1.0, 0.0]), "{right:?}");
    let up = ray(&spherical, [8.0, 2.0]).direction;
    assert!(near(up, unit([-1.0, 0.0, 1.0])), "{up:?}");
    let behind = ray(&spherical, [0.5, 4.0]).direction;
    let angle = std::f32::consts::PI / 16.0;
    assert!(near(behind, [angle.cos(), -angle.sin(), 0.0]), "{behind:?}");
}

#[test]
fn what_is_left_out_is_said() {
    let folder = export(&plain());
    folder.remove("c.jpg");
    let dataset = all(&folder);
    assert_eq!(dataset.views.len(), 2);
    assert_eq!(
        dataset.notes[..2],
        [
            "1 of 3 cameras have no photograph (first: c): they are left out",
            "1 of 4 cameras are not aligned: left out",
        ]
    );
    // Two components that do not say where they are.
    let text =
        document(FRAME, "", &CAMERAS.replacen("component_id=\"0\"", "component_id=\"1\"", 1));
    let dataset = all(&export(&text));
    let names: Vec<_> = dataset.views.iter().map(|view| view.name.as_str()).collect();
    assert_eq!(names, ["images/b.png", "c.jpg"]);
    assert!(dataset.notes[0].starts_with("2 components without a common world: the one with"));
    let text = plain().replace("label=\"c\"", "label=\"c\" enabled=\"0\"");
    let notes = all(&export(&text)).notes;
    assert!(notes.contains(&"1 cameras are disabled: they are left out".to_owned()), "{notes:?}");
}

#[test]
fn wrong_and_partial_exports() {
    let hint = "; align the photographs in Metashape and export its cameras as Agisoft XML";
    let unaligned = CAMERAS.replace("transform>", "other>");
    for (text, expected) in [
        (document(FRAME, COMPONENT, &unaligned), "no aligned camera"),
        (document("", COMPONENT, CAMERAS), "no aligned camera"),
        (plain().replace("<f>8</f>", ""), "sensor 0: no <f>, expected a focal length in pixels"),
        (plain().replace("<f>8</f>", "<f>-8</f>"), {
            "sensor 0: its focal length is -6, expected pixels above 0"
        }),
        (plain().replace("<f>8</f>", "<f>8 9</f>"), "sensor 0: <f> does not hold 1 finite numbers"),
        (plain().replace("</p2>", "</p2><p3>1</p3>"), {
            "sensor 0: p3 and p4, expected a calibration without them"
        }),
        (plain().replace("type=\"frame\"", "type=\"cylindrical\""), {
            "sensor 0: a cylindrical sensor, expected frame, fisheye or spherical"
        }),
        (plain().replace("1 0 0 0  0 1", "1 0 0 0  0"), {
            "camera \"a\": <transform> does not hold 16 finite numbers"
        }),
        (plain().replace("</chunk>", "</chunk><chunk/>"), "several chunks, expected one"),
        (plain().replace("\">2</scale>", "\">0</scale>"), {
            "component 0: a scale of 0, expected a number above 0"
        }),
    ] {
        let message = refusal(export(&text).path());
        assert_eq!(message, format!("D/cameras.xml: {expected}{hint}"));
    }
    let message = refusal(export(&plain().replace("</chunk>", "")).path());
    assert!(message.starts_with("D/cameras.xml: not valid XML: "), "{message}");
    let entity = plain().replace("<document", "<!DOCTYPE a [<!ENTITY b \"c\">]><document");
    let message = refusal(export(&entity).path());
    assert!(message.starts_with("D/cameras.xml: not valid XML: "), "{message}");
    let sheared = plain().replace("1 0 0 0  0 1 0 0", "1 1 0 0  0 1 0 0");
    let message = refusal(export(&sheared).path());
    assert!(message.contains("the pose's 3x3 part is not a rotation"), "{message}");
    let folder = export(&plain());
    folder.write("more.xml", plain());
    let several = "D: several files of cameras: cameras.xml, more.xml; keep one of them";
    assert_eq!(refusal(folder.path()), several);
    folder.remove("more.xml");
    folder.image("images/sub/c.png", [16, 8], 9);
    folder.image("images/other/c.png", [16, 8], 9);
    folder.remove("c.jpg");
    assert_eq!(
        refusal(folder.path()),
        format!(
            "D/cameras.xml: \"c\" may be images/other/c.png or images/sub/c.png, expected one \
             photograph of that name{hint}"
        )
    );
    ["images/a.jpg", "images/b.png"].iter().for_each(|name| folder.remove(name));
    folder.remove("images/sub/c.png");
    assert_eq!(
        refusal(folder.path()),
        "D/cameras.xml: 2 of its 3 cameras have no photograph (first: a); put the photographs \
         beside it, or into images there"
    );
}

/// Elements inside elements inside elements: neither the stack nor memory overflows.
#[test]
fn a_deep_document() {
    let deep = ["<a>".repeat(200_000), "</a>".repeat(200_000)].concat();
    let text = plain().replace("</chunk>", &format!("{deep}</chunk>"));
    let folder = export(&text);
    let options = pocketnerf_train::dataset::LoadOptions::default();
    match pocketnerf_train::dataset::load_with(
        folder.path(),
        pocketnerf_train::dataset::Split::Train,
        &options,
    ) {
        Ok(dataset) => assert_eq!(dataset.views.len(), 2),
        Err(error) => assert!(error.to_string().contains("not valid XML"), "{error}"),
    }
}

#[test]
fn damaged_files() {
    mutations(&export(&plain()), &["cameras.xml"], 10_000);
}
