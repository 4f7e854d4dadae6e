//! Values of voxels, packed: each is expected to be as the corners before it in its brick, and to
//! differ from them as the colour before it does. What is left is coded in bits.

use pocketnerf_core::encoding::spherical_harmonics::n_output;
use pocketnerf_core::encoding::voxel_grid::{BRICK, BRICK_SIDE};
use pocketnerf_core::field::PlenoxelField;

use super::bits::{BitReader, Bits, Probability};

/// Most harmonics of a colour.
const MAX_HARMONICS: usize = n_output(PlenoxelField::MAX_SH_DEGREE);
/// Most values of a corner: its density, and three colours.
const MAX_VALUES: usize = 1 + 3 * MAX_HARMONICS;
/// How uncertain a value may be, in bits; the last where there is nothing to tell it by.
const CLASSES: usize = 8;
/// As uncertain as this is a value that is told by one corner alone.
const LONE: u32 = 4;
/// Most bits of a difference behind its first one.
const MAX_LENGTH: u32 = 7;

/// What a corner holds.
#[derive(Clone, Copy)]
pub(crate) struct Shape {
    /// Values of a corner, those that are always 0 included.
    pub(crate) width: u8,
    /// Harmonics of a colour.
    pub(crate) harmonics: u8,
}

/// The situations of a value, of each place at a corner.
#[derive(Clone, Copy)]
struct Contexts {
    is_zero: [Probability; CLASSES],
    /// By the sign of what is expected of it because of the colour before it.
    is_negative: [Probability; 3],
    is_longer: [[Probability; MAX_LENGTH as usize]; CLASSES],
    /// The first bit behind the leading one.
    half: [Probability; MAX_LENGTH as usize],
}

impl Contexts {
    const EVEN: Self = Self {
        is_zero: [Probability::EVEN; CLASSES],
        is_negative: [Probability::EVEN; 3],
        is_longer: [[Probability::EVEN; MAX_LENGTH as usize]; CLASSES],
        half: [Probability::EVEN; MAX_LENGTH as usize],
    };

    /// The difference of a value from what is expected: a writer is told which it is.
    #[inline(always)]
    fn difference(&mut self, bits: &mut impl Bits, class: usize, sign: i32, known: i32) -> i32 {
        if bits.code(known == 0, &mut self.is_zero[class]) {
            return 0;
        }
        let is_negative = bits.code(known < 0, &mut self.is_negative[(sign + 1) as usize]);
        let known = known.unsigned_abs();
        let known_length = known.max(1).ilog2();
        let mut length = 0;
        while length < MAX_LENGTH
            && bits.code(known_length > length, &mut self.is_longer[class][length as usize])
        {
            length += 1;
        }
        let mut magnitude = 1;
        for place in (0..length).rev() {
            let bit = known >> place & 1 == 1;
            let bit = match place + 1 == length {
                true => bits.code(bit, &mut self.half[place as usize]),
                false => bits.code(bit, &mut Probability::EVEN.clone()),
            };
            magnitude = magnitude << 1 | i32::from(bit);
        }
        if is_negative { -magnitude } else { magnitude }
    }
}

/// Codes all bricks, one after another: a writer reads `values`, a reader writes them. `None` for
/// a shape that there is not, and for a value that has more than eight bits.
pub(crate) fn code(bits: &mut impl Bits, shape: Shape, values: &mut [u8]) -> Option<()> {
    let [width, harmonics] = [shape.width, shape.harmonics].map(usize::from);
    if !(1..=MAX_HARMONICS).contains(&harmonics) || width < 1 + 3 * harmonics {
        return None;
    }
    let mut contexts = [Contexts::EVEN; MAX_VALUES];
    let (mut is_held, mut is_corner_held) = ([Probability::EVEN; 2], [Probability::EVEN; 8]);
    let mut held = false;
    let mut bricks = values.chunks_exact_mut(BRICK * width);
    for brick in &mut bricks {
        held = bits.code(holds(brick), &mut is_held[usize::from(held)]);
        if held {
            code_brick(bits, shape, (&mut is_corner_held, &mut contexts), brick)?;
        } else {
            brick.fill(0);
        }
    }
    bricks.into_remainder().is_empty().then_some(())
}

fn holds(values: &[u8]) -> bool {
    values.iter().any(|value| *value != 0)
}

/// The corners of a brick that holds something.
fn code_brick(
    bits: &mut impl Bits,
    shape: Shape,
    (is_held, contexts): (&mut [Probability; 8], &mut [Contexts; MAX_VALUES]),
    brick: &mut [u8],
) -> Option<()> {
    let [width, harmonics] = [shape.width, shape.harmonics].map(usize::from);
    let side = BRICK_SIDE as usize;
    let mut held = [false; BRICK];
    for corner in 0..BRICK {
        let (before, rest) = brick.split_at_mut(corner * width);
        let own = &mut rest[..width];
        // The corners before it along x, y and z that hold something.
        let (mut beside, mut n_beside, mut context) = ([&[][..]; 3], 0, 0);
        for (axis, step) in [1, side, side * side].into_iter().enumerate() {
            if corner / step % side > 0 && held[corner - step] {
                beside[n_beside] = &before[(corner - step) * width..][..width];
                n_beside += 1;
                context |= 1 << axis;
            }
        }
        held[corner] = bits.code(holds(own), &mut is_held[context]);
        if !held[corner] {
            own.fill(0);
            continue;
        }
        let mut surprises = [0i32; MAX_VALUES];
        let (values, unused) = own.split_at_mut(1 + 3 * harmonics);
        unused.fill(0);
        for (i, (value, contexts)) in values.iter_mut().zip(&mut *contexts).enumerate() {
            let (mut sum, mut low, mut high) = (0, i32::MAX, i32::MIN);
            for corner in &beside[..n_beside] {
                let value = i32::from(corner[i].cast_signed());
                (sum, low, high) = (sum + value, low.min(value), high.max(value));
            }
            let mean = sum / n_beside.max(1) as i32;
            let surprise = if i > harmonics { surprises[i - harmonics] } else { 0 };
            let doubt = match n_beside {
                0 | 1 => LONE,
                _ => high.abs_diff(low) / 2,
            } + surprise.unsigned_abs();
            let class = match n_beside {
                0 => CLASSES - 1,
                _ => ((u32::BITS - doubt.leading_zeros()) as usize).min(CLASSES - 2),
            };
            let expected = (mean + surprise).clamp(i8::MIN.into(), i8::MAX.into());
            let known = i32::from(value.cast_signed()) - expected;
            let found = expected + contexts.difference(bits, class, surprise.signum(), known);
            *value = i8::try_from(found).ok()?.cast_unsigned();
            surprises[i] = found - mean;
        }
    }
    Some(())
}

/// The values of all bricks.
pub(crate) fn unpack(packed: &[u8], out: &mut [u8]) -> Option<()> {
    let ([width, harmonics], packed) = packed.split_first_chunk()?;
    let mut reader = BitReader::new(packed)?;
    code(&mut reader, Shape { width: *width, harmonics: *harmonics }, out)?;
    reader.is_at_end().then_some(())
}
