//! How many questions a second a model answers.
//!
//! ```sh
//! cargo run --release -p pocketnerf-tests --example queries -- [MODEL [THREADS]]
//! ```
//!
//! Without arguments of the model that the embedding example carries, on all cores. Rates are
//! medians over rounds in which all questions take turns.

use std::error::Error;
use std::time::Instant;

use pocketnerf_core::query::Depth;
use pocketnerf_core::{Probe, Ray, SimdLevel, Tuning};
use pocketnerf_train::random::Random;
use rayon::prelude::*;

const STILL_LIFE: &[u8] = include_bytes!("../../embed-demo/still-life.pnerf");
const ROUNDS: usize = 9;
/// Things that are asked about in a call, and calls in a round.
const AT_A_TIME: usize = 4096;
const CALLS: usize = 64;

/// A question about the things of a call.
type Question<'q> =
    Box<dyn Fn(&[[f32; 3]], &mut [f32]) -> Result<(), pocketnerf_core::Error> + Send + Sync + 'q>;

/// One row of the table.
struct Case<'q> {
    name: &'static str,
    points: &'q [Vec<[f32; 3]>],
    /// Things that are asked about per point.
    things: f64,
    ask: Question<'q>,
    rates: Vec<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let bytes = match arguments.next() {
        Some(path) => std::fs::read(&path).map_err(|e| format!("{path}: {e}"))?,
        None => STILL_LIFE.to_vec(),
    };
    let threads = arguments.next().map_or(Ok(0), |n| n.parse())?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let bytes = pocketnerf_formats::unpacked(&bytes)?;
    let file = pocketnerf_formats::open_verified(&bytes)?;
    let mut table = vec![0; file.model.table_len()];
    let model = file.model.with_table(&mut table)?;
    let probe = Probe::new(&model, SimdLevel::detect(), Tuning::FAST)?;
    let anywhere = points(model.space.bounds(), |_| true);
    let occupied = points(model.space.bounds(), |p| probe.occupied(p));
    let radius = 0.02 / model.space.unit_map().scale;
    let case = |name, points, things, ask| Case { name, points, things, ask, rates: Vec::new() };
    let mut cases = [
        case("density, in occupied cells", &occupied, 1.0, density(&probe)),
        case("density, anywhere", &anywhere, 1.0, density(&probe)),
        case(
            "radiance, in occupied cells",
            &occupied,
            1.0,
            Box::new(|points, scratch| {
                let mut out = vec![[0.0; 4]; points.len()];
                probe.radiance(points, &vec![[0.0, 0.6, 0.8]; points.len()], scratch, &mut out)
            }),
        ),
        case(
            "gradient, in occupied cells",
            &occupied,
            1.0,
            Box::new(|points, scratch| {
                probe.density_gradient(points, scratch, &mut vec![[0.0; 3]; points.len()])
            }),
        ),
        case(
            "sphere_clear, 2 % of the box",
            &anywhere,
            1.0,
            Box::new(|points, _| {
                let clear = points.iter().filter(|p| probe.sphere_clear(**p, radius)).count();
                std::hint::black_box(clear);
                Ok(())
            }),
        ),
        case(
            "segment through the box",
            &anywhere,
            0.5,
            Box::new(|points, scratch| {
                let mut out = vec![0.0; points.len() / 2];
                probe.segment_transmittance(points.as_chunks().0, scratch, &mut out)
            }),
        ),
        case(
            "median depth of a ray",
            &anywhere,
            1.0,
            Box::new(|points, scratch| {
                let ray = |p: &[f32; 3]| Ray { origin: *p, direction: [0.0, 0.6, -0.8] };
                let rays: Vec<Ray> = points.iter().map(ray).collect();
                probe.depths(&rays, Depth::Median, None, scratch, &mut vec![0.0; rays.len()])
            }),
        ),
    ];
    for _ in 0..ROUNDS {
        for case in &mut cases {
            pool.install(|| case.round(&probe))?;
        }
    }
    println!("{} threads, {}", pool.current_num_threads(), SimdLevel::detect());
    for case in &mut cases {
        case.rates.sort_by(f64::total_cmp);
        println!("{:28} {:8.2} M/s", case.name, case.rates[ROUNDS / 2] / 1e6);
    }
    Ok(())
}

fn density<'q>(probe: &'q Probe<'_>) -> Question<'q> {
    Box::new(|points, scratch| probe.density(points, scratch, &mut vec![0.0; points.len()]))
}

/// Points of the model's box of which `is` is true, for all calls.
fn points([min, max]: [[f32; 3]; 2], is: impl Fn([f32; 3]) -> bool) -> Vec<Vec<[f32; 3]>> {
    let mut random = Random::new(1, [0; 3]);
    let mut point = || loop {
        let p = [0, 1, 2].map(|a| min[a] + random.next_f32() * (max[a] - min[a]));
        if is(p) {
            return p;
        }
    };
    (0..CALLS).map(|_| (0..AT_A_TIME).map(|_| point()).collect()).collect()
}

impl Case<'_> {
    fn round(&mut self, probe: &Probe<'_>) -> Result<(), pocketnerf_core::Error> {
        let started = Instant::now();
        self.points.par_iter().try_for_each_init(
            || vec![0.0; probe.scratch_len()],
            |scratch, points| (self.ask)(points, scratch),
        )?;
        let things = self.things * (CALLS * AT_A_TIME) as f64;
        self.rates.push(things / started.elapsed().as_secs_f64());
        Ok(())
    }
}
