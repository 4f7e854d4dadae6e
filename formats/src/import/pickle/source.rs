//! The bytes of a pickle, one argument after the other.

use core::str;

use crate::import::ImportError;

/// Where the machine is in the bytes.
#[derive(Debug)]
pub(super) struct Source<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Source<'a> {
    pub(super) const fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at }
    }

    pub(super) const fn at(&self) -> usize {
        self.at
    }

    pub(super) fn take(&mut self, n: usize) -> Result<&'a [u8], ImportError> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let taken = rest.get(..n).ok_or(ImportError::CutOff("the pickle"))?;
        self.at += n;
        Ok(taken)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N], ImportError> {
        let (array, _) = self.take(N)?.split_first_chunk().ok_or(ImportError::CutOff(""))?;
        Ok(*array)
    }

    pub(super) fn byte(&mut self) -> Result<u8, ImportError> {
        Ok(self.array::<1>()?[0])
    }

    /// A length of four bytes, then as many bytes.
    pub(super) fn counted_by_u32(&mut self) -> Result<&'a [u8], ImportError> {
        let n = u32::from_le_bytes(self.array()?);
        self.take(usize::try_from(n).unwrap_or(usize::MAX))
    }

    /// A length of eight bytes, then as many bytes.
    pub(super) fn counted_by_u64(&mut self) -> Result<&'a [u8], ImportError> {
        let n = u64::from_le_bytes(self.array()?);
        self.take(usize::try_from(n).unwrap_or(usize::MAX))
    }

    /// A length of one byte, then as many bytes.
    pub(super) fn counted_by_u8(&mut self) -> Result<&'a [u8], ImportError> {
        let n = self.byte()?;
        self.take(n.into())
    }

    /// Up to the end of the line, which is not part of it.
    pub(super) fn line(&mut self) -> Result<&'a str, ImportError> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let end = rest.iter().position(|&byte| byte == b'\n');
        let line = self.take(end.ok_or(ImportError::CutOff("the pickle"))?)?;
        self.at += 1;
        self.text(line)
    }

    pub(super) fn text(&self, bytes: &'a [u8]) -> Result<&'a str, ImportError> {
        str::from_utf8(bytes).map_err(|_| self.expected("a text in UTF-8"))
    }

    pub(super) const fn expected(&self, expected: &'static str) -> ImportError {
        ImportError::Pickle { at: self.at, expected }
    }
}
