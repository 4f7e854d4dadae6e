//! Videos, by ffmpeg.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use pocketnerf_train::{json, output};

use super::target::Kind;
use crate::commands::tool::FFMPEG;
use crate::commands::{Failure, make_folder};

/// Pictures of a part, which is what an interruption loses at most.
const PART: usize = 60;
/// Sides become even, as the usual colours of videos have it; values are those of screens.
const YUV: &str = "crop=trunc(iw/2)*2:trunc(ih/2)*2,\
                   scale=out_color_matrix=bt709:out_range=tv,format=yuv420p";

/// A video that is written in parts, in a folder beside it.
pub(super) struct Video {
    path: PathBuf,
    kind: Kind,
    size: [u32; 2],
    fps: f32,
    pictures: usize,
    parts: PathBuf,
    encoder: Option<Encoder>,
}

/// ffmpeg at work on a part.
struct Encoder {
    child: Child,
    part: PathBuf,
}

impl Video {
    /// # Errors
    /// There is no ffmpeg, or the folder cannot be made.
    pub(super) fn new(
        path: &Path,
        kind: Kind,
        size: [u32; 2],
        (fps, pictures): (f32, usize),
    ) -> Result<Self, Failure> {
        FFMPEG.ask(&["-version"])?;
        let mut parts = path.as_os_str().to_owned();
        parts.push(".parts");
        let parts = make_folder(Path::new(&parts))?;
        Ok(Self { path: path.to_owned(), kind, size, fps, pictures, parts, encoder: None })
    }

    /// Where the parts are.
    pub(super) fn folder(&self) -> &Path {
        &self.parts
    }

    /// Pictures of a part. A GIF has one.
    fn part_len(&self) -> usize {
        if self.kind == Kind::Gif { self.pictures } else { PART }
    }

    /// Whether a part is finished with so many pictures.
    pub(super) fn is_whole(&self, pictures: usize) -> bool {
        pictures.is_multiple_of(self.part_len()) || pictures == self.pictures
    }

    fn part(&self, i: usize) -> PathBuf {
        let extension = self.path.extension().unwrap_or_default();
        self.parts.join(format!("{i:03}")).with_extension(extension)
    }

    /// Whether the part is there that the `i`-th picture is in.
    pub(super) fn has(&self, i: usize) -> bool {
        self.part(i / self.part_len()).exists()
    }

    /// Adds the `i`-th picture.
    pub(super) fn add(&mut self, i: usize, rgb: &[u8]) -> Result<(), Failure> {
        let mut encoder = match self.encoder.take() {
            Some(encoder) => encoder,
            None => self.encoder(self.part(i / self.part_len()))?,
        };
        encoder.add(rgb).map_err(|said| self.failed(&said))?;
        match self.is_whole(i + 1) {
            true => encoder.finish().map_err(|said| self.failed(&said)),
            false => {
                self.encoder = Some(encoder);
                Ok(())
            }
        }
    }

    fn encoder(&self, part: PathBuf) -> Result<Encoder, Failure> {
        let [width, height] = self.size;
        let mut command = Command::new(FFMPEG.name);
        command.args(["-v", "error", "-y", "-f", "rawvideo", "-pixel_format", "rgb24"]);
        command.args(["-video_size", &format!("{width}x{height}")]);
        command.args(["-framerate", &self.fps.to_string(), "-i", "-"]);
        match self.kind {
            Kind::Mp4 => command
                .args(["-vf", YUV, "-c:v", "libx264", "-preset", "veryfast", "-crf", "17"])
                .args(self.kind.index_first()),
            Kind::WebM => command
                .args(["-vf", YUV, "-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0"])
                .args(["-deadline", "good", "-cpu-used", "4", "-row-mt", "1"]),
            // A palette for each picture.
            Kind::Gif => command.args([
                "-filter_complex",
                "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1",
            ]),
        };
        if self.kind != Kind::Gif {
            command.args(["-colorspace", "bt709", "-color_primaries", "bt709"]);
            command.args(["-color_trc", "iec61966-2-1", "-color_range", "tv"]);
        }
        command.arg(&part).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        // Ctrl-C is for this program, which ends it.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let child = command.spawn().map_err(|error| FFMPEG.missing(&error))?;
        Ok(Encoder { child, part })
    }

    /// Puts the parts together, and leaves nothing of them.
    pub(super) fn finish(&self) -> Result<(), Failure> {
        let n = self.pictures.div_ceil(self.part_len());
        let whole = match n {
            1 => self.part(0),
            _ => self.joined(n)?,
        };
        let bytes = std::fs::read(&whole)
            .map_err(|error| format!("{}: cannot be read: {error}", whole.display()))?;
        output::write_atomic(&self.path, &bytes)?;
        // What cannot be removed is in nobody's way.
        let files = (0..).map(|i| self.part(i)).take_while(|part| part.exists());
        for file in files.collect::<Vec<_>>().iter().chain([&self.list()]) {
            let _ = std::fs::remove_file(file);
        }
        Ok(())
    }

    fn list(&self) -> PathBuf {
        self.parts.join("list.txt")
    }

    /// Without encoding again.
    fn joined(&self, n: usize) -> Result<PathBuf, Failure> {
        let (list, whole) = (self.list(), self.part(n));
        let name = |i: usize| self.part(i).file_name().unwrap_or_default().to_owned();
        let lines = (0..n).map(|i| format!("file '{}'\n", name(i).display()));
        std::fs::write(&list, lines.collect::<String>())
            .map_err(|error| format!("{}: cannot be written: {error}", list.display()))?;
        let output = Command::new(FFMPEG.name)
            .args(["-v", "error", "-y", "-f", "concat", "-i"])
            .arg(&list)
            .args(["-c", "copy"])
            .args(self.kind.index_first())
            .arg(&whole)
            .stdin(Stdio::null())
            .output()
            .map_err(|error| FFMPEG.missing(&error))?;
        match output.status.success() {
            true => Ok(whole),
            false => Err(self.failed(&output.stderr)),
        }
    }

    fn failed(&self, said: &[u8]) -> Failure {
        let said = String::from_utf8_lossy(said);
        let line = said.lines().find(|line| !line.trim().is_empty()).unwrap_or("no reason given");
        format!("{}: ffmpeg failed: {}", self.path.display(), json::escape(line.trim())).into()
    }
}

impl Kind {
    /// What lets a browser play the file before it has all of it.
    fn index_first(self) -> &'static [&'static str] {
        if self == Self::Mp4 { &["-movflags", "+faststart"] } else { &[] }
    }
}

/// Where it fails, what ffmpeg has said.
impl Encoder {
    fn add(&mut self, rgb: &[u8]) -> Result<(), Vec<u8>> {
        let written = self.child.stdin.as_mut().map(|stdin| stdin.write_all(rgb));
        match written {
            Some(Ok(())) => Ok(()),
            // It has ended, and says why.
            _ => Err(self.said()),
        }
    }

    fn finish(mut self) -> Result<(), Vec<u8>> {
        drop(self.child.stdin.take());
        match self.child.wait() {
            Ok(status) if status.success() && self.part.exists() => Ok(()),
            _ => Err(self.said()),
        }
    }

    fn said(&mut self) -> Vec<u8> {
        let mut said = Vec::new();
        let _ = self.child.stderr.take().map(|mut stderr| stderr.read_to_end(&mut said));
        said
    }
}

impl Drop for Encoder {
    /// It must not go on alone.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
