//! A camera that goes around something, and keeps what is up up.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec3};
use pocketnerf_core::{Camera, Space};
use pocketnerf_formats::ModelFile;

/// Farthest from the horizon that a camera rises or sinks, radians.
const STEEPEST: f32 = 1.55;
/// Nearest and farthest, as parts of the distance at the beginning.
const DISTANCES: [f32; 2] = [1.0 / 64.0, 16.0];

/// Where one looks from. It begins as the model's own camera and remembers how it was
/// turned since, so that nothing adds up, and an untouched view is that camera exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    start: Camera,
    /// What it goes around: on the first camera's axis, as far away as the scene's middle.
    target: Vec3,
    up: Vec3,
    is_around: bool,
    yaw: f32,
    rise: f32,
    distance: f32,
    pan: Vec3,
}

impl View {
    /// The file's own camera, or one half a radian above the scene's x axis.
    #[must_use]
    pub fn new(file: &ModelFile<'_>) -> Self {
        let (space, scene) = (&file.model.space, &file.about.scene);
        let z = Vec3::from(scene.to_model_direction([0.0, 0.0, 1.0])).normalize_or(Vec3::Z);
        let [width, height] = file.about.camera.map_or([800; 2], |own| [own.width, own.height]);
        let start = file.camera(width, height);
        Self::around(start, space, z)
    }

    /// The view of `start`. What is up in the scene is `up`, or, where the camera lies on
    /// its side to it, what is up in its picture.
    #[must_use]
    pub fn around(start: Camera, space: &Space, up: Vec3) -> Self {
        let [eye, ahead] = [start.position(), start.axis()].map(Vec3::from);
        let is_around = space.scene_box().is_some();
        let along = (Vec3::from(space.center()) - eye).dot(ahead);
        let far = match space {
            Space::Ndc(ndc) => 4.0 * ndc.near,
            _ => along,
        };
        // A camera with its back to the scene turns around what is before it.
        let least = 0.1 / space.unit_map().scale;
        let target = eye + ahead * far.max(least);
        let own_up = column(&start, 1);
        let up = if is_around && own_up.dot(up) > 0.5 { up } else { own_up };
        Self { start, target, up, is_around, yaw: 0.0, rise: 0.0, distance: 1.0, pan: Vec3::ZERO }
    }

    /// Picture size that the model suggests.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        [self.start.width, self.start.height]
    }

    /// As it was in the beginning.
    pub const fn reset(&mut self) {
        (self.yaw, self.rise, self.distance) = (0.0, 0.0, 1.0);
        self.pan = Vec3::ZERO;
    }

    /// Goes around: so many radians to the right, and so many up.
    pub fn turn(&mut self, right: f32, up: f32) {
        let back = column(&self.start, 2);
        let begun = back.dot(self.up).clamp(-1.0, 1.0).asin();
        let [low, high] = [-STEEPEST.max(-begun), STEEPEST.max(begun)].map(|end| end - begun);
        self.yaw = (self.yaw + right) % TAU;
        self.rise = (self.rise + up).clamp(low, high);
    }

    /// Goes aside, in parts of the distance to what it goes around.
    pub fn shift(&mut self, right: f32, up: f32) {
        let (turned, length) = (self.rotation(), self.length());
        let aside = turned * (column(&self.start, 0) * right + column(&self.start, 1) * up);
        self.pan += aside * length;
    }

    /// Goes nearer: `factor` times the distance.
    pub fn approach(&mut self, factor: f32) {
        self.distance = (self.distance * factor).clamp(DISTANCES[0], DISTANCES[1]);
    }

    /// Goes around as a drag over so many pixels of a picture of this height does: the
    /// scene follows the hand, half a turn for the picture's height.
    pub fn drag(&mut self, [x, y]: [f32; 2], height: u32) {
        let radians = PI / height.max(1) as f32;
        self.turn(-x * radians, y * radians);
    }

    /// Goes aside as a drag over so many pixels of a picture of this size does: what is
    /// in the middle stays under the hand.
    pub fn pull(&mut self, [x, y]: [f32; 2], [width, height]: [u32; 2]) {
        let focal = self.camera(width, height).focal[0];
        self.shift(-x / focal, y / focal);
    }

    /// The camera for a picture of this size: all that the model's own picture shows is
    /// in it, and as wide as that wherever possible.
    #[must_use]
    pub fn camera(&self, width: u32, height: u32) -> Camera {
        let own = &self.start;
        let [own_width, own_height] = [own.width, own.height].map(f64::from);
        let fov_x = 2.0 * (0.5 * own.width as f32 / own.focal[0]).atan();
        let mut camera = Camera::from_fov_x(width, height, fov_x, self.pose());
        let wide = f64::from(width) * own_height / (f64::from(height.max(1)) * own_width);
        if wide > 1.0 {
            camera.focal = camera.focal.map(|f| (f64::from(f) / wide) as f32);
        }
        camera
    }

    /// Cameras for `views` pictures: a circle around what is seen, from here on; before a
    /// forward-facing capture, which has no back, a small circle in front of it.
    #[must_use]
    pub fn orbit(&self, views: u32) -> Vec<Self> {
        let place = |view: u32| {
            let angle = TAU * view as f32 / views as f32;
            let mut place = *self;
            match self.is_around {
                true => place.turn(angle, 0.0),
                false => place.turn(0.05 * angle.sin(), 0.05 * (1.0 - angle.cos())),
            }
            place
        };
        (0..views).map(place).collect()
    }

    fn rotation(&self) -> Quat {
        let right = column(&self.start, 0);
        Quat::from_axis_angle(self.up, self.yaw) * Quat::from_axis_angle(right, -self.rise)
    }

    /// How far it is to what it goes around.
    fn length(&self) -> f32 {
        (self.target - Vec3::from(self.start.position())).length() * self.distance
    }

    fn pose(&self) -> [f32; 16] {
        let mut untouched = *self;
        untouched.reset();
        if *self == untouched {
            return self.start.camera_to_world;
        }
        let turned = self.rotation();
        let [right, up, back] = [0, 1, 2].map(|c| turned * column(&self.start, c));
        let eye = self.target + self.pan + back * self.length();
        [
            right.x, up.x, back.x, eye.x, //
            right.y, up.y, back.y, eye.y, //
            right.z, up.z, back.z, eye.z, //
            0.0, 0.0, 0.0, 1.0,
        ]
    }
}

/// Right (0), up (1) or back (2) of a camera.
fn column(camera: &Camera, c: usize) -> Vec3 {
    let m = &camera.camera_to_world;
    Vec3::new(m[c], m[4 + c], m[8 + c]).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPACE: Space = Space::Box { min: [-1.0; 3], max: [1.0; 3] };

    /// At (4, 0, 0), looking at the origin, z up; 200×100 pixels, 90° wide.
    fn view() -> View {
        let pose = Camera::look_at([4.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        View::around(Camera::from_fov_x(200, 100, PI / 2.0, pose), &SPACE, Vec3::Z)
    }

    fn is_at(view: &View, eye: [f32; 3]) -> bool {
        Vec3::from(view.camera(200, 100).position()).distance(Vec3::from(eye)) < 1e-5
    }

    #[test]
    fn an_untouched_view_is_the_first_camera() {
        let mut view = view();
        assert_eq!(view.camera(200, 100).camera_to_world, view.start.camera_to_world);
        view.turn(0.3, -0.2);
        view.approach(2.0);
        view.shift(0.1, 0.1);
        assert_ne!(view.camera(200, 100).camera_to_world, view.start.camera_to_world);
        view.reset();
        assert_eq!(view.camera(200, 100).camera_to_world, view.start.camera_to_world);
    }

    #[test]
    fn turns_around_the_middle() {
        let mut view = view();
        view.turn(PI / 2.0, 0.0);
        assert!(is_at(&view, [0.0, 4.0, 0.0]), "{:?}", view.camera(200, 100).position());
        view.turn(-PI / 2.0, PI / 6.0);
        assert!(is_at(&view, [2.0 * 3f32.sqrt(), 0.0, 2.0]));
        // Up stays up: right is level.
        assert!(view.camera(200, 100).camera_to_world[8].abs() < 1e-6);
        view.turn(0.0, 10.0);
        let z = view.camera(200, 100).position()[2];
        assert!(z > 3.99 && z < 4.0, "{z}");
    }

    #[test]
    fn a_drag_turns_and_a_pull_keeps_what_is_under_the_hand() {
        let mut dragged = view();
        // Half of 100 pixels to the left: a quarter turn to the right.
        dragged.drag([-50.0, 0.0], 100);
        assert!(is_at(&dragged, [0.0, 4.0, 0.0]));
        let mut pulled = view();
        pulled.pull([30.0, 10.0], [200, 100]);
        let [x, y] = pulled.camera(200, 100).project([0.0; 3]).unwrap();
        assert!((x - 130.0).abs() < 1e-3 && (y - 60.0).abs() < 1e-3, "{x} {y}");
    }

    #[test]
    fn approaches_within_limits() {
        let mut view = view();
        view.approach(0.5);
        assert!(is_at(&view, [2.0, 0.0, 0.0]));
        (0..100).for_each(|_| view.approach(0.5));
        assert!(is_at(&view, [4.0 / 64.0, 0.0, 0.0]));
    }

    #[test]
    fn every_shape_of_window_shows_all_of_the_picture() {
        // Twice as wide as high: focal length 100 for a width of 200.
        let focal = |w, h| view().camera(w, h).focal[0];
        assert!((focal(200, 100) - 100.0).abs() < 1e-4);
        assert!((focal(200, 200) - 100.0).abs() < 1e-4);
        assert!((focal(400, 100) - 100.0).abs() < 1e-4);
        assert!((focal(400, 200) - 200.0).abs() < 1e-4);
    }

    #[test]
    fn an_orbit_of_four() {
        let eyes = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [-4.0, 0.0, 0.0], [0.0, -4.0, 0.0]];
        for (view, eye) in view().orbit(4).iter().zip(eyes) {
            assert!(is_at(view, eye));
        }
    }
}
