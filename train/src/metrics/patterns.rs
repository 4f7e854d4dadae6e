//! Pictures by formulas, for tests.

/// A picture and its truth, of a width and a height.
pub(super) type Make = fn(usize, usize) -> (Vec<u8>, Vec<u8>);

/// Waves, and the same with noise; as all here, those of `tests/fixtures/ssim_skimage.py`.
pub(super) fn patterns(width: usize, height: usize) -> (Vec<u8>, Vec<u8>) {
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for y in 0..height {
        for x in 0..width {
            for c in 0..3 {
                let value = (x * x + 3 * y * y + 5 * x * y + 40 * c) / 7 % 256;
                a.push(value as u8);
                let noise = (x * 7919 + y * 104_729 + c * 1_299_709) % 61;
                b.push((value + noise).saturating_sub(30).min(255) as u8);
            }
        }
    }
    (a, b)
}

/// Nearly white and smooth: where the variances are small differences.
pub(super) fn bright(width: usize, height: usize) -> (Vec<u8>, Vec<u8>) {
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for y in 0..height {
        for x in 0..width {
            for c in 0..3 {
                let value = 250 + (x / 5 + y / 7 + c) % 6;
                a.push(value as u8);
                b.push((value - (x * 3 + y) % 4) as u8);
            }
        }
    }
    (a, b)
}

/// Sharp squares, and the mean of each pixel and those around it, 15x15.
pub(super) fn soft(width: usize, height: usize) -> (Vec<u8>, Vec<u8>) {
    let value = |x: usize, y: usize, c: usize| (x / 6 * 97 + y / 9 * 57 + c * 71) * 31 % 256;
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for y in 0..height {
        for x in 0..width {
            for c in 0..3 {
                a.push(value(x, y, c) as u8);
                let mut sum = 0;
                for dy in 0..15 {
                    for dx in 0..15 {
                        let near =
                            |at: usize, d: usize, n: usize| (at + d).saturating_sub(7).min(n - 1);
                        sum += value(near(x, dx, width), near(y, dy, height), c);
                    }
                }
                b.push((sum / 225) as u8);
            }
        }
    }
    (a, b)
}

/// What is bright becomes dark: negative structure.
pub(super) fn inverted(width: usize, height: usize) -> (Vec<u8>, Vec<u8>) {
    let (a, _) = patterns(width, height);
    let b = a.iter().map(|value| 255 - value).collect();
    (a, b)
}
