//! The widths of a network's layers: a short sequence without a heap.

use core::fmt;

use pocketnerf_core::network::{Dense, MAX_LAYERS};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// `n_in, n_hidden…, n_out`: one more than the network has layers.
/// In the file a sequence of `u32`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Widths {
    len: usize,
    values: [u32; MAX_LAYERS + 1],
}

impl Widths {
    /// Adds a width; `false` if there is no room.
    pub(crate) fn push(&mut self, width: u32) -> bool {
        let Some(free) = self.values.get_mut(self.len) else { return false };
        *free = width;
        self.len += 1;
        true
    }

    /// The widths of layers that follow one another; `None` for too many or too wide.
    pub(crate) fn of(layers: &[Dense<'_>]) -> Option<Self> {
        let mut widths = Self::default();
        let n_input = layers.first()?.weight.shape()[0];
        let outputs = layers.iter().map(|layer| layer.weight.shape()[1]);
        core::iter::once(n_input).chain(outputs).all(|width| widths.push(width)).then_some(widths)
    }

    pub(crate) fn as_slice(&self) -> &[u32] {
        &self.values[..self.len]
    }

    /// `[n_in, n_out]` of layer `layer`.
    pub(crate) fn layer(&self, layer: usize) -> Option<[u32; 2]> {
        let pair = self.as_slice().get(layer..)?;
        Some([*pair.first()?, *pair.get(1)?])
    }
}

impl Serialize for Widths {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.as_slice())
    }
}

impl<'de> Deserialize<'de> for Widths {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(WidthsVisitor)
    }
}

struct WidthsVisitor;

impl<'de> Visitor<'de> for WidthsVisitor {
    type Value = Widths;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "2 to {} widths", MAX_LAYERS + 1)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Widths, A::Error> {
        let mut widths = Widths::default();
        while let Some(width) = seq.next_element()? {
            if !widths.push(width) {
                return Err(A::Error::custom("too many layers"));
            }
        }
        if widths.len < 2 {
            return Err(A::Error::custom("no layer"));
        }
        Ok(widths)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sequence_of_varints() {
        let widths: Widths = postcard::from_bytes(&[3, 32, 0x80, 1, 4]).unwrap();
        assert_eq!(widths.as_slice(), [32, 128, 4]);
        assert_eq!(widths.layer(1), Some([128, 4]));
        assert_eq!(widths.layer(2), None);
        let mut buffer = [0; 8];
        assert_eq!(postcard::to_slice(&widths, &mut buffer).unwrap(), [3, 32, 0x80, 1, 4]);
    }

    #[test]
    fn refuses_too_few_and_too_many() {
        assert!(postcard::from_bytes::<Widths>(&[0]).is_err());
        assert!(postcard::from_bytes::<Widths>(&[1, 4]).is_err());
        assert!(postcard::from_bytes::<Widths>(&[11; 12]).is_ok());
        assert!(postcard::from_bytes::<Widths>(&[12; 13]).is_err());
        assert!(postcard::from_bytes::<Widths>(&[0xff, 0xff, 0xff, 0xff, 0x0f]).is_err());
    }
}
