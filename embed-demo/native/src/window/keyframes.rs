//! Keyframes that the user sets, and the path through them.

use std::path::Path;
use std::time::{Duration, Instant};

use pocketnerf_core::Camera;
use pocketnerf_core::camera::{Keyframe, KeyframePath};

use super::input::PathCommand;
use crate::output::camera_path;
use crate::view::View;

/// Keyframes, and the path through them while it is played.
#[derive(Debug, Default)]
pub(super) struct Keyframes {
    /// In the dataset's coordinates, as in files.
    poses: Vec<[f32; 16]>,
    played: Option<Played>,
}

/// A path that is played.
#[derive(Debug)]
struct Played {
    begun: Instant,
    /// Of its pictures, scene units.
    poses: Vec<[f32; 16]>,
    /// How many were shown, or left out because others were slow.
    done: usize,
}

impl Keyframes {
    /// Does what a key says, where `view` is shown in a window of this size; `file` is for the
    /// path. Says what has been done, or why nothing was.
    pub(super) fn command(
        &mut self,
        command: PathCommand,
        view: &View,
        size: [u32; 2],
        file: &Path,
    ) -> String {
        let done = match command {
            PathCommand::Add => {
                let shown = view.scene().camera_to_dataset(&view.camera(1, 1));
                self.poses.push(shown.camera_to_world);
                Ok(self.count(view))
            }
            PathCommand::Remove => match self.poses.pop() {
                Some(_) => Ok(self.count(view)),
                None => Err("no keyframe to remove".to_owned()),
            },
            PathCommand::Play if self.stop() => Ok(self.count(view)),
            PathCommand::Play => self.play(view),
            PathCommand::Save => self.save(file, view, size),
        };
        done.unwrap_or_else(|reason| reason)
    }

    fn count(&self, view: &View) -> String {
        match self.poses.len() {
            0 => "no keyframes".to_owned(),
            1 => "1 keyframe".to_owned(),
            n => format!("{n} keyframes, {:.0} seconds", path(&self.all(view, [1; 2])).seconds()),
        }
    }

    /// As a window of this size shows them.
    fn all(&self, view: &View, [width, height]: [u32; 2]) -> Vec<Keyframe> {
        let focal = f64::from(view.camera(width, height).focal[1]);
        let fov_y = 2.0 * (0.5 * f64::from(height) / focal).atan().to_degrees();
        let keyframe =
            |pose: &[f32; 16]| Keyframe { pose: *pose, fov_y, seconds: Keyframe::SECONDS };
        self.poses.iter().map(keyframe).collect()
    }

    /// Writes them and the path through them, for pictures as large as the window.
    fn save(&self, file: &Path, view: &View, size: [u32; 2]) -> Result<String, String> {
        if self.poses.is_empty() {
            return Err("no keyframes to save: k adds one".to_owned());
        }
        // A minimised window has none.
        let size = if size.contains(&0) { view.size() } else { size };
        camera_path::write(file, &path(&self.all(view, size)), size)?;
        Ok(format!("{}: saved, {}", file.display(), self.count(view)))
    }

    /// Starts the path.
    fn play(&mut self, view: &View) -> Result<String, String> {
        if self.poses.len() < 2 {
            return Err("a path takes two keyframes: k adds one".to_owned());
        }
        let in_model = |(camera_to_world, _)| {
            let camera = Camera { camera_to_world, ..view.camera(1, 1) };
            view.scene().camera_to_model(&camera).camera_to_world
        };
        let poses = path(&self.all(view, [1; 2])).pictures().map(in_model).collect();
        self.played = Some(Played { begun: Instant::now(), poses, done: 0 });
        Ok(self.count(view))
    }

    /// Ends the path where it is; whether it was played.
    pub(super) fn stop(&mut self) -> bool {
        self.played.take().is_some()
    }

    /// The pose of the path's picture whose time has come, scene units, if it was not shown yet.
    /// The last one ends the path.
    pub(super) fn due(&mut self, now: Instant) -> Option<[f32; 16]> {
        let Played { begun, poses, done } = self.played.as_mut()?;
        let passed =
            (now.saturating_duration_since(*begun).as_secs_f64() * KeyframePath::FPS) as usize;
        let picture = passed.min(poses.len() - 1);
        if picture < *done {
            return None;
        }
        *done = picture + 1;
        let pose = poses[picture];
        if *done == poses.len() {
            self.played = None;
        }
        Some(pose)
    }

    /// When the path's next picture is due, while it is played.
    pub(super) fn next(&self) -> Option<Instant> {
        let Played { begun, done, .. } = self.played.as_ref()?;
        Some(*begun + Duration::from_secs_f64(*done as f64 / KeyframePath::FPS))
    }
}

fn path(keyframes: &[Keyframe]) -> KeyframePath<'_> {
    KeyframePath { keyframes, is_cycle: false, fps: KeyframePath::FPS }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use pocketnerf_core::Space;

    use super::*;

    fn view() -> View {
        let pose = Camera::look_at([4.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        let space = Space::Box { min: [-1.0; 3], max: [1.0; 3] };
        View::around(Camera::from_fov_x(200, 100, 1.0, pose), &space, Vec3::Z)
    }

    #[test]
    fn a_path_is_played_by_the_clock_and_ends() {
        let mut view = view();
        let mut keyframes = Keyframes::default();
        let told = |keyframes: &mut Keyframes, view: &View, command, expected: &str| {
            assert_eq!(keyframes.command(command, view, [8, 8], Path::new("/none")), expected);
        };
        told(&mut keyframes, &view, PathCommand::Play, "a path takes two keyframes: k adds one");
        told(&mut keyframes, &view, PathCommand::Save, "no keyframes to save: k adds one");
        told(&mut keyframes, &view, PathCommand::Remove, "no keyframe to remove");
        let first = view.camera(1, 1).camera_to_world;
        told(&mut keyframes, &view, PathCommand::Add, "1 keyframe");
        view.turn(0.5, 0.0);
        told(&mut keyframes, &view, PathCommand::Add, "2 keyframes, 2 seconds");
        told(&mut keyframes, &view, PathCommand::Play, "2 keyframes, 2 seconds");
        let begun = keyframes.played.as_ref().unwrap().begun;
        let close = |found: Option<[f32; 16]>, expected: [f32; 16]| {
            let found = found.unwrap();
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}");
        };
        close(keyframes.due(begun), first);
        assert_eq!(keyframes.due(begun), None);
        let second = keyframes.next().unwrap() - begun;
        assert!(second.abs_diff(Duration::from_millis(33)) < Duration::from_millis(1));
        // Pictures whose time has passed are left out: at the end is the last one of 60.
        assert!(keyframes.due(begun + Duration::from_secs(1)).is_some());
        close(keyframes.due(begun + Duration::from_secs(9)), view.camera(1, 1).camera_to_world);
        assert!(keyframes.next().is_none() && keyframes.due(begun).is_none() && !keyframes.stop());
        // The same key ends it before.
        told(&mut keyframes, &view, PathCommand::Play, "2 keyframes, 2 seconds");
        told(&mut keyframes, &view, PathCommand::Play, "2 keyframes, 2 seconds");
        assert!(keyframes.next().is_none());
        told(&mut keyframes, &view, PathCommand::Remove, "1 keyframe");
        told(&mut keyframes, &view, PathCommand::Remove, "no keyframes");
    }
}
