//! A number that identifies a dataset, for resuming.

use rayon::prelude::*;

use super::{Dataset, View};
use crate::lens::Lens;

impl Dataset {
    /// A hash of the views, in order: their names, cameras, lenses, sizes, pixels and
    /// masks; and of what is known of the scene.
    /// The same on every machine and at any number of threads; where the
    /// dataset lies does not matter. Not meant against forgery.
    #[must_use]
    pub fn fingerprint(&self) -> u64 {
        let views: Vec<u64> = self.views.par_iter().map(View::fingerprint).collect();
        let hash = views.into_iter().fold(SEED, mix);
        // What most datasets do not have changes nothing where it is not there.
        let part = |hash, tag: u64, numbers: &[f32]| match numbers {
            [] => hash,
            numbers => numbers.iter().fold(mix(hash, tag), |h, x| mix(h, x.to_bits().into())),
        };
        let hash = part(hash, 1, self.bounds.as_ref().map_or(&[], |bounds| &bounds[..]));
        let hash = part(hash, 2, self.aabb.as_ref().map_or(&[], |aabb| aabb.as_flattened()));
        let hash = part(hash, 5, self.reach.as_ref().map_or(&[], |reach| reach.as_flattened()));
        let hash = part(hash, 4, self.background.as_ref().map_or(&[], |color| &color[..]));
        if self.forward_facing { mix(hash, 3) } else { hash }
    }
}

impl View {
    fn fingerprint(&self) -> u64 {
        let camera = &self.camera;
        let floats = camera.focal.iter().chain(&camera.center).chain(&camera.camera_to_world);
        let hash = hash_bytes(SEED, self.name.as_bytes());
        let hash = [camera.width, camera.height]
            .into_iter()
            .chain(floats.map(|x| x.to_bits()))
            .fold(hash, |hash, word| mix(hash, u64::from(word)));
        let mut hash = hash_bytes(hash, &self.rgba);
        if self.lens != Lens::Pinhole {
            hash = hash_bytes(hash, self.lens.name().as_bytes());
            hash = self.lens.coefficients().iter().fold(hash, |h, x| mix(h, x.to_bits()));
        }
        match &self.mask {
            Some(mask) => hash_bytes(mix(hash, 4), mask),
            None => hash,
        }
    }
}

/// Any odd number with mixed bits does; this is 2⁶⁴ divided by the golden ratio.
const SEED: u64 = 0x9e37_79b9_7f4a_7c15;

/// One step of a multiplicative hash; a bijection of `hash` for every `word`.
fn mix(hash: u64, word: u64) -> u64 {
    let product = (hash ^ word).wrapping_mul(SEED);
    product ^ (product >> 32)
}

/// A hash of bytes, as of a dataset.
pub fn hash_of(bytes: &[u8]) -> u64 {
    hash_bytes(SEED, bytes)
}

fn hash_bytes(hash: u64, bytes: &[u8]) -> u64 {
    let (words, rest) = bytes.as_chunks::<8>();
    let hash = words.iter().fold(hash, |hash, word| mix(hash, u64::from_le_bytes(*word)));
    let mut last = [0; 8];
    last[..rest.len()].copy_from_slice(rest);
    mix(mix(hash, u64::from_le_bytes(last)), bytes.len() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::Split;
    use pocketnerf_core::Camera;

    fn dataset() -> Dataset {
        let view = |name: &str, x: f32| {
            let pose = Camera::look_at([x, 0.0, 4.0], [0.0; 3], [0.0, 1.0, 0.0]);
            View::new(name, Camera::from_fov_x(3, 2, 0.7, pose), (0..24).collect())
        };
        let views = vec![view("a", 0.0), view("b", 1.0)];
        Dataset::new("x", "y", Split::Train, views)
    }

    #[test]
    fn every_part_counts() {
        let first = dataset().fingerprint();
        assert_eq!(first, dataset().fingerprint());
        let changes: [fn(&mut Dataset); 13] = [
            |d| d.views.swap(0, 1),
            |d| d.views[0].name.push('x'),
            |d| d.views[1].rgba[23] ^= 1,
            |d| d.views[1].rgba[0] ^= 0x80,
            |d| d.views[0].camera.focal[1] += 1e-3,
            |d| drop(d.views.pop()),
            |d| d.views[0].lens = Lens::open_cv([0.1, 0.0, 0.0, 0.0], [0.0; 2]),
            |d| d.views[0].lens = Lens::fisheye([0.1, 0.0, 0.0, 0.0]),
            |d| d.views[0].mask = Some(vec![255; 6]),
            |d| d.bounds = Some([1.0, 2.0]),
            |d| d.aabb = Some([[0.0; 3], [1.0; 3]]),
            |d| d.background = Some([1.0; 3]),
            |d| d.forward_facing = true,
        ];
        for (index, change) in changes.iter().enumerate() {
            let mut other = dataset();
            change(&mut other);
            assert_ne!(first, other.fingerprint(), "change {index}");
        }
        // Where it lies does not count.
        let moved = Dataset { source: "elsewhere".into(), ..dataset() };
        assert_eq!(first, moved.fingerprint());
    }

    #[test]
    fn the_value_never_changes() {
        assert_eq!(hash_bytes(SEED, b"pocketnerf"), 5_747_935_457_440_615_337);
    }
}
