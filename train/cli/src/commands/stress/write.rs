//! Writes the table.

use std::path::PathBuf;

use pocketnerf_train::output::write_atomic;
use pocketnerf_train::picture::image_file;
use serde_json::json;

use super::Stress;
use crate::chart::{Program, page::picture};
use crate::commands::Failure;
use crate::stress::{Mode, Row, csv, drawing, page};

impl Stress {
    /// Writes the page, the drawing, which shows the worst of all scenes and methods, and the rows.
    pub(super) fn write(
        &self,
        modes: &[Mode],
        rows: &[Row],
        files: &[(String, Option<PathBuf>)],
    ) -> Result<(), Failure> {
        let mut pictures = page::Pictures::new();
        for (key, path) in files {
            let Some(path) = path else { continue };
            let shown = image_file::open(path).map_err(|e| format!("{}: {e}", path.display()))?;
            let shown = shown.into_rgb8();
            pictures.insert(key.clone(), picture(shown.width(), shown.height(), shown.as_raw())?);
        }
        let program = Program::this();
        let about = format!(
            "Each row: a scene, spoilt in one way, trained for {} steps and compared with the \
             same scene unspoilt, on test views that nothing was learnt from, downscaled as the \
             command says. The verdict says whether the figure is within its bar; if not, whether \
             the program says so. pocketnerf {}, commit {}.",
            self.steps(),
            program.version,
            program.commit.as_deref().unwrap_or("unknown"),
        );
        let all: Vec<&Row> = rows.iter().collect();
        let html = page::html(modes, rows, &pictures, &about);
        let json = serde_json::to_vec_pretty(&json!({ "program": program, "rows": rows }))?;
        let (svg, table) = (drawing::svg(modes, &all), csv(rows)?);
        let files: [(&str, &[u8]); 4] = [
            ("index.html", html.as_bytes()),
            ("stress.svg", svg.as_bytes()),
            ("stress.csv", &table),
            ("stress.json", &json),
        ];
        for (name, bytes) in files {
            write_atomic(&self.out().join(name), bytes)?;
        }
        Ok(())
    }
}
