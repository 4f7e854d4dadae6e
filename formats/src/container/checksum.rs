//! CRC-32 (the one of zlib and PNG).
//!
//! With `std` the machine's own instructions or large tables compute it. A
//! microcontroller, which as a rule checks headers and metadata alone, gets
//! sixteen numbers instead of 16 KiB of them.

#[cfg(feature = "std")]
pub(crate) use crc32fast::Hasher;
#[cfg(not(feature = "std"))]
pub(crate) use small::Hasher;

/// The checksum of `bytes`.
pub(crate) fn hash(bytes: &[u8]) -> u32 {
    let mut hasher = Hasher::new();
    hasher.update(bytes);
    hasher.finalize()
}

#[cfg(any(test, not(feature = "std")))]
mod small {
    /// The remainder of every number of four bits; the polynomial is 0xedb88320.
    const TABLE: [u32; 16] = {
        let mut table = [0; 16];
        let mut i = 0;
        while i < 16 {
            let mut remainder = i as u32;
            let mut bit = 0;
            while bit < 4 {
                remainder = remainder >> 1 ^ (0xedb8_8320 * (remainder & 1));
                bit += 1;
            }
            table[i] = remainder;
            i += 1;
        }
        table
    };

    /// A checksum under way.
    pub(crate) struct Hasher(u32);

    impl Hasher {
        pub(crate) const fn new() -> Self {
            Self(!0)
        }

        pub(crate) fn update(&mut self, bytes: &[u8]) {
            for &byte in bytes {
                self.0 ^= u32::from(byte);
                for _ in 0..2 {
                    self.0 = self.0 >> 4 ^ TABLE[(self.0 & 15) as usize];
                }
            }
        }

        pub(crate) const fn finalize(self) -> u32 {
            !self.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_value_of_the_catalogues() {
        assert_eq!(hash(b"123456789"), 0xcbf4_3926);
        let mut small = small::Hasher::new();
        small.update(b"1234");
        small.update(b"56789");
        assert_eq!(small.finalize(), 0xcbf4_3926);
    }
}
