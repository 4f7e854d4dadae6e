//! A cell of the table: one failure mode at one strength.

use serde::{Deserialize, Serialize};

/// What came of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The figure is within the bar.
    Within,
    /// It is not, and the program says so in a line.
    SaysSo,
    /// It is not, and nothing is said.
    Fails,
}

impl Verdict {
    /// Of a figure that is within its bar or not, and what was said.
    #[must_use]
    pub const fn of(within: bool, said: bool) -> Self {
        match (within, said) {
            (true, _) => Self::Within,
            (false, true) => Self::SaysSo,
            (false, false) => Self::Fails,
        }
    }

    /// As tables show it.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Within => "within",
            Self::SaysSo => "says so",
            Self::Fails => "fails",
        }
    }
}

/// A row of `stress.csv`, an object of `stress.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Name of the failure mode.
    pub mode: String,
    /// The kind of field; or the name of another program.
    pub method: String,
    /// Name of the scene.
    pub scene: String,
    /// How much was spoilt, in the mode's unit.
    pub strength: f64,
    /// Random seed of training and of what was spoilt.
    pub seed: u64,
    /// What is measured.
    pub figure: String,
    /// Its value; empty where the program refused, which counts as said.
    pub value: Option<f64>,
    /// What it may be: at most, for a loss, at least, for a PSNR.
    pub bar: f64,
    /// What came of it.
    pub verdict: Verdict,
    /// What the program said that it does not say of the unspoilt scene; or why it refused.
    pub warning: Option<String>,
    /// Mean PSNR of the views, dB.
    pub psnr: Option<f64>,
    /// The worst view's.
    pub psnr_min: Option<f64>,
    /// Mean PSNR of what it is compared with.
    pub reference_psnr: Option<f64>,
}

/// The table with its header line.
///
/// # Errors
/// None that a row can cause.
pub fn csv(rows: &[Row]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row))?;
    writer.into_inner().map_err(|e| e.into_error().into())
}

/// Rows of a table, such as those of another program.
///
/// # Errors
/// Where a line is not a row.
pub fn read_csv(bytes: &[u8]) -> Result<Vec<Row>, csv::Error> {
    csv::Reader::from_reader(bytes).deserialize().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_as_they_were_written() {
        let row = Row {
            mode: "pose-rotation".to_owned(),
            method: "hash-grid".to_owned(),
            scene: "a,b".to_owned(),
            strength: 0.3,
            seed: 1,
            figure: "loss, dB".to_owned(),
            value: None,
            bar: 1.0,
            verdict: Verdict::of(false, true),
            warning: Some("a \"line\"".to_owned()),
            psnr: None,
            psnr_min: Some(20.5),
            reference_psnr: Some(30.0),
        };
        let rows = [row.clone(), Row { warning: None, verdict: Verdict::Fails, ..row }];
        let text = csv(&rows).unwrap();
        assert!(
            text.starts_with(b"mode,method,scene,strength,seed,figure,value,bar,verdict,warning")
        );
        assert_eq!(read_csv(&text).unwrap(), rows);
        assert_eq!(Verdict::of(true, false), Verdict::Within);
        assert_eq!(Verdict::of(false, false), Verdict::Fails);
    }
}
