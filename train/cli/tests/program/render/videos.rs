//! What the name of the output asks for, and work that goes on where it was interrupted.

use pocketnerf_train::picture::image_file;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::MODEL;
use crate::place::{Place, text};

/// Whether a program is there; where tools are required it has to be.
fn has(tool: &str) -> bool {
    let found = Command::new(tool).arg("-version").output().is_ok();
    let required = std::env::var_os("POCKETNERF_REQUIRE_TOOLS").is_some();
    assert!(found || !required, "{tool} is not installed, and POCKETNERF_REQUIRE_TOOLS is set");
    if !found {
        println!("skipped: {tool} is not installed");
    }
    found
}

fn has_ffmpeg() -> bool {
    has("ffmpeg") && has("ffprobe")
}

/// Codec, width, height, pictures a second and how many of them a video has, as its reader says.
fn probed(video: &Path) -> String {
    let entries = "stream=codec_name,width,height,r_frame_rate,nb_read_frames";
    let mut command = Command::new("ffprobe");
    command.args(["-v", "error", "-count_frames", "-show_entries", entries, "-of", "csv=p=0"]);
    let output = command.arg(video).output().unwrap();
    text(&output.stdout).trim().to_owned()
}

/// The pictures of a video, RGB.
fn decoded(video: &Path) -> Vec<u8> {
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-i"]).arg(video);
    command.args(["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]).output().unwrap().stdout
}

#[test]
fn the_name_decides_what_is_written() {
    let place = Place::new();
    let render = format!("render {MODEL} --width 48 --height 32");
    place.ok(&format!("{render} --out a.jpg"));
    place.ok(&format!("{render} --out a.PNG"));
    let reader = image::ImageReader::open(place.path("a.jpg")).unwrap();
    assert_eq!(reader.format(), Some(image::ImageFormat::Jpeg));
    assert_eq!(place.bytes("a.jpg")[..2], [0xff, 0xd8]);
    assert_eq!(place.bytes("a.PNG")[1..4], *b"PNG");
    let [jpeg, png] = ["a.jpg", "a.PNG"]
        .map(|name| image::load_from_memory(&place.bytes(name)).unwrap().to_rgb8());
    let far = jpeg.iter().zip(png.iter()).map(|(a, b)| u32::from(a.abs_diff(*b)));
    assert!(far.sum::<u32>() < 6 * png.len() as u32);
    for (options, expected) in [
        (
            "--out a.tiff",
            "a.tiff: .tiff, expected .png or .jpg for a picture, .mp4, .webm or .gif for a video",
        ),
        (
            "--out a.png --orbit 3",
            "a.png: 3 pictures, expected the name of a folder or of a video (.mp4, .webm, .gif)",
        ),
        ("--video a.avi", "a.avi: expected a video: .mp4, .webm or .gif"),
        ("--video no/a.mp4", "no/a.mp4: the folder no does not exist; create it first"),
        ("--video v.mp4 --depth", "--depth: a video has none; give a folder with --out too"),
        ("--out v.mp4 --video v.mp4", "v.mp4: --out and --video, expected a name each"),
    ] {
        if has_ffmpeg() || !options.contains("v.mp4") {
            assert_eq!(place.line(&format!("{render} {options}")), expected);
        }
    }
    assert_eq!(place.run(&format!("{render} --video v.mp4 --fps 0")).status.code(), Some(2));
    // Without ffmpeg, how to get it.
    let mut command = place.command(&format!("{render} --video v.mp4"));
    let said = text(&command.env("PATH", place.path("data")).output().unwrap().stderr);
    assert!(said.starts_with("pocketnerf: ffmpeg is not installed; Debian and Ubuntu: "), "{said}");
}

#[test]
fn videos_show_the_pictures() {
    if !has_ffmpeg() {
        return;
    }
    let place = Place::new();
    // An odd side becomes even.
    let render = format!("render {MODEL} --width 48 --height 33 --quality 0.3 --orbit 7 --json");
    for (name, expected) in
        [("a.mp4", "h264,48,32,12/1,7"), ("a.webm", "vp9,48,32,12/1,7"), ("a.gif", "gif,48,33,")]
    {
        let result = place.ok(&format!("{render} --out frames --video {name} --fps 12"));
        assert_eq!((&result["video"], &result["pictures"]), (&name.into(), &7.into()));
        let found = probed(&place.path(name));
        assert!(found.starts_with(expected) && found.ends_with(",7"), "{found}");
        let height = if name == "a.gif" { 33 } else { 32 };
        let shown = decoded(&place.path(name));
        assert_eq!(shown.len(), 7 * 3 * 48 * height);
        for i in 0..7 {
            let frame =
                image_file::open(place.path(&format!("frames/{i:03}.png"))).unwrap().to_rgb8();
            let shown = &shown[i * 3 * 48 * height..][..3 * 48 * height];
            let sum: u32 =
                shown.iter().zip(frame.iter()).map(|(a, b)| u32::from(a.abs_diff(*b))).sum();
            // Colours at half the size; a wrong matrix of colours is off by 12.
            assert!(sum < 7 * shown.len() as u32, "{name} {i}: {sum}");
        }
        assert!(!place.path(&format!("{name}.parts")).exists());
    }
}

/// A browser plays them to the end, in colours of the scene.
#[test]
fn a_browser_plays_them() {
    if !has_ffmpeg() || !has("chromium") {
        return;
    }
    let place = Place::new();
    let render = format!("render {MODEL} --width 96 --height 64 --quality 0 --orbit 8");
    for name in ["a.mp4", "a.webm"] {
        place.ok(&format!("{render} --fps 16 --out {name}"));
        let script =
            "v.onended = () => console.log(`ended ${v.videoWidth}x${v.videoHeight} ${v.duration}`);
            v.onerror = () => console.log(`refused ${v.error.message}`);";
        let page =
            format!("<video id=v src={name} muted autoplay></video><script>{script}</script>");
        std::fs::write(place.path("page.html"), page).unwrap();
        let mut browser = Command::new("chromium");
        browser.args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr"]);
        browser.args(["--autoplay-policy=no-user-gesture-required", "--remote-debugging-port=0"]);
        browser.arg(format!("--user-data-dir={}", place.path("profile").display()));
        browser.arg(format!("file://{}", place.path("page.html").display()));
        let mut browser = browser.stderr(Stdio::piped()).spawn().unwrap();
        let said = BufReader::new(browser.stderr.take().unwrap());
        let (sender, receiver) = std::sync::mpsc::channel();
        std::thread::spawn(move || {
            let mut lines = said.lines().map_while(Result::ok);
            lines.find(|line| line.contains("CONSOLE")).map(|line| sender.send(line))
        });
        let line = receiver.recv_timeout(Duration::from_secs(120)).unwrap_or_default();
        browser.kill().unwrap();
        browser.wait().unwrap();
        assert!(line.contains("\"ended 96x64 0.5"), "{name}: {line}");
    }
}

/// A path, and a video of it, are interrupted once and go on to the same pictures.
#[cfg(unix)]
#[test]
fn an_interrupted_path_goes_on() {
    if !has_ffmpeg() {
        return;
    }
    let place = Place::new();
    let render = format!("render {MODEL} --width 48 --height 32 --antialias off --orbit 80 --json");
    place.ok(&format!("{render} --out whole --video whole.mp4"));
    let cut = format!("{render} --out cut --video cut.mp4");
    let child = place.command(&cut).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // A part of the video is there, and the next begun.
    let begun = Instant::now();
    while !place.path("cut.mp4.parts/001.mp4").exists() {
        assert!(begun.elapsed() < Duration::from_secs(120), "there is no second part");
        std::thread::sleep(Duration::from_millis(1));
    }
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    let said = text(&output.stderr);
    assert!(said.contains("interrupted; run the same command again to continue"), "{said}");
    assert!(!place.path("cut.mp4").exists() && place.path("cut/.unfinished").exists());

    // Pictures that are there are not rendered again.
    let first = std::fs::metadata(place.path("cut/000.png")).unwrap().modified().unwrap();
    let output = place.run(&cut.replace("--json", ""));
    let said = text(&output.stdout);
    assert!(said.starts_with("60 of 80 pictures are there already\n"), "{said}");
    assert_eq!(std::fs::metadata(place.path("cut/000.png")).unwrap().modified().unwrap(), first);
    for i in 0..80 {
        let name = |folder: &str| format!("{folder}/{i:03}.png");
        assert!(place.bytes(&name("cut")) == place.bytes(&name("whole")), "{i}");
    }
    assert!(decoded(&place.path("cut.mp4")) == decoded(&place.path("whole.mp4")));
    assert_eq!(probed(&place.path("cut.mp4")), "h264,48,32,30/1,80");
    assert_eq!(std::fs::read_dir(place.path("cut")).unwrap().count(), 80);
    assert!(!place.path("cut.mp4.parts").exists());
    // Other codecs are joined too. What somebody else put beside the parts stays.
    std::fs::create_dir(place.path("b.webm.parts")).unwrap();
    std::fs::write(place.path("b.webm.parts/mine"), "mine").unwrap();
    place.ok(&format!("{render} --out b.webm"));
    assert_eq!(probed(&place.path("b.webm")), "vp9,48,32,30/1,80");
    let left = std::fs::read_dir(place.path("b.webm.parts")).unwrap();
    assert_eq!(left.map(|file| file.unwrap().file_name()).collect::<Vec<_>>(), ["mine"]);
    // Another command begins anew.
    place.ok(&format!("{render} --out cut --quality 0"));
    assert!(place.bytes("cut/000.png") != place.bytes("whole/000.png"));
}
