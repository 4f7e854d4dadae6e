//! Where a chart's figures come from.

use serde::{Deserialize, Serialize};

use crate::machine::Machine;

/// The program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Program {
    /// Its version.
    pub version: String,
    /// The commit that it was built from, `-dirty` if files had changed; `None` outside a
    /// repository.
    pub commit: Option<String>,
}

impl Program {
    /// This program.
    #[must_use]
    pub fn this() -> Self {
        let commit = env!("POCKETNERF_COMMIT");
        let commit = (!commit.is_empty()).then(|| commit.to_owned());
        Self { version: env!("CARGO_PKG_VERSION").to_owned(), commit }
    }
}

/// The machine, and its best rates at the time of the measurement.
#[derive(Clone, Debug, Serialize)]
pub struct MachineFacts {
    /// The name of the processor.
    pub cpu: Option<String>,
    /// Operating system and architecture.
    pub system: String,
    /// Threads that rendered.
    pub threads: usize,
    /// Vector instructions.
    pub simd: &'static str,
    /// Clock of one core, GHz.
    pub clock_ghz: f64,
    /// Multiplications and additions of `f32` in registers, 10^9 per second, all threads.
    pub peak_gflops: f64,
    /// Reading memory beyond all caches, 10^9 bytes per second, all threads.
    pub peak_gb_per_s: Option<f64>,
}

impl MachineFacts {
    /// Of a machine that has been measured.
    #[must_use]
    pub fn of(machine: &Machine) -> Self {
        Self {
            cpu: cpu(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            threads: machine.threads,
            simd: machine.simd.name(),
            clock_ghz: machine.clock / 1e9,
            peak_gflops: machine.flops.all / 1e9,
            peak_gb_per_s: machine.streams.0.last().map(|stream| stream.rate.all / 1e9),
        }
    }
}

/// The processor's name, if the system reports it.
fn cpu() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// How it was measured.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Protocol {
    /// Interleaved rounds.
    pub rounds: usize,
    /// Median slowdown of the machine; the time of each turn is divided by its own.
    pub slowdown: f64,
    /// Spread of the quartiles, as a share of the median, above which a time is flagged.
    pub unsteady_above: f64,
    /// The network of LPIPS, if weights were given.
    pub lpips: Option<String>,
    /// The command.
    pub command: String,
    /// Everything that decided what was measured: the same again needs no measurement.
    pub asked: String,
    /// Seconds since 1970 when the rounds began.
    pub measured_at: u64,
}
