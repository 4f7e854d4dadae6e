//! How much memory a file may take.

use super::ImportError;

/// Counts what reading a file allocates, before it is allocated: a few bytes can
/// ask for a great deal, and no honest file comes near the limit.
#[derive(Debug)]
pub(super) struct Budget {
    left: usize,
    limit: usize,
}

impl Budget {
    const AT_LEAST: usize = 64 << 20;

    /// For a file of this length: four times that, and 64 MB.
    pub(super) const fn of(file_bytes: usize) -> Self {
        let limit = file_bytes.saturating_mul(4).saturating_add(Self::AT_LEAST);
        Self { left: limit, limit }
    }

    pub(super) fn spend(&mut self, bytes: usize) -> Result<(), ImportError> {
        let too_much =
            ImportError::TooMuch { what: "bytes of memory for the file", limit: self.limit };
        self.left = self.left.checked_sub(bytes).ok_or(too_much)?;
        Ok(())
    }

    /// Room for `n` more in a vector that doubles, beside which its old self lies while
    /// it grows.
    pub(super) fn spend_on<T>(&mut self, n: usize) -> Result<(), ImportError> {
        self.spend(n.saturating_mul(3 * size_of::<T>()))
    }
}
