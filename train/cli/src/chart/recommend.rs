//! Chooses the setting that suits a device and a scene.

use std::fmt;
use std::str::FromStr;

use super::Point;

/// What a setting should achieve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wish {
    /// The fastest pictures with at least so many dB.
    Fastest {
        /// PSNR, dB.
        psnr: f64,
    },
    /// The most accurate pictures with at least so many per second.
    Accurate {
        /// Pictures per second.
        frames_per_second: f64,
    },
    /// The smallest file with at least so many dB.
    Smallest {
        /// PSNR, dB.
        psnr: f64,
    },
}

impl Wish {
    /// The best point measured here that achieves it; of equal ones the first.
    #[must_use]
    pub fn choose<'p>(&self, points: impl IntoIterator<Item = &'p Point>) -> Option<&'p Point> {
        let ours = points.into_iter().filter(|point| point.is_ours());
        // What must be reached, and what is minimised.
        let granted = ours.filter_map(|point| {
            let (psnr, ms) = (point.psnr?, point.ms_per_frame?);
            let (enough, cost) = match *self {
                Self::Fastest { psnr: least } => (psnr >= least, ms),
                Self::Smallest { psnr: least } => (psnr >= least, point.bytes? as f64),
                Self::Accurate { frames_per_second } => (1000.0 / ms >= frames_per_second, -psnr),
            };
            enough.then_some((point, [cost, ms]))
        });
        let chosen = granted.reduce(|best, next| if next.1 < best.1 { next } else { best });
        chosen.map(|(point, _)| point)
    }
}

impl fmt::Display for Wish {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fastest { psnr } => write!(f, "fastest with at least {psnr} dB"),
            Self::Accurate { frames_per_second } => {
                write!(f, "most accurate with at least {frames_per_second} frames a second")
            }
            Self::Smallest { psnr } => write!(f, "smallest file with at least {psnr} dB"),
        }
    }
}

impl FromStr for Wish {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "{text:?}: expected fastest=DB, smallest=DB or accurate=FRAMES_PER_SECOND, \
                 as fastest=32"
            )
        };
        let (kind, number) = text.split_once('=').ok_or_else(expected)?;
        let number = number.trim_end_matches("dB").trim_end_matches("fps").trim();
        let number = number.parse().ok().filter(|n: &f64| n.is_finite() && *n >= 0.0);
        let number = number.ok_or_else(expected)?;
        match kind {
            "fastest" => Ok(Self::Fastest { psnr: number }),
            "smallest" => Ok(Self::Smallest { psnr: number }),
            "accurate" => Ok(Self::Accurate { frames_per_second: number }),
            _ => Err(expected()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::point::OURS;

    #[test]
    fn wishes_are_granted_or_not() {
        let point = |id: &str, ms: f64, psnr: f64, bytes: u64| Point {
            id: id.to_owned(),
            program: OURS.to_owned(),
            ms_per_frame: Some(ms),
            psnr: Some(psnr),
            bytes: Some(bytes),
            ..Point::default()
        };
        let mut points = vec![
            point("small", 50.0, 31.0, 100),
            point("quick", 10.0, 32.0, 500),
            point("fine", 100.0, 35.0, 400),
            point("fine again", 90.0, 35.0, 400),
        ];
        points.push(Point { program: "another".to_owned(), ..point("theirs", 1.0, 40.0, 1) });
        let chosen = |wish: &str| {
            let wish: Wish = wish.parse().unwrap();
            wish.choose(&points).map(|point| point.id.as_str())
        };
        assert_eq!(chosen("fastest=30"), Some("quick"));
        assert_eq!(chosen("fastest=33dB"), Some("fine again"));
        assert_eq!(chosen("smallest=30"), Some("small"));
        assert_eq!(chosen("smallest=32"), Some("fine again"));
        assert_eq!(chosen("accurate=15 fps"), Some("quick"));
        assert_eq!(chosen("accurate=1"), Some("fine again"));
        assert_eq!(chosen("fastest=36"), None);
        for bad in ["fastest", "fastest=", "best=3", "fastest=-1", "smallest=NaN"] {
            assert!(bad.parse::<Wish>().unwrap_err().contains("expected fastest=DB"), "{bad}");
        }
    }
}
