//! The report as text.

use std::fmt;

use super::{Rendering, Report, StageCost, Training};

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "machine: {}, {} threads, {:.2} GHz ({:.2} at the end)",
            self.simd, self.threads, self.clock_ghz, self.clock_ghz_at_end
        )?;
        writeln!(f, "{:<28}{:>12}{:>14}", "", "one thread", "all threads")?;
        let row = |f: &mut fmt::Formatter<'_>, name: &str, one: f64, all: f64, unit: &str| {
            writeln!(f, "{name:<28}{one:>12.1}{all:>14.1} {unit}")
        };
        row(f, "multiply and add", self.peak_gflops_one_thread, self.peak_gflops, "GFLOP/s")?;
        for s in &self.streams {
            let name = format!("sequential reads, {}", size(s.bytes));
            row(f, &name, s.gb_per_s_one_thread, s.gb_per_s_all, "GB/s")?;
        }
        for g in &self.gathers {
            let name = format!("random reads, {}", size(g.bytes));
            let [one, all] = [g.per_second_one_thread, g.per_second_all].map(|r| r * 1e-6);
            row(f, &name, one, all, "million/s")?;
        }
        let fraction = 100.0 * self.fma_fraction;
        writeln!(f, "one core reaches {fraction:.0} % of two multiply-adds per cycle\n")?;
        table(f, &self.networks)?;
        writeln!(f, "\ntraining on {}: {}", self.dataset, self.training)?;
        write!(f, "rendering {}: {}", self.model, self.rendering)
    }
}

impl fmt::Display for Training {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} steps, {:.2} million samples per second, {:.1} samples per ray, {:.0} % in the backward pass",
            self.steps,
            self.samples_per_second * 1e-6,
            self.samples_per_ray,
            100.0 * self.kept,
        )?;
        table(f, &self.stages)?;
        writeln!(f, "bounds account for {:.0} % of the time", 100.0 * self.fraction_of_bounds)
    }
}

impl fmt::Display for Rendering {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} views of {}x{}, {:.1} frames per second ({:.1} on one thread)",
            self.views,
            self.width,
            self.height,
            self.frames_per_second,
            1.0 / self.seconds_per_frame_one_thread,
        )?;
        writeln!(
            f,
            "{:.2} samples per pixel; if every pixel is rendered {:.2} ({:.2} with padding), \
             {:.1} per ray that hits something ({:.0} % of them):",
            self.samples_per_ray,
            self.samples_per_ray_every_pixel,
            self.rows_per_pixel,
            self.samples_per_hit_ray,
            100.0 * self.hit_share,
        )?;
        table(f, &self.stages)?;
        writeln!(f, "bounds account for {:.0} % of the time", 100.0 * self.fraction_of_bounds)?;
        write!(f, "an empty pixel: {:.1} ns outside the box", self.ns_per_pixel_outside)?;
        if let Some(ns) = self.ns_per_pixel_empty {
            write!(f, ", {ns:.1} ns if a ray is cast through empty cells")?;
        }
        match self.ns_per_pixel_missed {
            Some(ns) => writeln!(f, ", {ns:.1} ns on average")?,
            None => writeln!(f)?,
        }
        let s = &self.scaling;
        writeln!(
            f,
            "{} threads, speedup over one: frames {:.2}x, multiply-adds {:.2}x, memory {:.2}x",
            s.threads, s.frame, s.fma, s.bandwidth,
        )?;
        for v in &self.variants {
            let [simd, tuning] = [v.simd, v.tuning];
            let speed = (v.frames_per_second, v.relative);
            writeln!(
                f,
                "  {simd:<9}{tuning:<6}{:>8.2} frames per second {:>6.2}x",
                speed.0, speed.1
            )?;
        }
        Ok(())
    }
}

fn table(f: &mut fmt::Formatter<'_>, stages: &[StageCost]) -> fmt::Result {
    writeln!(
        f,
        "{:<20}{:>11}{:>12}  {:<12}{:>9}{:>8}{:>10}  {:<10}{:>8}{:>7}",
        "stage",
        "ns/sample",
        "ns",
        "per",
        "GFLOP/s",
        "GB/s",
        "reads/us",
        "bound",
        "of peak",
        "share"
    )?;
    for s in stages {
        let or_dash = |v: Option<f64>, digits: usize| {
            v.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
        };
        writeln!(
            f,
            "{:<20}{:>11.2}{:>12}  {:<12}{:>9}{:>8}{:>10}  {:<10}{:>8}{:>6.1}%",
            s.name,
            s.ns_per_sample,
            or_dash(s.ns_per_unit, 1),
            s.unit,
            or_dash(s.gflops, 1),
            or_dash(s.gb_per_s, 1),
            or_dash(s.gathers_per_second.map(|r| r * 1e-6), 0),
            s.bound,
            or_dash(s.fraction_of_peak, 2),
            100.0 * s.share,
        )?;
    }
    Ok(())
}

/// `256 KiB`, `4 MiB`.
fn size(bytes: usize) -> String {
    if bytes < 1 << 20 { format!("{} KiB", bytes >> 10) } else { format!("{} MiB", bytes >> 20) }
}
