//! Text files of a COLMAP model: words between blanks, a `#` before comments.

use std::str::FromStr;

use glam::{DQuat, DVec3};

use super::camera::{self, Camera};
use super::model::{CAMERA_HINT, File, Image, Point};
use crate::dataset::DatasetError;
use crate::json::escape;

/// Characters of a wrong word that are shown.
const SHOWN: usize = 40;

/// What has not been read of a line.
struct Line<'f> {
    file: &'f File<'f>,
    place: usize,
    rest: &'f str,
}

pub(super) fn cameras(file: &File<'_>) -> Result<Vec<(u32, Camera)>, DatasetError> {
    lines(file)?.filter(|line| !line.rest.is_empty()).map(Line::camera).collect()
}

pub(super) fn images(file: &File<'_>) -> Result<Vec<Image>, DatasetError> {
    image_lines(file)?.map(Line::image).collect()
}

/// How many images a file lists.
pub(super) fn listed(file: &File<'_>) -> Result<usize, DatasetError> {
    image_lines(file).map(Iterator::count)
}

pub(super) fn points(file: &File<'_>) -> Result<Vec<Point>, DatasetError> {
    let lines = lines(file)?.filter(|line| !line.rest.is_empty());
    lines.filter_map(|line| line.point().transpose()).collect()
}

/// The lines that name images. Each is followed by one of the points in it, which may be
/// empty, and which some editors then drop.
fn image_lines<'f>(file: &'f File<'f>) -> Result<impl Iterator<Item = Line<'f>>, DatasetError> {
    let mut lines = lines(file)?.peekable();
    Ok(std::iter::from_fn(move || {
        let line = lines.find(|line| !line.rest.is_empty())?;
        // The last word is a point's number, not an image's name.
        let of_points = |line: &Line<'_>| {
            line.rest.split_whitespace().next_back().is_none_or(|word| i64::from_str(word).is_ok())
        };
        lines.next_if(of_points);
        Some(line)
    }))
}

/// All lines but comments, without blanks at their ends.
fn lines<'f>(file: &'f File<'f>) -> Result<impl Iterator<Item = Line<'f>>, DatasetError> {
    let lines = file.text(file.bytes)?.lines().zip(1..);
    let lines = lines.map(move |(line, place)| Line { file, place, rest: line.trim() });
    Ok(lines.filter(|line| !line.rest.starts_with('#')))
}

impl<'f> Line<'f> {
    fn camera(mut self) -> Result<(u32, Camera), DatasetError> {
        let id = self.number("a camera's number")?;
        let kind = self.word("a camera model")?;
        if !camera::is_kind(kind) {
            return Err(DatasetError::NotReadable {
                file: self.file.path.to_owned(),
                what: format!("camera {id}, of the model {kind},"),
                hint: CAMERA_HINT,
            });
        }
        let size = [self.number("a width")?, self.number("a height")?];
        let mut numbers = Vec::new();
        while !self.rest.is_empty() {
            numbers.push(self.number("a parameter")?);
        }
        let camera = Camera::new(kind, size, &numbers);
        Ok((id, camera.map_err(|problem| self.wrong(&format!("camera {id}: {problem}")))?))
    }

    fn image(mut self) -> Result<Image, DatasetError> {
        let id = self.number("an image's number")?;
        let mut rotation = [0.0; 4];
        for number in &mut rotation {
            *number = self.number("four numbers of a rotation")?;
        }
        let [w, x, y, z] = rotation;
        let translation = self.position()?;
        let camera = self.number("a camera's number")?;
        let pose = (DQuat::from_xyzw(x, y, z, w), translation);
        // A name may hold blanks.
        Image::new(self.file, id, self.rest, camera, pose)
    }

    fn point(mut self) -> Result<Option<Point>, DatasetError> {
        self.number::<u64>("a point's number")?;
        let at = self.position()?;
        for what in ["red", "green", "blue", "an error"] {
            self.number::<f64>(what)?;
        }
        let mut images = Vec::new();
        while !self.rest.is_empty() {
            images.push(self.number("an image's number")?);
            self.number::<u32>("the number of a point in an image")?;
        }
        Ok(Point::new(at, images))
    }

    fn position(&mut self) -> Result<DVec3, DatasetError> {
        let mut next = || self.number("three numbers of a position");
        Ok(DVec3::new(next()?, next()?, next()?))
    }

    fn number<T: FromStr>(&mut self, what: &str) -> Result<T, DatasetError> {
        let word = self.word(what)?;
        word.parse().map_err(|_| {
            let shown: String = word.chars().take(SHOWN).collect();
            self.wrong(&format!("\"{}\", expected {what}", escape(&shown)))
        })
    }

    fn word(&mut self, what: &str) -> Result<&'f str, DatasetError> {
        if self.rest.is_empty() {
            return Err(self.wrong(&format!("the line ends, expected {what}")));
        }
        let (word, rest) = self.rest.split_once(char::is_whitespace).unwrap_or((self.rest, ""));
        self.rest = rest.trim_start();
        Ok(word)
    }

    fn wrong(&self, problem: &str) -> DatasetError {
        self.file.wrong(format!("line {}: {problem}", self.place))
    }
}
