//! DeRF, from the text of [`DerfField`].

use crate::field::{DerfField, Features, MAX_CHANNELS, ReferenceField};

impl ReferenceField for DerfField<'_> {
    fn reference(&self, u: [f32; 3], direction: [f32; 3]) -> (f64, Features) {
        // In f32, as every renderer has it: the first of the nearest.
        let distance = |head: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis| u[axis] - self.sites.get(3 * head + axis));
            x * x + y * y + z * z
        };
        let mut nearest = 0;
        for head in 1..self.n_heads() {
            if distance(head) < distance(nearest) {
                nearest = head;
            }
        }
        match self.head(nearest) {
            Ok(head) => head.reference(u, direction),
            Err(_) => (0.0, [0.0; MAX_CHANNELS]),
        }
    }
}
