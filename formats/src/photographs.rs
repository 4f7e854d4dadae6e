//! Where the photographs were taken.

#[cfg(feature = "alloc")]
use pocketnerf_core::Camera;
use pocketnerf_core::math;

/// Cameras of the photographs that a model was trained on, or an even choice of them: where
/// people may look from, and see what photographs have seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photographs<'a> {
    /// The median of their focal lengths, in widths of their pictures, greater than 0.
    pub focal: f32,
    /// The corners of the box around their positions, scene units.
    pub bounds: [[f32; 3]; 2],
    /// Twelve bytes a camera: its position as fractions of the box, then the first three parts of
    /// the unit quaternion (x, y, z, w) of its rotation, w >= 0; each a `u16`, of 65,535 the
    /// fractions, and 32,767 parts above and below 32,767 the others.
    pub(crate) poses: &'a [u8],
}

/// Bytes of a camera.
pub(crate) const POSE_BYTES: usize = 12;
/// What 1 is, above the middle.
const ONE: f32 = 32_767.0;
const MOST: f32 = 65_535.0;

impl<'a> Photographs<'a> {
    /// Most cameras that are stored.
    pub const MOST: usize = 64;

    /// How many there are.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.poses.len() / POSE_BYTES
    }

    /// Whether there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Their poses, camera-to-world as in [`Camera::camera_to_world`], scene units.
    pub fn poses(&self) -> impl ExactSizeIterator<Item = [f32; 16]> + use<'a> {
        let [low, high] = self.bounds;
        self.poses.as_chunks::<POSE_BYTES>().0.iter().map(move |bytes| {
            let value = |i: usize| f32::from(u16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]));
            let at = |a: usize| low[a] + value(a) / MOST * (high[a] - low[a]);
            pose([3, 4, 5].map(|i| value(i) / ONE - 1.0), [0, 1, 2].map(at))
        })
    }
}

/// The pose with this rotation, of whose quaternion w is left out, and position.
fn pose([x, y, z]: [f32; 3], position: [f32; 3]) -> [f32; 16] {
    let length = x * x + y * y + z * z;
    let w = math::sqrt((1.0 - length).max(0.0));
    // Rounding, or a file that is damaged.
    let s = 2.0 / (length + w * w);
    let [px, py, pz] = position;
    [
        1.0 - s * (y * y + z * z),
        s * (x * y - w * z),
        s * (x * z + w * y),
        px,
        s * (x * y + w * z),
        1.0 - s * (x * x + z * z),
        s * (y * z - w * x),
        py,
        s * (x * z - w * y),
        s * (y * z + w * x),
        1.0 - s * (x * x + y * y),
        pz,
        0.0,
        0.0,
        0.0,
        1.0,
    ]
}

/// The cameras of photographs as bytes, from which [`Photographs`] borrow.
#[cfg(feature = "alloc")]
#[derive(Clone, Debug, PartialEq)]
pub struct PhotographList {
    focal: f32,
    bounds: [[f32; 3]; 2],
    poses: alloc::vec::Vec<u8>,
}

#[cfg(feature = "alloc")]
impl PhotographList {
    /// Of these cameras, in scene units; of many, [`Photographs::MOST`], evenly spread over the
    /// list. `None` without cameras.
    #[must_use]
    pub fn new(cameras: &[Camera]) -> Option<Self> {
        let n = cameras.len().min(Photographs::MOST);
        let chosen = || (0..n).map(|i| &cameras[i * cameras.len() / n]);
        let first = cameras.first()?.position();
        let mut bounds = [first, first];
        for camera in chosen() {
            let position = camera.position();
            for a in 0..3 {
                bounds[0][a] = bounds[0][a].min(position[a]);
                bounds[1][a] = bounds[1][a].max(position[a]);
            }
        }
        let [low, high] = bounds;
        let mut poses = alloc::vec::Vec::with_capacity(n * POSE_BYTES);
        for camera in chosen() {
            let position = camera.position();
            let part =
                |a: usize| (position[a] - low[a]) / (high[a] - low[a]).max(f32::MIN_POSITIVE);
            let fractions = [0, 1, 2].map(|a| part(a) * MOST);
            let turn = quaternion(&camera.camera_to_world).map(|part| (part + 1.0) * ONE);
            for value in fractions.iter().chain(&turn) {
                poses.extend_from_slice(&((value + 0.5) as u16).to_le_bytes());
            }
        }
        let focal = |camera: &Camera| camera.focal[0] / camera.width as f32;
        let mut focals: alloc::vec::Vec<f32> = chosen().map(focal).collect();
        focals.sort_by(f32::total_cmp);
        Some(Self { focal: focals[n / 2], bounds, poses })
    }

    /// The cameras, to be written.
    #[must_use]
    pub fn view(&self) -> Photographs<'_> {
        Photographs { focal: self.focal, bounds: self.bounds, poses: &self.poses }
    }
}

/// x, y and z of the quaternion of a pose's rotation whose w is not negative (Shepperd 1978).
#[cfg(feature = "alloc")]
fn quaternion(pose: &[f32; 16]) -> [f32; 3] {
    let m = |row: usize, column: usize| pose[4 * row + column];
    let trace = m(0, 0) + m(1, 1) + m(2, 2);
    // Four times the square of each part; the largest is at least 1.
    let squares = [
        1.0 + 2.0 * m(0, 0) - trace,
        1.0 + 2.0 * m(1, 1) - trace,
        1.0 + 2.0 * m(2, 2) - trace,
        1.0 + trace,
    ];
    let most = (0..4).max_by(|a, b| squares[*a].total_cmp(&squares[*b])).unwrap_or(3);
    let whole = math::sqrt(squares[most].max(1e-6));
    // Four times each part times the largest.
    let pair = |a: usize, b: usize| m(a, b) + m(b, a);
    let turn = [m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)];
    let times = |part: usize| match most {
        3 => turn[part],
        _ if part == most => squares[most],
        _ => pair(part, most),
    };
    let w = if most == 3 { squares[3] } else { turn[most] };
    let sign = if w < 0.0 { -0.5 } else { 0.5 };
    [0, 1, 2].map(|part| (sign * times(part) / whole).clamp(-1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_come_back() {
        let eyes = [[4.0, 0.5, 1.0], [-3.0, 2.0, 0.1], [0.3, -4.0, 2.0], [0.1, 0.2, -4.0]];
        let cameras = eyes.map(|eye| {
            let pose = Camera::look_at(eye, [0.1, 0.0, 0.2], [0.0, 0.6, 0.8]);
            Camera::from_fov_x(40, 30, 0.7, pose)
        });
        let list = PhotographList::new(&cameras).unwrap();
        let photographs = list.view();
        assert_eq!((photographs.len(), photographs.is_empty()), (4, false));
        assert_eq!(photographs.bounds, [[-3.0, -4.0, -4.0], [4.0, 2.0, 2.0]]);
        assert!((photographs.focal - cameras[0].focal[0] / 40.0).abs() < 1e-5);
        for (pose, camera) in photographs.poses().zip(&cameras) {
            for (found, expected) in pose.iter().zip(&camera.camera_to_world) {
                assert!((found - expected).abs() < 2e-4, "{pose:?} {camera:?}");
            }
        }
        assert_eq!(PhotographList::new(&[]), None);
    }

    /// A half turn about each axis has no w; one about none is nothing but w.
    #[test]
    fn half_turns() {
        for (turned, expected) in [
            ([1.0, -1.0, -1.0], [1.0, 0.0, 0.0]),
            ([-1.0, 1.0, -1.0], [0.0, 1.0, 0.0]),
            ([-1.0, -1.0, 1.0], [0.0, 0.0, 1.0]),
            ([1.0, 1.0, 1.0], [0.0; 3]),
        ] {
            let mut matrix = [0.0; 16];
            (0..3).for_each(|a| matrix[5 * a] = turned[a]);
            matrix[15] = 1.0;
            assert_eq!(quaternion(&matrix), expected);
            let back = pose(expected, [0.0; 3]);
            assert!(back.iter().zip(&matrix).all(|(a, b)| (a - b).abs() < 1e-6), "{back:?}");
        }
    }

    #[test]
    fn of_many_an_even_choice() {
        let cameras: alloc::vec::Vec<Camera> = (0..1000)
            .map(|i| {
                let pose = Camera::look_at([i as f32, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 1.0]);
                Camera::from_fov_x(40, 30, 0.7, pose)
            })
            .collect();
        let list = PhotographList::new(&cameras).unwrap();
        let found: alloc::vec::Vec<f32> = list.view().poses().map(|pose| pose[3]).collect();
        assert_eq!(found.len(), Photographs::MOST);
        for (i, x) in found.iter().enumerate() {
            assert!((x - (1000 * i / 64) as f32).abs() < 0.01, "{i} {x}");
        }
    }

    /// Whatever the bytes are, a pose is a rotation.
    #[test]
    fn damaged_bytes_are_poses() {
        for bytes in [[0u8; 12], [0xff; 12], [0x7f; 12]] {
            let photographs =
                Photographs { focal: 0.7, bounds: [[0.0; 3], [1.0; 3]], poses: &bytes };
            let pose = photographs.poses().next().unwrap();
            let rows = [0, 1, 2].map(|row| [0, 1, 2].map(|column| pose[4 * row + column]));
            assert!(pocketnerf_core::query::is_rotation(&rows), "{pose:?}");
        }
    }
}
