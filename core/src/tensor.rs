//! Tensors as they lie in memory: borrowed bytes that say what they are.
//!
//! A value is `stored * 2^scale_log2`. The power of two keeps half-precision
//! values in f16's normal range (|stored| ≥ 6.1e-5), where decoding is exact
//! and cheap; a hash grid's values start near 1e-4 and would otherwise be
//! subnormal.

use crate::Error;

/// How one value is stored. Always little-endian, at any alignment.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DType {
    /// IEEE 754 binary32, 4 bytes.
    F32,
    /// IEEE 754 binary16, 2 bytes. Finite values only.
    F16,
    /// A whole number from -128 to 127, 1 byte. For the tables of grids.
    I8,
    /// A whole number from 0 to 65,535, 2 bytes. For indices.
    U16,
}

impl DType {
    /// Bytes a value.
    #[must_use]
    pub const fn size(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F16 | Self::U16 => 2,
            Self::I8 => 1,
        }
    }
}

/// In which order a tensor's values stand.
#[non_exhaustive]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Row after row: value `(r, c)` of a `[rows, cols]` tensor is number
    /// `r * cols + c`. A dense layer is `[n_in, n_out]` (input-major), a bias
    /// `[1, n_out]`, a grid level `[entries, features]`.
    RowMajor,
}

/// A borrowed two-dimensional tensor.
#[derive(Clone, Copy, Debug)]
pub struct TensorView<'a> {
    bytes: &'a [u8],
    dtype: DType,
    shape: [u32; 2],
    scale_log2: i8,
    layout: Layout,
}

/// What [`TensorView::scale_log2`] may be. The upper bound leaves room for
/// f16's exponent bias in f32: 2^(112 + 14) is finite.
pub const SCALE_LOG2: core::ops::RangeInclusive<i8> = -60..=14;

impl<'a> TensorView<'a> {
    /// An empty tensor: the placeholder in fixed-size arrays.
    pub const EMPTY: TensorView<'static> = TensorView {
        bytes: &[],
        dtype: DType::F32,
        shape: [0, 0],
        scale_log2: 0,
        layout: Layout::RowMajor,
    };

    /// Checks that `bytes` holds exactly `shape[0] * shape[1]` values.
    ///
    /// # Errors
    /// [`Error::TensorLength`], or [`Error::Range`] for an absurd scale.
    pub fn new(
        bytes: &'a [u8],
        dtype: DType,
        shape: [u32; 2],
        scale_log2: i8,
        layout: Layout,
    ) -> Result<Self, Error> {
        let expected = (shape[0] as usize)
            .checked_mul(shape[1] as usize)
            .and_then(|n| n.checked_mul(dtype.size()))
            .ok_or(Error::Range("tensor shape"))?;
        if expected != bytes.len() {
            return Err(Error::TensorLength { expected, found: bytes.len() });
        }
        if !SCALE_LOG2.contains(&scale_log2) {
            return Err(Error::Range("tensor scale_log2"));
        }
        Ok(Self { bytes, dtype, shape, scale_log2, layout })
    }

    /// The stored bytes.
    #[must_use]
    pub const fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// How a value is stored.
    #[must_use]
    pub const fn dtype(&self) -> DType {
        self.dtype
    }

    /// `[rows, cols]`.
    #[must_use]
    pub const fn shape(&self) -> [u32; 2] {
        self.shape
    }

    /// Rows.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.shape[0] as usize
    }

    /// Columns.
    #[must_use]
    pub const fn cols(&self) -> usize {
        self.shape[1] as usize
    }

    /// The exponent of the scale.
    #[must_use]
    pub const fn scale_log2(&self) -> i8 {
        self.scale_log2
    }

    /// Order of the values.
    #[must_use]
    pub const fn layout(&self) -> Layout {
        self.layout
    }

    /// The scale, 2^`scale_log2`, exactly.
    #[must_use]
    pub const fn scale(&self) -> f32 {
        f32::from_bits(((127 + self.scale_log2 as i32) as u32) << 23)
    }

    /// Value number `index`, scaled. The plain path: kernels decode slices.
    /// Out of range: 0.
    #[must_use]
    pub fn get(&self, index: usize) -> f32 {
        let stored = match self.dtype {
            DType::F32 => match self.bytes.as_chunks::<4>().0.get(index) {
                Some(b) => f32::from_le_bytes(*b),
                None => 0.0,
            },
            DType::F16 => match self.bytes.as_chunks::<2>().0.get(index) {
                Some(b) => f16_to_f32(u16::from_le_bytes(*b)),
                None => 0.0,
            },
            DType::I8 => self.bytes.get(index).map_or(0.0, |b| f32::from(b.cast_signed())),
            DType::U16 => match self.bytes.as_chunks::<2>().0.get(index) {
                Some(b) => f32::from(u16::from_le_bytes(*b)),
                None => 0.0,
            },
        };
        stored * self.scale()
    }

    /// Whether every stored value is finite. O(values).
    #[must_use]
    pub fn is_finite(&self) -> bool {
        match self.dtype {
            DType::F32 => {
                self.bytes.as_chunks::<4>().0.iter().all(|b| f32::from_le_bytes(*b).is_finite())
            }
            DType::F16 => self
                .bytes
                .as_chunks::<2>()
                .0
                .iter()
                .all(|b| u16::from_le_bytes(*b) & 0x7c00 != 0x7c00),
            DType::I8 | DType::U16 => true,
        }
    }
}

/// Decodes one finite f16, subnormals included, exactly.
///
/// Infinity and NaN decode to finite numbers of magnitude ≥ 65536 (they are
/// refused when a file is verified, and must not spread when it is not).
#[inline(always)]
#[must_use]
pub const fn f16_to_f32(bits: u16) -> f32 {
    let magnitude = ((bits & 0x7fff) as u32) << 13;
    let sign = ((bits & 0x8000) as u32) << 16;
    // The shifted exponent is biased by 15, f32's by 127: multiply by 2^112.
    let value = f32::from_bits(magnitude) * f32::from_bits((112 + 127) << 23);
    f32::from_bits(value.to_bits() | sign)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn f16_decodes_known_values() {
        for (bits, value) in [
            (0x0000, 0.0),
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0400, 6.103_515_6e-5),
            (0x0001, 5.960_464_5e-8),
            (0x3555, 0.333_251_95),
        ] {
            assert_eq!(f16_to_f32(bits), value, "{bits:#06x}");
        }
        assert!(f16_to_f32(0x7c00).is_finite() && f16_to_f32(0x7e00).is_finite());
    }

    #[test]
    fn length_must_match_shape() {
        let bytes = [0u8; 12];
        let view = TensorView::new(&bytes, DType::F16, [2, 3], -3, Layout::RowMajor).unwrap();
        assert_eq!(view.scale(), 0.125);
        assert_eq!(
            TensorView::new(&bytes, DType::F32, [2, 3], 0, Layout::RowMajor).unwrap_err(),
            Error::TensorLength { expected: 24, found: 12 }
        );
        assert!(
            TensorView::new(&bytes, DType::F32, [u32::MAX, u32::MAX], 0, Layout::RowMajor).is_err()
        );
    }
}
