//! What the user should know of photographs that do not agree.

use super::Disagreement;

/// Share of what photographs show that may lie outside the scene.
const OUTSIDE: f64 = 0.01;
/// Share of the occupied cells that `near` and `far` may hide from a camera. Usual ones hide none.
const CUT: f64 = 0.001;

impl Disagreement {
    /// What the user should know, a line each; `name` gives the name of a training view.
    #[must_use]
    pub fn lines(&self, name: impl Fn(usize) -> String) -> Vec<String> {
        let others = |n: usize| match n - 1 {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        let mut lines = Vec::new();
        if self.cut > CUT {
            lines.push(format!(
                "near and far hide {:.1} % of the scene from the cameras, expected at most {:.1} %; \
                 leave out --near and --far, or widen them",
                100.0 * self.cut,
                100.0 * CUT
            ));
        }
        if self.outside > OUTSIDE {
            lines.push(format!(
                "{:.1} % of what photographs show lies outside the scene's box or the silhouettes of \
                 the others, expected at most {:.0} %: the box is too small (--aabb), or poses or \
                 alpha of some photographs are wrong",
                100.0 * self.outside,
                100.0 * OUTSIDE
            ));
        }
        if let Some((view, noise)) = self.noisy.first() {
            lines.push(format!(
                "{}{}: noise of {noise:.0} of 255, expected about {:.0} as in other photographs; \
                 leave them out",
                name(*view),
                others(self.noisy.len()),
                self.usual_noise
            ));
        }
        // What is shifted looks blurred here and there.
        let blurred = if self.shift > 0.0 { &[][..] } else { &self.blurred };
        if let Some(view) = blurred.first() {
            lines.push(format!(
                "{}{}: blurred beside the other photographs; leave them out",
                name(*view),
                others(blurred.len())
            ));
        }
        // Their errors are said.
        let said = |view| blurred.contains(&view) || self.noisy.iter().any(|n| n.0 == view);
        let odd: Vec<_> = self.odd.iter().filter(|(view, _)| !said(*view)).collect();
        if let Some((view, psnr)) = odd.first() {
            lines.push(format!(
                "{}{}: {psnr:.1} dB, expected about {:.1} as in other photographs: pose, \
                 orientation, alpha or exposure may be wrong, or something stands in front; leave \
                 them out",
                name(*view),
                others(odd.len()),
                self.usual
            ));
        }
        // This follows from what was said.
        if !lines.is_empty() {
            return lines;
        }
        if self.shift > 0.0 {
            lines.push(format!(
                "photographs are shifted by {:.2} pixels against the model, each as a whole: poses \
                 are inexact; find them again",
                self.shift
            ));
        }
        if self.magnification != 0.0 {
            let (parts, length) = match self.magnification > 0.0 {
                true => ("large", "long"),
                false => ("small", "short"),
            };
            lines.push(format!(
                "near parts of photographs are too {parts} beside far ones, by {:.1} %: the focal \
                 length may be too {length}; find it again",
                100.0 * self.magnification.abs()
            ));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_finding_is_a_line() {
        let none = Disagreement { usual: 30.0, usual_noise: 2.0, ..Disagreement::default() };
        let lines = |all: Disagreement| all.lines(|view| format!("train/{view}.png"));
        assert!(lines(none.clone()).is_empty());
        let odd = vec![(3, 12.0), (4, 14.0)];
        let all = Disagreement { odd, cut: 0.3, outside: 0.2, shift: 0.4, ..none.clone() };
        let found = lines(all.clone());
        // What follows from these is not said.
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found[0].contains("hide 30.0 %") && found[1].starts_with("20.0 % of"), "{found:?}");
        assert!(found[2].starts_with("train/3.png and 1 more: 12.0 dB, expected about 30.0"));
        // Nor again, where it is said why.
        let blurred = vec![2, 4];
        let noisy = vec![(3, 22.4)];
        let all = Disagreement { blurred, noisy, outside: 0.0, cut: 0.0, ..all };
        let found = lines(Disagreement { shift: 0.0, ..all.clone() });
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(
            found[0].starts_with("train/3.png: noise of 22 of 255, expected about 2"),
            "{found:?}"
        );
        assert!(found[1].starts_with("train/2.png and 1 more: blurred"), "{found:?}");
        let found = lines(Disagreement { noisy: Vec::new(), ..all });
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("train/3.png and 1 more: 12.0 dB"), "{found:?}");
        let found = lines(Disagreement { shift: 0.432, magnification: -0.009, ..none });
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].starts_with("photographs are shifted by 0.43 pixels"), "{found:?}");
        assert!(found[1].contains("too small beside far ones, by 0.9 %"), "{found:?}");
        assert!(found[1].contains("too short"), "{found:?}");
    }
}
