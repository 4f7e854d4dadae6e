//! How much memory the images of a dataset need, from their headers alone.

use std::path::Path;

use rayon::prelude::*;

use super::{DatasetError, images};

/// The largest factor that is proposed.
const MOST: u32 = 64;

/// Refuses images that do not fit into `free` bytes once they are `factor` times smaller.
pub(super) fn check(
    folder: &Path,
    names: &[String],
    factor: u32,
    free: u64,
) -> Result<(), DatasetError> {
    // What has no header will be told of when it is decoded.
    let size = |name: &String| images::size(&folder.join(name)).unwrap_or_default();
    let sizes: Vec<[u32; 2]> = names.par_iter().map(size).collect();
    let threads = rayon::current_num_threads();
    let needed = |factor| needed(&sizes, factor, threads);
    if needed(factor) <= free {
        return Ok(());
    }
    Err(DatasetError::Memory {
        folder: folder.to_owned(),
        images: sizes.len(),
        largest: sizes.iter().copied().max_by_key(|size| pixels(*size)).unwrap_or_default(),
        needed: needed(factor),
        free,
        factor: (factor + 1..=MOST).find(|factor| needed(*factor) <= free),
    })
}

/// Bytes for all images, `factor` times smaller, and for those that are decoded at a time: as
/// the file has them, and as RGBA.
fn needed(sizes: &[[u32; 2]], factor: u32, threads: usize) -> u64 {
    let small = |[width, height]: [u32; 2]| pixels([width / factor.max(1), height / factor.max(1)]);
    let kept: u64 = sizes.iter().map(|size| 4 * small(*size)).sum();
    let mut whole: Vec<u64> = sizes.iter().map(|size| 8 * pixels(*size)).collect();
    whole.sort_unstable_by(|a, b| b.cmp(a));
    kept + whole.iter().take(threads).sum::<u64>()
}

fn pixels([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_by_hand() {
        // Two images kept at half their sides, and the larger one decoded.
        assert_eq!(needed(&[[10, 20], [4, 4]], 2, 1), 4 * (50 + 4) + 8 * 200);
        assert_eq!(needed(&[[10, 20], [4, 4]], 1, 8), 4 * 216 + 8 * 216);
        // 2,000 photographs of 3840x2160 pixels, two at a time.
        let photographs = vec![[3840, 2160]; 2000];
        assert_eq!(needed(&photographs, 1, 2), (8000 + 16) * 3840 * 2160);
    }
}
