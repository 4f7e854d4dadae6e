//! DeepVoxels scenes.

use pocketnerf_train::dataset::{Split, inspect, load};

use crate::fixture::{Folder, near, unit};
use crate::refusals::refusal;

/// OpenCV axes, right, down, forward: at (0, -3, 0), looking along +y, z up.
const FRONT: &str = "1 0 0 0\n0 0 1 -3\n0 -1 0 0\n0 0 0 1\n";
/// At (3, 0, 0), looking along -x, on one line.
const SIDE: &str = "0 0 -1 3 1 0 0 0 0 -1 0 0 0 0 0 1";
/// Focal length 4 where images are 4 pixels high: 2 in images of 4x2.
const CAMERA: &str = "4.0 9 9 0.\n0. 0. 0.\n1.\n0.\n4 9\n";

fn scene() -> Folder {
    let folder = Folder::new();
    for (split, poses) in
        [("train", &[FRONT, SIDE][..]), ("test", &[SIDE]), ("validation", &[FRONT])]
    {
        folder.write(&format!("{split}/cube/intrinsics.txt"), CAMERA);
        for (i, pose) in poses.iter().enumerate() {
            folder.write(&format!("{split}/cube/pose/{i:06}.txt"), pose);
            folder.image(&format!("{split}/cube/rgb/{i:06}.png"), [4, 2], 0);
        }
    }
    folder
}

#[test]
fn a_hand_computed_ray() {
    let folder = scene();
    let train = load(folder.path(), Split::Train, 1).unwrap();
    assert_eq!((train.format, train.views.len(), train.has_alpha), ("deepvoxels", 2, false));
    // A hemisphere of radius 3, on white.
    assert_eq!((train.bounds, train.background), (Some([2.0, 4.0]), Some([1.0; 3])));
    let view = &train.views[0];
    assert_eq!(view.name, "train/cube/rgb/000000.png");
    let ray = view.ray(0.5, 0.5);
    // 1.5 pixels left and 0.5 up of the middle.
    assert!(near(ray.origin, [0.0, -3.0, 0.0]), "{ray:?}");
    assert!(near(ray.direction, unit([-0.75, 1.0, 0.25])), "{ray:?}");
    let middle = train.views[1].ray(2.0, 1.0);
    assert!(near(middle.origin, [3.0, 0.0, 0.0]) && near(middle.direction, [-1.0, 0.0, 0.0]));
    // The hemisphere is that of the training cameras, in every split.
    let test = load(folder.path(), Split::Test, 1).unwrap();
    assert_eq!((test.views.len(), test.bounds), (1, train.bounds));
    let val = load(folder.path(), Split::Val, 1).unwrap();
    assert_eq!(val.views[0].name, "validation/cube/rgb/000000.png");
}

#[test]
fn any_of_its_folders() {
    let folder = scene();
    let expected = load(folder.path(), Split::Test, 1).unwrap().fingerprint();
    for inside in ["train", "test", "train/cube", "validation/cube"] {
        let found = load(&folder.path().join(inside), Split::Test, 1).unwrap();
        assert_eq!(found.fingerprint(), expected, "{inside}");
    }
    let report = inspect(folder.path()).unwrap();
    let counts: Vec<_> = report.splits.iter().map(|s| (s.split, s.images_found)).collect();
    assert_eq!(counts, [("train", 2), ("val", 1), ("test", 1)]);
    assert_eq!((report.bounds, report.hold_every), (Some([2.0, 4.0]), None));
    std::fs::remove_dir_all(folder.path().join("validation")).unwrap();
    let val = load(folder.path(), Split::Val, 1).unwrap();
    assert_eq!(val.views[0].name, "test/cube/rgb/000000.png");
}

#[test]
fn world_to_camera_poses() {
    let folder = scene();
    // The inverse of FRONT, and the line that says so.
    folder.write("test/cube/pose/000000.txt", "1 0 0 0 0 0 -1 0 0 1 0 3 0 0 0 1");
    folder.write("test/cube/intrinsics.txt", format!("{CAMERA}1\n"));
    let ray = load(folder.path(), Split::Test, 1).unwrap().views[0].ray(2.0, 1.0);
    assert!(near(ray.origin, [0.0, -3.0, 0.0]) && near(ray.direction, [0.0, 1.0, 0.0]), "{ray:?}");
}

#[test]
fn refusals() {
    type Break = fn(&Folder);
    let pose = "train/cube/pose/000001.txt";
    let cases: [(Break, String); 11] = [
        (|f| f.write("train/cube/pose/000001.txt", "1 2 3"), format!("D/{pose}: 3 numbers; exp")),
        (
            |f| f.write("train/cube/pose/000001.txt", ""),
            format!("D/{pose}: 0 numbers; expected 16"),
        ),
        (
            |f| f.write("train/cube/pose/000001.txt", SIDE.replace('3', "nan")),
            format!("D/{pose}: frame 1 (\"000001.txt\"): the pose holds a number that is not fin"),
        ),
        (
            |f| f.write("train/cube/pose/000001.txt", SIDE.replace("-1 3", "1 3")),
            format!("D/{pose}: frame 1 (\"000001.txt\"): the pose's 3x3 part is not a rotation"),
        ),
        (
            |f| f.write("train/cube/intrinsics.txt", "4 9 9 0\n"),
            "D/train/cube/intrinsics.txt: 1 lines without them; expected a focal length".to_owned(),
        ),
        (
            |f| f.write("train/cube/intrinsics.txt", CAMERA.replace("4.0", "nan")),
            "D/train/cube/intrinsics.txt: focal length NaN and height 4; expected".to_owned(),
        ),
        (
            |f| f.remove("train/cube/rgb/000000.png"),
            "D/train/cube/rgb: 1 images, but D/train/cube/pose has 2 poses; expected one"
                .to_owned(),
        ),
        (
            |f| {
                f.remove("train/cube/rgb/000000.png");
                f.image("train/cube/rgb/000007.png", [4, 2], 0);
            },
            "D/train/cube/rgb/000000: no such image".to_owned(),
        ),
        (
            |f| f.image("train/cube/rgb/000001.png", [2, 2], 0),
            "D/train/cube/rgb/000001.png: 2x2 pixels, but D/train/cube/rgb/000000.png has 4x2"
                .to_owned(),
        ),
        (
            |f| std::fs::remove_dir_all(f.path().join("train")).unwrap(),
            "D/train/cube: not there, so there is no train split; this dataset has validation, test"
                .to_owned(),
        ),
        (
            |f| {
                f.write("train/vase/pose/0.txt", "");
                f.write("train/vase/intrinsics.txt", "");
            },
            "D: several scenes: cube, vase; give the folder of one, as train/SCENE".to_owned(),
        ),
    ];
    for (spoil, start) in cases {
        let folder = scene();
        spoil(&folder);
        let message = refusal(folder.path());
        assert!(message.starts_with(&start), "{message}, expected {start}");
    }
    let folder = scene();
    for pose in ["000000", "000001"] {
        folder.remove(&format!("train/cube/pose/{pose}.txt"));
        folder.remove(&format!("train/cube/rgb/{pose}.png"));
    }
    assert!(
        refusal(folder.path())
            .starts_with("D/train/cube/pose: no .txt file; expected 16 numbers an image")
    );
}
