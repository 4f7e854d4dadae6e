//! Which step each level gets: the least error for the bytes.

/// What a step of a level does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Candidate {
    /// Mean squared difference of pictures.
    pub(super) error: f64,
    /// Bytes.
    pub(super) rate: f64,
}

/// Halvings of the range of slopes.
const HALVINGS: usize = 60;

/// The number of a candidate for each level, whose rates sum up to at most `budget` and whose
/// errors to little; `None` where even the smallest are too large.
///
/// Lagrange's multiplier: for each slope, error per byte, every level takes what is best at that
/// slope; the smallest slope that fits is found by halving (Shoham and Gersho 1988). What is left
/// goes to the levels that gain most by it.
pub(super) fn choose(levels: &[Vec<Candidate>], budget: f64) -> Option<Vec<usize>> {
    let at = |slope: f64| -> Vec<usize> {
        let cost = |c: &Candidate| c.error + slope * c.rate;
        let best = |level: &Vec<Candidate>| {
            let numbered = level.iter().enumerate();
            numbered.min_by(|a, b| cost(a.1).total_cmp(&cost(b.1))).map_or(0, |(i, _)| i)
        };
        levels.iter().map(best).collect()
    };
    let rate = |chosen: &[usize]| -> f64 {
        levels.iter().zip(chosen).map(|(level, i)| level[*i].rate).sum()
    };
    let (mut low, mut high) = (-120.0f64, 0.0f64);
    let mut chosen = at(high.exp2());
    if rate(&chosen) > budget {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let tried = at(middle.exp2());
        if rate(&tried) <= budget {
            (high, chosen) = (middle, tried);
        } else {
            low = middle;
        }
    }
    loop {
        let left = budget - rate(&chosen);
        let mut best: Option<(f64, usize, usize)> = None;
        for (level, now) in chosen.iter().enumerate() {
            for (i, candidate) in levels[level].iter().enumerate() {
                let (old, more) = (levels[level][*now], candidate.rate - levels[level][*now].rate);
                let gain = old.error - candidate.error;
                if more <= left && gain > best.map_or(0.0, |(gain, ..)| gain) {
                    best = Some((gain, level, i));
                }
            }
        }
        let Some((_, level, i)) = best else { return Some(chosen) };
        chosen[level] = i;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(points: &[(f64, f64)]) -> Vec<Candidate> {
        points.iter().map(|(error, rate)| Candidate { error: *error, rate: *rate }).collect()
    }

    #[test]
    fn the_least_error_that_fits() {
        // The second level hardly suffers, the first does.
        let levels = [
            level(&[(0.0, 100.0), (0.5, 50.0), (0.9, 20.0)]),
            level(&[(0.0, 100.0), (0.01, 50.0), (0.2, 20.0)]),
        ];
        let found = |budget| choose(&levels, budget);
        assert_eq!(found(200.0), Some(vec![0, 0]));
        assert_eq!(found(150.0), Some(vec![0, 1]));
        assert_eq!(found(120.0), Some(vec![0, 2]));
        assert_eq!(found(119.0), Some(vec![1, 1]));
        assert_eq!(found(40.0), Some(vec![2, 2]));
        assert_eq!(found(39.0), None);
        // As good as any: by trying all.
        for budget in 40..=200 {
            let budget = f64::from(budget);
            let chosen = found(budget).unwrap();
            let of = |i: usize, j: usize| {
                let (a, b) = (levels[0][i], levels[1][j]);
                (a.error + b.error, a.rate + b.rate)
            };
            let all = (0..9).map(|n| of(n / 3, n % 3)).filter(|(_, rate)| *rate <= budget);
            let best = all.map(|(error, _)| error).fold(f64::INFINITY, f64::min);
            assert!(of(chosen[0], chosen[1]).0 <= best + 1e-12, "{budget}");
        }
    }
}
