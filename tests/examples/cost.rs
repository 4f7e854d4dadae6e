//! What a picture costs: against its resolution, and against how much of the
//! scene's box is occupied.
//!
//! ```sh
//! cargo run --release -p pocketnerf-tests --example cost -- MODEL
//! ```
//!
//! Times are medians over rounds in which all pictures take turns.

use std::error::Error;
use std::time::Instant;

use pocketnerf_core::{Camera, Model, Occupancy};
use pocketnerf_train::cameras::Circle;
use pocketnerf_train::picture::{self, Settings};
use pocketnerf_train::trainer::{dilated, pack};

const VIEWS: usize = 3;
const ROUNDS: usize = 5;

/// One row of the table.
struct Case<'m> {
    name: String,
    model: Model<'m>,
    cameras: Vec<Camera>,
    seconds: Vec<f64>,
    samples: u64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let Some(path) = std::env::args().nth(1) else {
        return Err("expected an argument: MODEL".into());
    };
    let bytes = std::fs::read(&path).map_err(|e| format!("{path}: {e}"))?;
    let bytes = pocketnerf_formats::unpacked(&bytes).map_err(|e| format!("{path}: {e}"))?;
    let file = pocketnerf_formats::open_verified(&bytes).map_err(|e| format!("{path}: {e}"))?;
    let own = file.about.camera.map(|camera| camera.camera());
    let circle = Circle::around(&file.model.space, own.as_ref(), VIEWS, 0.7);
    let cameras = Circle { size: [800, 800], ..circle }.cameras();
    let mut grids: Vec<(Vec<u8>, Vec<u8>)> = Vec::new();
    if let Some(occupancy) = file.model.occupancy {
        let mut grown = (occupancy.coarse_bytes().to_vec(), occupancy.fine_bytes().to_vec());
        for _ in 0..3 {
            let view = Occupancy::new(occupancy.resolution(), 1, &grown.0, &grown.1)?;
            grown = pack(occupancy.resolution(), dilated(&view).into_iter()).unwrap();
            grids.push(grown.clone());
        }
    }
    let mut cases = Vec::new();
    for factor in [1, 2, 4, 8] {
        let cameras: Vec<Camera> = cameras.iter().map(|camera| camera.downscaled(factor)).collect();
        let side = cameras[0].width;
        cases.push(Case::new(format!("{side} x {side} pixels"), file.model, cameras));
    }
    for (cells, (coarse, fine)) in grids.iter().enumerate() {
        let resolution = file.model.occupancy.map_or(0, |o| o.resolution());
        let occupancy = Occupancy::new(resolution, 1, coarse, fine)?;
        let percent = 100.0 * occupancy.fraction();
        let name = format!("grown by {}: {percent:.1} % occupied", cells + 1);
        let model = Model { occupancy: Some(occupancy), ..file.model };
        cases.push(Case::new(name, model, cameras.clone()));
    }
    for _ in 0..ROUNDS {
        for case in &mut cases {
            case.round()?;
        }
    }
    let occupied = file.model.occupancy.map_or(1.0, |o| o.fraction());
    println!("as it is {:.1} % occupied; a row a case:", 100.0 * occupied);
    for case in &mut cases {
        println!("{}", case.row());
    }
    Ok(())
}

impl<'m> Case<'m> {
    fn new(name: String, model: Model<'m>, cameras: Vec<Camera>) -> Self {
        Self { name, model, cameras, seconds: Vec::new(), samples: 0 }
    }

    fn round(&mut self) -> Result<(), pocketnerf_core::Error> {
        let begun = Instant::now();
        self.samples = 0;
        for camera in &self.cameras {
            self.samples +=
                picture::render(&self.model, camera, &Settings::default())?.stats.samples;
        }
        self.seconds.push(begun.elapsed().as_secs_f64());
        Ok(())
    }

    fn row(&mut self) -> String {
        self.seconds.sort_by(f64::total_cmp);
        let median = self.seconds[ROUNDS / 2] / self.cameras.len() as f64;
        let pixels: u64 = self.cameras.iter().map(|c| u64::from(c.width * c.height)).sum();
        let views = self.cameras.len() as f64;
        format!(
            "{:32} {:8.2} ms a frame, {:6.1} ns a pixel, {:5.2} samples a pixel",
            self.name,
            1e3 * median,
            1e9 * median * views / pixels as f64,
            self.samples as f64 / pixels as f64,
        )
    }
}
