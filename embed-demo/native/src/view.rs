//! A camera that turns around the scene and keeps its up direction.
//!
//! Unlike [`Orbit`](pocketnerf_core::camera::Orbit), which places a camera by two angles, it
//! starts at any pose and turns from there.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec3};
use pocketnerf_core::{Camera, Space};
use pocketnerf_formats::{ModelFile, Scene};

/// Largest angle above or below the horizon, radians.
const STEEPEST: f32 = 1.55;
/// Smallest and largest distance, as fractions of the first.
const DISTANCES: [f32; 2] = [1.0 / 64.0, 16.0];

/// A view of a scene. It starts at a camera and keeps the turns since then, so rounding errors
/// do not add up and an untouched view is exactly that camera: the model's own one, or one that
/// it went to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    own: Camera,
    scene: Scene<'static>,
    around: Around,
    start: Start,
    yaw: f32,
    rise: f32,
    distance: f32,
    pan: Vec3,
}

/// What a view needs to know of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Around {
    center: Vec3,
    /// How far away the target of a forward-facing capture is, which has no back.
    far: Option<f32>,
    /// The nearest that a target may be to the camera that looks at it first.
    near: f32,
    up: Vec3,
}

/// Where turns begin.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Start {
    pose: [f32; 16],
    /// The point to turn around: on the camera's axis, as far away as the scene's centre.
    target: Vec3,
    up: Vec3,
}

impl Around {
    /// Turns are about the scene's up direction, or about the camera's own if the camera lies on
    /// its side.
    fn start(&self, pose: [f32; 16]) -> Start {
        let [own_up, back, eye] = [1, 2, 3].map(|c| column(&pose, c));
        let (own_up, ahead) = (own_up.normalize_or_zero(), -back.normalize_or(Vec3::Z));
        // A camera that looks away from the scene turns around a point in front of it.
        let far = self.far.unwrap_or((self.center - eye).dot(ahead)).max(self.near);
        let is_upright = self.far.is_none() && own_up.dot(self.up) > 0.5;
        let up = if is_upright { self.up } else { own_up };
        Start { pose, target: eye + ahead * far, up }
    }
}

impl View {
    /// The file's own camera, or one half a radian above the scene's x axis.
    #[must_use]
    pub fn new(file: &ModelFile<'_>) -> Self {
        let (space, scene) = (&file.model.space, &file.about.scene);
        let up = Vec3::from(scene.to_model_direction(file.about.world.up())).normalize_or(Vec3::Z);
        let [width, height] = file.about.camera.map_or([800; 2], |own| [own.width, own.height]);
        let Scene { scale, rotation, translation, .. } = *scene;
        let scene = Scene { scale, rotation, translation, name: None };
        Self { scene, ..Self::around(file.camera(width, height), space, up) }
    }

    /// The view of `own`, in a scene whose coordinates are the dataset's, with this direction
    /// upwards.
    #[must_use]
    pub fn around(own: Camera, space: &Space, up: Vec3) -> Self {
        let far = match space {
            Space::Ndc(ndc) => Some(4.0 * ndc.near),
            _ => None,
        };
        let side = match space {
            Space::Contracted(contracted) => 2.0 * contracted.radius,
            _ => 1.0 / space.unit_map().scale,
        };
        let around = Around { center: space.center().into(), far, near: 0.1 * side, up };
        let start = around.start(own.camera_to_world);
        let scene = Scene::default();
        Self { own, scene, around, start, yaw: 0.0, rise: 0.0, distance: 1.0, pan: Vec3::ZERO }
    }

    /// The picture size of the model's own camera.
    #[must_use]
    pub const fn size(&self) -> [u32; 2] {
        [self.own.width, self.own.height]
    }

    /// The dataset's coordinates.
    #[must_use]
    pub const fn scene(&self) -> &Scene<'static> {
        &self.scene
    }

    /// Returns to the first camera.
    pub fn reset(&mut self) {
        self.go_to(self.own.camera_to_world);
    }

    /// Goes to a camera-to-world pose, scene units, and turns from there.
    pub fn go_to(&mut self, pose: [f32; 16]) {
        self.start = self.around.start(pose);
        (self.yaw, self.rise, self.distance) = (0.0, 0.0, 1.0);
        self.pan = Vec3::ZERO;
    }

    /// Turns around the target, radians to the right and up.
    pub fn turn(&mut self, right: f32, up: f32) {
        let begun = self.column(2).dot(self.start.up).clamp(-1.0, 1.0).asin();
        let [low, high] = [-STEEPEST.max(-begun), STEEPEST.max(begun)].map(|end| end - begun);
        self.yaw = (self.yaw + right) % TAU;
        self.rise = (self.rise + up).clamp(low, high);
    }

    /// Moves sideways, in fractions of the distance to the target.
    pub fn shift(&mut self, right: f32, up: f32) {
        let (turned, length) = (self.rotation(), self.length());
        let aside = turned * (self.column(0) * right + self.column(1) * up);
        self.pan += aside * length;
    }

    /// Multiplies the distance by `factor`.
    pub fn approach(&mut self, factor: f32) {
        self.distance = (self.distance * factor).clamp(DISTANCES[0], DISTANCES[1]);
    }

    /// Turns by a drag in pixels of a picture of this height: the scene follows the hand, half
    /// a turn for the height of the picture.
    pub fn drag(&mut self, [x, y]: [f32; 2], height: u32) {
        let radians = PI / height.max(1) as f32;
        self.turn(-x * radians, y * radians);
    }

    /// Moves sideways by a drag in pixels of a picture of this size: the target stays under
    /// the hand.
    pub fn pull(&mut self, [x, y]: [f32; 2], [width, height]: [u32; 2]) {
        let focal = self.camera(width, height).focal[0];
        self.shift(-x / focal, y / focal);
    }

    /// The camera for a picture of this size: it shows all that the model's own picture
    /// shows, and as little more as possible.
    #[must_use]
    pub fn camera(&self, width: u32, height: u32) -> Camera {
        let own = &self.own;
        let [own_width, own_height] = [own.width, own.height].map(f64::from);
        let fov_x = 2.0 * (0.5 * own.width as f32 / own.focal[0]).atan();
        let mut camera = Camera::from_fov_x(width, height, fov_x, self.pose());
        let wide = f64::from(width) * own_height / (f64::from(height.max(1)) * own_width);
        if wide > 1.0 {
            camera.focal = camera.focal.map(|f| (f64::from(f) / wide) as f32);
        }
        camera
    }

    /// Views on a circle around the target, from this one on; for a forward-facing capture,
    /// which has no back, a small circle in front of it.
    #[must_use]
    pub fn orbit(&self, views: u32) -> Vec<Self> {
        let place = |view: u32| {
            let angle = TAU * view as f32 / views as f32;
            let mut place = *self;
            match self.around.far {
                None => place.turn(angle, 0.0),
                Some(_) => place.turn(0.05 * angle.sin(), 0.05 * (1.0 - angle.cos())),
            }
            place
        };
        (0..views).map(place).collect()
    }

    fn rotation(&self) -> Quat {
        Quat::from_axis_angle(self.start.up, self.yaw)
            * Quat::from_axis_angle(self.column(0), -self.rise)
    }

    /// The distance to the target.
    fn length(&self) -> f32 {
        (self.start.target - column(&self.start.pose, 3)).length() * self.distance
    }

    fn pose(&self) -> [f32; 16] {
        let is_untouched = [self.yaw, self.rise] == [0.0; 2] && self.distance == 1.0;
        if is_untouched && self.pan == Vec3::ZERO {
            return self.start.pose;
        }
        let turned = self.rotation();
        let [right, up, back] = [0, 1, 2].map(|c| turned * self.column(c));
        let eye = self.start.target + self.pan + back * self.length();
        [
            right.x, up.x, back.x, eye.x, //
            right.y, up.y, back.y, eye.y, //
            right.z, up.z, back.z, eye.z, //
            0.0, 0.0, 0.0, 1.0,
        ]
    }

    /// Right (0), up (1) or back (2) of the camera where turns begin.
    fn column(&self, c: usize) -> Vec3 {
        column(&self.start.pose, c).normalize_or_zero()
    }
}

/// A column of a pose: right (0), up (1), back (2) or position (3).
fn column(pose: &[f32; 16], c: usize) -> Vec3 {
    Vec3::new(pose[c], pose[4 + c], pose[8 + c])
}

#[cfg(test)]
mod tests {
    use super::*;
    use pocketnerf_core::space::Contracted;

    const SPACE: Space = Space::Box { min: [-1.0; 3], max: [1.0; 3] };

    /// At (4, 0, 0), looking at the origin, z up; 200×100 pixels, 90° wide.
    fn view() -> View {
        let pose = Camera::look_at([4.0, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        View::around(Camera::from_fov_x(200, 100, PI / 2.0, pose), &SPACE, Vec3::Z)
    }

    #[test]
    fn a_scene_without_an_end_is_turned_like_a_box() {
        let space = |center| Space::Contracted(Contracted { center, radius: 5.0 });
        let start = view().own;
        let around = View::around(start, &space([0.0; 3]), Vec3::Z);
        let cameras = |view: View| view.orbit(4).iter().map(|v| v.camera(8, 8)).collect::<Vec<_>>();
        assert_eq!(cameras(around), cameras(view()));
        let moved = |mut view: View| {
            view.turn(0.3, -0.2);
            view.approach(2.0);
            view.shift(0.1, 0.1);
            cameras(view)
        };
        assert_eq!(moved(around), moved(view()));
        // The centre lies behind the camera: around a point a tenth of the cube's side ahead.
        let away = View::around(start, &space([6.0, 0.0, 0.0]), Vec3::Z).orbit(2)[1];
        assert!(is_at(&away, [2.0, 0.0, 0.0]), "{:?}", away.camera(200, 100).position());
    }

    fn is_at(view: &View, eye: [f32; 3]) -> bool {
        Vec3::from(view.camera(200, 100).position()).distance(Vec3::from(eye)) < 1e-5
    }

    #[test]
    fn an_untouched_view_is_the_first_camera() {
        let mut view = view();
        assert_eq!(view.camera(200, 100).camera_to_world, view.own.camera_to_world);
        view.turn(0.3, -0.2);
        view.approach(2.0);
        view.shift(0.1, 0.1);
        assert_ne!(view.camera(200, 100).camera_to_world, view.own.camera_to_world);
        view.reset();
        assert_eq!(view.camera(200, 100).camera_to_world, view.own.camera_to_world);
    }

    #[test]
    fn goes_to_a_camera_turns_from_there_and_returns() {
        let mut view = view();
        view.turn(0.3, -0.2);
        let pose = Camera::look_at([0.0, 2.0, 0.0], [0.0; 3], [0.0, 0.0, 1.0]);
        view.go_to(pose);
        assert_eq!(view.camera(200, 100).camera_to_world, pose);
        // Around the middle, from where it is now.
        view.turn(PI / 2.0, 0.0);
        assert!(is_at(&view, [-2.0, 0.0, 0.0]), "{:?}", view.camera(200, 100).position());
        // Its field of view is the model's own.
        assert_eq!(view.camera(200, 100).focal, view.own.focal);
        view.reset();
        assert_eq!(view, self::view());
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
