//! A tensor whose numbers stay in the file until they are needed.

use core::ops::Range;
use std::sync::Arc;
use std::vec::Vec;

use half::{bf16, f16};

use super::ImportError;
use super::element::ElementType;

/// Most dimensions, those of torch and numpy.
pub(super) const MAX_RANK: usize = 64;
/// Most bytes of numbers that a tensor may be expanded to beyond its storage.
const MAX_EXPANDED: usize = 256 << 20;

/// A tensor of a checkpoint. Its numbers stay in the file until they are read.
#[derive(Clone, Debug)]
pub struct Tensor<'a> {
    element: ElementType,
    big_endian: bool,
    shape: Vec<usize>,
    /// In numbers, of each dimension; 0 for one of a single index.
    strides: Vec<usize>,
    /// In numbers, of the first.
    offset: usize,
    storage: Storage<'a>,
}

/// The bytes that one or more tensors lie in.
#[derive(Clone, Debug)]
pub(super) enum Storage<'a> {
    /// As they are in the file.
    File(&'a [u8]),
    /// Unpacked from a text.
    Decoded(Arc<[u8]>),
}

impl Storage<'_> {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::File(bytes) => bytes,
            Self::Decoded(bytes) => bytes,
        }
    }
}

/// How the numbers of a storage are written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbers {
    pub(super) element: ElementType,
    pub(super) big_endian: bool,
}

/// Which numbers of a storage are a tensor's.
#[derive(Clone, Debug)]
pub(super) struct Placement {
    pub(super) shape: Vec<usize>,
    pub(super) strides: Vec<usize>,
    pub(super) offset: usize,
}

impl Placement {
    /// One number after the other, the last index (or, in Fortran's order, the
    /// first) running fastest. `None` where there are too many numbers to count.
    pub(super) fn contiguous(shape: &[usize], fortran: bool) -> Option<Self> {
        let mut strides: Vec<usize> = shape.iter().map(|_| 0).collect();
        if !shape.contains(&0) {
            let mut stride = 1_usize;
            for i in 0..shape.len() {
                let axis = if fortran { i } else { shape.len() - 1 - i };
                strides[axis] = stride;
                stride = stride.checked_mul(shape[axis])?;
            }
        }
        Some(Self { shape: shape.to_vec(), strides, offset: 0 })
    }
}

impl<'a> Tensor<'a> {
    /// A tensor whose every number lies inside its storage; otherwise what is wrong.
    pub(super) fn new(
        numbers: Numbers,
        placement: Placement,
        storage: Storage<'a>,
    ) -> Result<Self, &'static str> {
        let Placement { shape, mut strides, offset } = placement;
        if shape.len() != strides.len() {
            return Err("its strides are not as many as its dimensions");
        }
        if shape.len() > MAX_RANK {
            return Err("more than 64 dimensions");
        }
        let is_empty = shape.contains(&0);
        let mut len = 1_usize;
        let mut last = Some(offset);
        for (&n, stride) in shape.iter().zip(&mut strides) {
            // The stride of a single index is never taken, and may be anything.
            if n <= 1 || is_empty {
                *stride = 0;
            }
            let reach = n.saturating_sub(1).checked_mul(*stride);
            last = last.and_then(|last| last.checked_add(reach?));
            if !is_empty {
                len = len.checked_mul(n).ok_or("its shape has more numbers than can be counted")?;
            }
        }
        let in_storage = storage.bytes().len() / numbers.element.size();
        let fits = is_empty || last.is_some_and(|last| last < in_storage);
        if !fits {
            return Err("it reaches beyond the end of its storage");
        }
        let Numbers { element, big_endian } = numbers;
        Ok(Self { element, big_endian, shape, strides, offset, storage })
    }

    /// The number of indices of each dimension; empty for a single number.
    #[must_use]
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// How many numbers it has.
    #[must_use]
    pub fn len(&self) -> usize {
        if self.is_empty() { 0 } else { self.shape.iter().product() }
    }

    /// Whether it has none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.shape.contains(&0)
    }

    /// The type of its numbers in the file.
    #[must_use]
    pub const fn element_type(&self) -> ElementType {
        self.element
    }

    /// Its numbers, the last index running fastest, as near as `f32` comes to them:
    /// a large `f64` becomes infinite. Whether they are finite is not looked at.
    ///
    /// # Errors
    /// [`ImportError::TooMuch`] for a tensor of more than 256 MB that repeats a
    /// smaller storage.
    pub fn to_f32(&self) -> Result<Vec<f32>, ImportError> {
        self.convert(|number| number as f32)
    }

    /// Its numbers, the last index running fastest, as near as `f64` comes to them.
    ///
    /// # Errors
    /// As [`Self::to_f32`].
    pub fn to_f64(&self) -> Result<Vec<f64>, ImportError> {
        self.convert(|number| number)
    }

    /// Its numbers as `i32`, the last index running fastest; fractions are cut off, and what is
    /// too large or too small becomes the nearest there is.
    ///
    /// # Errors
    /// As [`Self::to_f32`].
    pub fn to_i32(&self) -> Result<Vec<i32>, ImportError> {
        self.convert(|number| number as i32)
    }

    /// Its numbers, the last index running fastest, as near as `f16` comes to them.
    ///
    /// # Errors
    /// As [`Self::to_f32`].
    pub fn to_f16(&self) -> Result<Vec<f16>, ImportError> {
        self.convert(f16::from_f64)
    }

    /// The number of a tensor that has one.
    pub(super) fn number(&self) -> Option<f64> {
        match self.convert(|number| number).ok()?[..] {
            [number] => Some(number),
            _ => None,
        }
    }

    /// The bytes of a tensor of [`ElementType::U8`] or [`ElementType::Bool`], the
    /// last index running fastest: occupancy bits, pictures.
    ///
    /// # Errors
    /// [`ImportError::NotBytes`] for other types; those of [`Self::to_f32`].
    pub fn to_bytes(&self) -> Result<Vec<u8>, ImportError> {
        match self.element {
            ElementType::U8 | ElementType::Bool => self.gather(|[byte]: [u8; 1]| byte),
            other => Err(ImportError::NotBytes(other)),
        }
    }

    /// Its numbers as [`Self::to_f32`] gives them, little endian.
    pub(super) fn to_f32_bytes(&self) -> Result<Vec<u8>, ImportError> {
        Ok(self.convert(|number| (number as f32).to_le_bytes())?.into_flattened())
    }

    /// Some of the numbers of a tensor of one dimension; `None` where there are fewer.
    pub(super) fn part(&self, range: Range<usize>) -> Option<Self> {
        let (&[len], &[stride]) = (&self.shape[..], &self.strides[..]) else { return None };
        let fits = range.start <= range.end && range.end <= len;
        fits.then(|| Self {
            shape: Vec::from([range.len()]),
            strides: Vec::from([stride]),
            offset: self.offset + range.start * stride,
            ..self.clone()
        })
    }

    /// The same bytes as numbers of another type, little endian, where these are bytes one
    /// after another and a whole number of those.
    pub(super) fn reinterpreted(&self, element: ElementType) -> Option<Self> {
        let is_bytes = self.element == ElementType::U8 && self.offset == 0;
        let len = self.storage.bytes().len();
        if !is_bytes || self.shape != [len] || !len.is_multiple_of(element.size()) {
            return None;
        }
        let placement = Placement::contiguous(&[len / element.size()], false)?;
        Self::new(Numbers { element, big_endian: false }, placement, self.storage.clone()).ok()
    }

    /// Every number in the order of its indices, made something else.
    fn convert<T>(&self, to: impl Fn(f64) -> T) -> Result<Vec<T>, ImportError> {
        match self.element {
            ElementType::Bool => self.gather(|[byte]: [u8; 1]| to(u8::from(byte != 0).into())),
            ElementType::U8 => self.gather(|[byte]: [u8; 1]| to(byte.into())),
            ElementType::U16 => self.gather(|b| to(u16::from_le_bytes(b).into())),
            ElementType::U32 => self.gather(|b| to(u32::from_le_bytes(b).into())),
            ElementType::U64 => self.gather(|b| to(u64::from_le_bytes(b) as f64)),
            ElementType::I8 => self.gather(|b| to(i8::from_le_bytes(b).into())),
            ElementType::I16 => self.gather(|b| to(i16::from_le_bytes(b).into())),
            ElementType::I32 => self.gather(|b| to(i32::from_le_bytes(b).into())),
            ElementType::I64 => self.gather(|b| to(i64::from_le_bytes(b) as f64)),
            ElementType::F16 => self.gather(|b| to(f16::from_le_bytes(b).to_f64())),
            ElementType::Bf16 => self.gather(|b| to(bf16::from_le_bytes(b).to_f64())),
            ElementType::F32 => self.gather(|b| to(f32::from_le_bytes(b).into())),
            ElementType::F64 => self.gather(|b| to(f64::from_le_bytes(b))),
        }
    }

    /// Every number in the order of its indices.
    fn gather<const N: usize, T>(
        &self,
        from_little_endian: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<T>, ImportError> {
        let (numbers, _) = self.storage.bytes().as_chunks::<N>();
        let len = self.len();
        if len > numbers.len() && len > MAX_EXPANDED / size_of::<T>() {
            let what = "bytes of a tensor that repeats its storage";
            return Err(ImportError::TooMuch { what, limit: MAX_EXPANDED });
        }
        let mut gathered = Vec::with_capacity(len);
        let mut index = [0; MAX_RANK];
        let mut at = self.offset;
        while gathered.len() < len {
            let mut bytes = numbers[at];
            if self.big_endian {
                bytes.reverse();
            }
            gathered.push(from_little_endian(bytes));
            // As a mileometer counts: the last wheel, and those before it that it carries.
            for axis in (0..self.shape.len()).rev() {
                at += self.strides[axis];
                index[axis] += 1;
                if index[axis] < self.shape[axis] {
                    break;
                }
                at -= self.strides[axis] * self.shape[axis];
                index[axis] = 0;
            }
        }
        Ok(gathered)
    }
}

#[cfg(test)]
mod tests {
    use std::vec;

    use super::*;

    fn tensor(
        shape: &[usize],
        strides: &[usize],
        offset: usize,
    ) -> Result<Tensor<'static>, &'static str> {
        let numbers = Numbers { element: ElementType::U8, big_endian: false };
        let placement = Placement { shape: shape.to_vec(), strides: strides.to_vec(), offset };
        Tensor::new(numbers, placement, Storage::File(&[0, 1, 2, 3, 4, 5]))
    }

    #[test]
    fn strides_say_where_numbers_lie() {
        let transposed = tensor(&[3, 2], &[1, 3], 0).unwrap();
        assert_eq!(transposed.to_f32().unwrap(), [0.0, 3.0, 1.0, 4.0, 2.0, 5.0]);
        let expanded = tensor(&[2, 2], &[0, 1], 4).unwrap();
        assert_eq!(expanded.to_bytes().unwrap(), [4, 5, 4, 5]);
        let number = tensor(&[], &[], 5).unwrap();
        assert_eq!((number.len(), number.to_bytes().unwrap()), (1, vec![5]));
        let empty = tensor(&[usize::MAX, 0, usize::MAX], &[usize::MAX, 1, 7], 99).unwrap();
        assert_eq!((empty.len(), empty.to_bytes().unwrap()), (0, vec![]));
        // The stride of a single index may be anything.
        assert_eq!(tensor(&[1, 6], &[usize::MAX, 1], 0).unwrap().to_bytes().unwrap().len(), 6);
    }

    #[test]
    fn tensors_beyond_their_storage_are_refused() {
        tensor(&[6], &[1], 1).unwrap_err();
        tensor(&[2], &[6], 0).unwrap_err();
        tensor(&[], &[], 6).unwrap_err();
        tensor(&[3, 2], &[usize::MAX, usize::MAX], 0).unwrap_err();
        tensor(&[usize::MAX, 2], &[0, 0], 0).unwrap_err();
        tensor(&[2], &[1, 1], 0).unwrap_err();
        tensor(&[1; 65], &[1; 65], 0).unwrap_err();
    }

    #[test]
    fn a_tensor_that_repeats_a_byte_for_ever_is_not_unpacked() {
        let expanded = tensor(&[1 << 40], &[0], 0).unwrap();
        assert!(matches!(expanded.to_f32(), Err(ImportError::TooMuch { .. })));
        assert!(matches!(expanded.to_bytes(), Err(ImportError::TooMuch { .. })));
    }
}
