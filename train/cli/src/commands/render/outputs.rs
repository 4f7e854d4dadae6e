//! All that is written of the pictures.

use std::hash::Hash;
use std::path::Path;

use pocketnerf_core::Camera;
use pocketnerf_train::picture::image_file;

use super::geometry::{Geometry, Numbers};
use super::target::Target;
use super::unfinished::Unfinished;
use super::video::Video;
use crate::commands::Failure;

/// A picture, a folder or a video, or several of them, and what lies beside each picture.
pub(super) struct Outputs {
    all: Vec<Output>,
    geometry: Geometry,
}

struct Output {
    target: Target,
    video: Option<Video>,
    /// Where there is more than one picture.
    unfinished: Option<Unfinished>,
    /// Pictures that are there already.
    done: usize,
}

impl Outputs {
    /// None yet.
    pub(super) const fn new(geometry: Geometry) -> Self {
        Self { all: Vec::new(), geometry }
    }

    /// Adds one. `work` is all that decides about the pictures.
    pub(super) fn open(
        &mut self,
        path: &Path,
        cameras: &[Camera],
        fps: f32,
        work: &impl Hash,
    ) -> Result<(), Failure> {
        let target = Target::new(path, cameras.len())?;
        let video = match &target {
            Target::Video(path, kind) => {
                let size = cameras.first().map_or([0; 2], |camera| [camera.width, camera.height]);
                if cameras.iter().any(|camera| [camera.width, camera.height] != size) {
                    return Err("the pictures of a video, expected of one size; give --width and \
                                --height"
                        .into());
                }
                Some(Video::new(path, *kind, size, (fps, cameras.len()))?)
            }
            _ => None,
        };
        let folder = match (&target, &video) {
            (_, Some(video)) => Some(video.folder()),
            (Target::Folder(folder), None) => Some(folder.as_path()),
            _ => None,
        };
        let begun = folder.map(|folder| Unfinished::begin(folder, &(work, fps.to_bits())));
        let (mut unfinished, noted) = begun.unzip();
        // Somebody may have taken some away.
        let is_there = |i: &usize| match (&video, target.picture(*i)) {
            (Some(video), _) => video.has(*i),
            (None, picture) => picture.is_some_and(|picture| {
                picture.exists() && self.geometry.files(&picture).all(|file| file.exists())
            }),
        };
        let done = (0..noted.unwrap_or(0)).take_while(is_there).count();
        if let (Some(unfinished), 0) = (&mut unfinished, done) {
            // From now on what lies there is not that of an earlier command.
            unfinished.save(0);
        }
        self.all.push(Output { target, video, unfinished, done });
        Ok(())
    }

    /// Pictures that all of them have already. No video is begun within a part.
    pub(super) fn done(&self) -> usize {
        let mut done = self.all.iter().map(|output| output.done).min().unwrap_or(0);
        let is_whole =
            |done| self.all.iter().all(|o| o.video.as_ref().is_none_or(|v| v.is_whole(done)));
        while !is_whole(done) {
            done -= 1;
        }
        done
    }

    /// Adds the `i`-th picture, RGB, and its numbers.
    pub(super) fn add(
        &mut self,
        (i, camera): (usize, &Camera),
        rgb: &[u8],
        numbers: &Numbers,
    ) -> Result<(), Failure> {
        for output in &mut self.all {
            if let Some(path) = output.target.picture(i) {
                image_file::write_rgb(&path, camera.width, camera.height, rgb)?;
                self.geometry.write(&path, camera, numbers)?;
            }
            let is_whole = match &mut output.video {
                Some(video) => {
                    video.add(i, rgb)?;
                    video.is_whole(i + 1)
                }
                None => true,
            };
            if let (Some(unfinished), true) = (&mut output.unfinished, is_whole) {
                match output.video {
                    Some(_) => unfinished.save(i + 1),
                    None => unfinished.note(i + 1),
                }
            }
        }
        Ok(())
    }

    /// So many pictures are there, and the rest follows another time.
    pub(super) fn interrupt(&mut self, done: usize) {
        for output in self.all.iter_mut().filter(|output| output.video.is_none()) {
            output.unfinished.iter_mut().for_each(|unfinished| unfinished.save(done));
        }
    }

    /// All pictures are there.
    pub(super) fn finish(self) -> Result<(), Failure> {
        for output in self.all {
            output.video.iter().try_for_each(Video::finish)?;
            output.unfinished.into_iter().for_each(Unfinished::end);
            // Unless something else lies there.
            let _ = output.video.map(|video| std::fs::remove_dir(video.folder()));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::geometry::Format;
    use super::*;

    #[test]
    fn a_picture_without_its_files_is_rendered_again() {
        let folder = tempfile::tempdir().unwrap();
        let camera = Camera::from_fov_x(2, 1, 1.0, [0.0; 16]);
        let numbers = Numbers { depth: vec![1.0; 2], normals: vec![[0.0; 3]; 2] };
        let open = |depth, normals| {
            let mut outputs = Outputs::new(Geometry { depth, normals });
            outputs.open(folder.path(), &[camera; 3], 30.0, &"work").unwrap();
            outputs
        };
        let both = || open(Some(Format::Exr), Some(Format::Png));
        let mut outputs = both();
        for i in 0..2 {
            outputs.add((i, &camera), &[0; 6], &numbers).unwrap();
        }
        outputs.interrupt(2);
        assert_eq!(both().done(), 2);
        std::fs::remove_file(folder.path().join("001.normals.png")).unwrap();
        assert_eq!(both().done(), 1);
        assert_eq!(open(Some(Format::Exr), None).done(), 2);
        assert_eq!(open(Some(Format::Png), None).done(), 0);
    }
}
