//! Which step each level gets: the least error for the bytes.

use super::candidates::Candidate;

/// Halvings of the range of slopes, powers of two.
pub(super) const HALVINGS: usize = 12;
const SLOPES: [f64; 2] = [-60.0, 0.0];

/// The number of a candidate for each part, which all `fits` says fit, and whose errors sum up
/// to little; `None` where even those of the smallest rates do not fit.
///
/// Lagrange's multiplier: for each slope, error per byte, every part takes what is best at that
/// slope; the smallest slope that fits is found by halving (Shoham and Gersho 1988). What is left
/// goes to the parts that gain most by it. Rates may be estimates: `fits` knows. What training
/// knows does no harm: `known` candidates are the finest of their parts, until something is left.
pub(super) fn choose<E>(
    parts: &[Vec<Candidate>],
    known: &[Option<usize>],
    mut fits: impl FnMut(&[usize]) -> Result<bool, E>,
) -> Result<Option<Vec<usize>>, E> {
    let begin = |part: usize| known.get(part).copied().flatten().unwrap_or(0);
    let as_known = |(part, all): (usize, &Vec<Candidate>)| -> Vec<Candidate> {
        let all = &all[begin(part)..];
        let least = all.first().map_or(0.0, |candidate| candidate.error);
        all.iter().map(|c| Candidate { error: (c.error - least).max(0.0), ..*c }).collect()
    };
    let coarser: Vec<_> = parts.iter().enumerate().map(as_known).collect();
    let number = |(part, i): (usize, &usize)| begin(part) + i;
    let numbers =
        |chosen: &[usize]| -> Vec<usize> { chosen.iter().enumerate().map(number).collect() };
    let found = fitting(&coarser, |chosen| fits(&numbers(chosen)))?;
    let mut found = found.map(|chosen| numbers(&chosen));
    if let Some(chosen) = &mut found {
        fill(parts, chosen, fits)?;
    }
    Ok(found)
}

/// With the smallest slope that fits.
fn fitting<E>(
    parts: &[Vec<Candidate>],
    mut fits: impl FnMut(&[usize]) -> Result<bool, E>,
) -> Result<Option<Vec<usize>>, E> {
    let at = |slope| at(parts, slope);
    let [mut low, mut high] = SLOPES;
    let mut chosen = at(high);
    if !fits(&chosen)? {
        return Ok(None);
    }
    let mut refused = None;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let tried = at(middle);
        // Many slopes lead to the same choice.
        if tried == chosen || (refused.as_ref() != Some(&tried) && fits(&tried)?) {
            (high, chosen) = (middle, tried);
        } else {
            (low, refused) = (middle, Some(tried));
        }
    }
    Ok(Some(chosen))
}

/// The number of a candidate for each level, which take few bytes and are good; `None` where the
/// finest are not. The largest slope whose choice is good is found by halving; then levels become
/// coarser one by one, those first that save most for their error.
pub(super) fn coarsest<E>(
    levels: &[Vec<Candidate>],
    mut is_good: impl FnMut(&[usize]) -> Result<bool, E>,
) -> Result<Option<Vec<usize>>, E> {
    let mut chosen = vec![0; levels.len()];
    if !is_good(&chosen)? {
        return Ok(None);
    }
    let [mut low, mut high] = SLOPES;
    let mut refused = None;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let tried = at(levels, middle);
        if tried == chosen || (refused.as_ref() != Some(&tried) && is_good(&tried)?) {
            (low, chosen) = (middle, tried);
        } else {
            (high, refused) = (middle, Some(tried));
        }
    }
    let mut open: Vec<usize> = (0..levels.len()).collect();
    loop {
        let coarser = |level: usize| {
            let (i, all) = (chosen[level], &levels[level]);
            let next = (i + 1..all.len()).find(|next| all[*next].rate < all[i].rate)?;
            let more = (all[next].error - all[i].error).max(f64::MIN_POSITIVE);
            Some((level, next, (all[i].rate - all[next].rate) / more))
        };
        let moves = open.iter().filter_map(|level| coarser(*level));
        let Some((level, next, _)) = moves.max_by(|a, b| a.2.total_cmp(&b.2)) else { break };
        let before = std::mem::replace(&mut chosen[level], next);
        if !is_good(&chosen)? {
            chosen[level] = before;
            open.retain(|other| *other != level);
        }
    }
    Ok(Some(chosen))
}

/// What is best for each level where a byte is worth an error of 2^`slope`.
fn at(levels: &[Vec<Candidate>], slope: f64) -> Vec<usize> {
    let cost = |c: &Candidate| c.error + slope.exp2() * c.rate;
    let best = |level: &Vec<Candidate>| {
        let numbered = level.iter().enumerate();
        numbered.min_by(|a, b| cost(a.1).total_cmp(&cost(b.1))).map_or(0, |(i, _)| i)
    };
    levels.iter().map(best).collect()
}

/// Gives what is left to the levels that gain most by a byte, a step after the other.
fn fill<E>(
    levels: &[Vec<Candidate>],
    chosen: &mut [usize],
    mut fits: impl FnMut(&[usize]) -> Result<bool, E>,
) -> Result<(), E> {
    let mut open: Vec<usize> = (0..levels.len()).collect();
    loop {
        let finer = |level: usize| {
            let (i, all) = (chosen[level], &levels[level]);
            let next = (0..i).rev().find(|next| all[*next].error < all[i].error)?;
            let more = (all[next].rate - all[i].rate).max(1.0);
            Some((level, next, (all[i].error - all[next].error) / more))
        };
        let moves = open.iter().filter_map(|level| finer(*level));
        let Some((level, next, _)) = moves.max_by(|a, b| a.2.total_cmp(&b.2)) else { break };
        let before = std::mem::replace(&mut chosen[level], next);
        if !fits(chosen)? {
            chosen[level] = before;
            open.retain(|other| *other != level);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(points: &[(f64, f64)]) -> Vec<Candidate> {
        points
            .iter()
            .map(|(error, rate)| Candidate { step: 1, error: *error, rate: *rate })
            .collect()
    }

    #[test]
    fn the_fewest_bytes_that_are_good() {
        let levels = [
            level(&[(0.0, 100.0), (0.5, 50.0), (0.9, 20.0)]),
            level(&[(0.0, 100.0), (0.01, 50.0), (0.2, 20.0)]),
        ];
        let found = |most: f64| {
            let error = |chosen: &[usize]| -> f64 {
                levels.iter().zip(chosen).map(|(level, i)| level[*i].error).sum()
            };
            coarsest(&levels, |chosen| Ok::<_, ()>(error(chosen) <= most)).unwrap()
        };
        assert_eq!(found(-0.1), None);
        assert_eq!(found(0.0), Some(vec![0, 0]));
        assert_eq!(found(0.01), Some(vec![0, 1]));
        assert_eq!(found(0.2), Some(vec![0, 2]));
        // One and one would take fewer bytes, but no slope leads there.
        assert_eq!(found(0.51), Some(vec![0, 2]));
        assert_eq!(found(0.7), Some(vec![1, 2]));
        assert_eq!(found(1.1), Some(vec![2, 2]));
    }

    #[test]
    fn the_least_error_that_fits() {
        // The second level hardly suffers, the first does.
        let levels = [
            level(&[(0.0, 100.0), (0.5, 50.0), (0.9, 20.0)]),
            level(&[(0.0, 100.0), (0.01, 50.0), (0.2, 20.0)]),
        ];
        let begun = |known: Vec<Option<usize>>, budget: f64| {
            let rate = |chosen: &[usize]| -> f64 {
                levels.iter().zip(chosen).map(|(level, i)| level[*i].rate).sum()
            };
            choose(&levels, &known, |chosen| Ok::<_, ()>(rate(chosen) <= budget)).unwrap()
        };
        let found = |budget| begun(vec![None; 2], budget);
        // What fits is only refined.
        assert_eq!(begun(vec![Some(0), Some(2)], 120.0), Some(vec![0, 2]));
        assert_eq!(begun(vec![Some(1), Some(1)], 130.0), Some(vec![1, 1]));
        assert_eq!(begun(vec![Some(1), Some(1)], 199.0), Some(vec![0, 1]));
        assert_eq!(begun(vec![Some(0), Some(0)], 150.0), Some(vec![0, 1]));
        // What does not fit becomes coarser where that costs least, what is known as well: the
        // first from 0.5 to 0.9, not the second from 0 to 2.
        let parts =
            [level(&[(0.0, 100.0), (0.5, 50.0), (0.9, 40.0)]), level(&[(0.0, 20.0), (2.0, 10.0)])];
        let rate = |chosen: &[usize]| parts[0][chosen[0]].rate + parts[1][chosen[1]].rate;
        let fits = |chosen: &[usize]| Ok::<_, ()>(rate(chosen) <= 65.0);
        assert_eq!(choose(&parts, &[Some(1), None], fits).unwrap(), Some(vec![2, 0]));
        // The second is free.
        assert_eq!(begun(vec![Some(1), None], 100.0), Some(vec![1, 1]));
        assert_eq!(begun(vec![Some(1), None], 70.0), Some(vec![1, 2]));
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
