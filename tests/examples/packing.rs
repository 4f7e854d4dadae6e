//! What packing makes of model files: bytes, and how long unpacking takes on one thread.
//!
//! `cargo run --release -p pocketnerf-tests --example packing -- MODEL...`

use std::error::Error;
use std::time::Instant;

use pocketnerf_formats::{Container, kind, pack, unpack_into, unpacked};

/// Times that a file is unpacked.
const ROUNDS: u32 = 20;

fn main() -> Result<(), Box<dyn Error>> {
    println!("bytes, packed, share; tables, cells, rest; ms, MB of output a second");
    for path in std::env::args().skip(1) {
        let bytes = std::fs::read(&path)?;
        let plain = unpacked(&bytes)?;
        let packed = pack(&plain)?;
        let mut out = vec![0; plain.len()];
        let begun = Instant::now();
        for _ in 0..ROUNDS {
            unpack_into(&packed, &mut out)?;
        }
        let seconds = begun.elapsed().as_secs_f64() / f64::from(ROUNDS);
        let (mut tables, mut cells) = (0, 0);
        for section in Container::open(&packed)?.sections() {
            match section.id.kind {
                kind::GRID => tables += section.bytes.len(),
                kind::OCC_COARSE | kind::OCC_FINE => cells += section.bytes.len(),
                _ => (),
            }
        }
        println!(
            "{path}: {}, {}, {:.3}; {tables}, {cells}, {}; {:.1} ms, {:.0} MB/s",
            plain.len(),
            packed.len(),
            packed.len() as f64 / plain.len() as f64,
            packed.len() - tables - cells,
            1e3 * seconds,
            plain.len() as f64 / seconds / 1e6
        );
    }
    Ok(())
}
