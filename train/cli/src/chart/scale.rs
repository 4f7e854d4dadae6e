//! Ranges of axes and the round numbers along them.

/// A range on a logarithmic scale with some room, from one round number to another.
pub(super) fn logarithmic(values: Vec<f64>) -> [f64; 2] {
    let [low, high] = ends(&values);
    let room = (high / low).powf(0.08).max(1.1);
    [low / room, high * room]
}

/// Round numbers on a logarithmic scale, as many per decade as fit.
pub(super) fn ticks(left: f64, right: f64) -> Vec<f64> {
    let steps: &[f64] = match right / left {
        ..3.0 => &[1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0],
        ..8.0 => &[1.0, 1.5, 2.0, 3.0, 5.0, 7.0],
        ..40.0 => &[1.0, 2.0, 5.0],
        ..400.0 => &[1.0, 3.0],
        _ => &[1.0],
    };
    let decades = left.log10().floor() as i32..=right.log10().ceil() as i32;
    let all = decades.flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
    all.filter(|tick| (left..=right).contains(tick)).collect()
}

/// The same on a linear one.
pub(super) fn linear(values: Vec<f64>) -> [f64; 2] {
    let [low, high] = ends(&values);
    let room = (0.08 * (high - low)).max(1e-3 * high.abs()).max(1e-6);
    [low - room, high + room]
}

fn ends(values: &[f64]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, 0.0], |[low, high], &v| [low.min(v), f64::max(high, v)])
}

/// A number in its shortest form.
pub(super) fn short(value: f64) -> String {
    let size = value.abs();
    let (scaled, unit) = match size {
        1e9.. => (value / 1e9, "G"),
        1e6.. => (value / 1e6, "M"),
        1e4.. => (value / 1e3, "k"),
        _ => (value, ""),
    };
    let digits = match scaled.abs() {
        100.0.. => 0,
        10.0.. => 1,
        1.0.. => 2,
        _ => 4,
    };
    let text = format!("{scaled:.digits$}");
    let text = if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        text.as_str()
    };
    format!("{text}{unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_numbers_along_a_logarithmic_axis() {
        assert_eq!(ticks(8.0, 70.0), [10.0, 20.0, 50.0]);
        assert_eq!(ticks(9.0, 1100.0), [10.0, 30.0, 100.0, 300.0, 1000.0]);
        assert_eq!(ticks(0.9, 2.1), [1.0, 1.2, 1.5, 2.0]);
    }

    #[test]
    fn short_numbers() {
        let cases =
            [(0.5, "0.5"), (33.25, "33.2"), (1234.0, "1234"), (2.5e6, "2.5M"), (1e4, "10k")];
        for (value, expected) in cases {
            assert_eq!(short(value), expected);
        }
    }
}
