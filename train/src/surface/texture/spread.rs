//! Texels without a colour.

use glam::Vec3;

/// Red, green and blue, and whether they are known.
pub(super) type Texel = [u8; 4];

/// A texel without a colour.
pub(super) const UNKNOWN: Texel = [0; 4];
/// The same, beside one that has one.
const NEXT: Texel = [0, 0, 0, 1];

/// sRGB from 0 to 255.
pub(super) fn known(color: Vec3) -> Texel {
    let [r, g, b] = color.round().to_array().map(|c| c as u8);
    [r, g, b, u8::MAX]
}

fn is_known(texel: Texel) -> bool {
    texel[3] == u8::MAX
}

/// Gives unknown texels, of those that `may` have one, the mean of the known ones of the eight
/// around each, so many texels far.
pub(super) fn spread(
    texels: &mut [Texel],
    size: usize,
    rounds: usize,
    may: impl Fn(usize) -> bool,
) {
    let all = 0..texels.len();
    let has_color = |texels: &[Texel], i| around(i, size).any(|i| is_known(texels[i]));
    let mut edge: Vec<usize> =
        all.filter(|i| texels[*i] == UNKNOWN && may(*i) && has_color(texels, *i)).collect();
    edge.iter().for_each(|i| texels[*i] = NEXT);
    for _ in 0..rounds {
        if edge.is_empty() {
            return;
        }
        let colors: Vec<Texel> = edge.iter().map(|i| mean(texels, *i, size)).collect();
        edge.iter().zip(colors).for_each(|(i, color)| texels[*i] = color);
        let mut next = Vec::new();
        for i in edge.iter().flat_map(|i| around(*i, size)) {
            if texels[i] == UNKNOWN && may(i) {
                texels[i] = NEXT;
                next.push(i);
            }
        }
        edge = next;
    }
    edge.iter().for_each(|i| texels[*i] = UNKNOWN);
}

/// The mean of the known texels around one, of which there are some.
fn mean(texels: &[Texel], i: usize, size: usize) -> Texel {
    let (mut sum, mut n) = (Vec3::ZERO, 0.0);
    for [r, g, b, _] in around(i, size).map(|i| texels[i]).filter(|texel| is_known(*texel)) {
        sum += Vec3::from([r, g, b].map(f32::from));
        n += 1.0;
    }
    known(sum / n)
}

/// The texels around one, itself among them.
fn around(i: usize, size: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (i % size, i / size);
    let near = move |at: usize| at.saturating_sub(1)..=(at + 1).min(size - 1);
    near(y).flat_map(move |y| near(x).map(move |x| y * size + x))
}
