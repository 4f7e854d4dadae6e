//! Natural order: `2.png` before `10.png`.

use std::cmp::Ordering;

/// Compares names; runs of digits by their value.
pub(super) fn compare(a: &str, b: &str) -> Ordering {
    let (mut a, mut b) = (a.as_bytes(), b.as_bytes());
    loop {
        let (digits_a, digits_b) = (digits(a), digits(b));
        let (head_a, head_b) = match (digits_a, digits_b) {
            (0, _) | (_, 0) => (a.len().min(1), b.len().min(1)),
            both => both,
        };
        let ((x, rest_a), (y, rest_b)) = (a.split_at(head_a), b.split_at(head_b));
        let order = match digits_a.min(digits_b) {
            0 => x.cmp(y),
            _ => {
                let value = |run: &[u8]| run.iter().position(|c| *c != b'0').unwrap_or(run.len());
                let (x, y) = (&x[value(x)..], &y[value(y)..]);
                x.len().cmp(&y.len()).then_with(|| x.cmp(y))
            }
        };
        if order != Ordering::Equal || (rest_a.is_empty() && rest_b.is_empty()) {
            return order;
        }
        (a, b) = (rest_a, rest_b);
    }
}

/// Digits at the start.
fn digits(text: &[u8]) -> usize {
    text.iter().take_while(|c| c.is_ascii_digit()).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_count() {
        let mut names = ["a10", "a2", "b1", "a", "a1b", "a010c", "a1", ""];
        names.sort_by(|a, b| compare(a, b));
        assert_eq!(names, ["", "a", "a1", "a1b", "a2", "a10", "a010c", "b1"]);
    }
}
