//! Values of voxels to fewer bytes.

use alloc::vec::Vec;

use super::bits::BitWriter;
use crate::packed::MOST_RATIO;
use crate::packed::voxels::{Shape, code};

/// Values of corners of this shape; `None` if they have another, or hold next to nothing.
pub(super) fn pack(values: &[u8], shape: Shape) -> Option<Vec<u8>> {
    let mut writer = BitWriter::new(alloc::vec![shape.width, shape.harmonics]);
    let mut read = values.to_vec();
    code(&mut writer, shape, &mut read)?;
    let packed = writer.finish();
    let is_refused = values.len() as u64 > MOST_RATIO * packed.len() as u64;
    // Values that should be 0 and are not do not come back.
    (read == values && !is_refused).then_some(packed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packed::voxels::unpack;

    /// Bricks of smooth values, of noise, of the largest differences, and of nothing.
    fn bricks(shape: Shape) -> Vec<u8> {
        let n_values = 1 + 3 * usize::from(shape.harmonics);
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        let mut values = Vec::new();
        for brick in 0..24u8 {
            for corner in 0..64u8 {
                let held = brick % 4 > 0 && random() > 50;
                for value in 0..shape.width {
                    values.push(match brick % 4 {
                        _ if !held || usize::from(value) >= n_values => 0,
                        1 => (3 * value).wrapping_add(2 * corner).wrapping_add(random() % 4),
                        2 => random(),
                        _ => [127, 128, 129, 0][usize::from(random() % 4)],
                    });
                }
            }
        }
        values
    }

    #[test]
    fn what_is_packed_comes_back() {
        for (width, harmonics) in [(4, 1), (16, 4), (32, 9), (28, 9)] {
            let shape = Shape { width, harmonics };
            let values = bricks(shape);
            let packed = pack(&values, shape).unwrap();
            // Whatever was there before.
            for filled in [0, 0xff] {
                let mut out = alloc::vec![filled; values.len()];
                unpack(&packed, &mut out).unwrap();
                assert!(out == values, "{width} {harmonics}");
            }
            assert_eq!(unpack(&packed, &mut alloc::vec![0; values.len() - 1]), None);
            assert_eq!(unpack(&packed[..packed.len() / 2], &mut alloc::vec![0; 64]), None);
        }
    }

    #[test]
    fn what_follows_from_its_neighbours_takes_few_bytes() {
        let shape = Shape { width: 16, harmonics: 4 };
        let values: Vec<u8> = (0..100u32 * 64 * 16)
            .map(|i| if i % 16 < 13 { (i % 16 * 3 + i / 16 % 4) as u8 } else { 0 })
            .collect();
        let packed = pack(&values, shape).unwrap();
        assert!(packed.len() < values.len() / 20, "{}", packed.len());
    }

    #[test]
    fn other_shapes_are_not_packed() {
        let shape = Shape { width: 16, harmonics: 4 };
        let mut values = bricks(shape);
        assert!(pack(&values[1..], shape).is_none());
        for (width, harmonics) in [(16, 0), (16, 6), (12, 4), (255, 10)] {
            assert!(pack(&values, Shape { width, harmonics }).is_none(), "{width} {harmonics}");
        }
        values[64 * 16 * 2 + 13] = 1;
        assert!(pack(&values, shape).is_none());
        assert!(pack(&[0; 64 * 16 * 4], shape).is_some());
        assert!(pack(&alloc::vec![0; 64 * 16 * 1000], shape).is_none());
    }
}
