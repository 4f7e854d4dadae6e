//! A few densities by the GPU, beside the CPU's: drivers have faults.

use pocketnerf_core::AnyField;
use pocketnerf_gpu::Error;
use pocketnerf_gpu::training::Learner;

use super::Cpu;
use crate::probe::Probe;
use crate::random::Random;

/// Points that are looked at.
const POINTS: usize = 64;
/// Densities differ by this part of the largest at most.
const MOST: f32 = 1e-3;

/// Compares the densities of the field as it is learnt from.
pub(super) fn compare(learner: &Learner, cpu: &Cpu) -> Result<(), Error> {
    let field = cpu.field.training_view(&cpu.state.field().parameters)?;
    let mut random = Random::new(0, [5, 0, 0]);
    let points: Vec<[f32; 3]> = (0..POINTS).map(|_| [0; 3].map(|_| random.next_f32())).collect();
    let found = learner.densities(&points)?;
    match differ(&found, &on_cpu(cpu, &field, &points)) {
        // NaN is too much.
        off if off <= MOST => Ok(()),
        off => Err(Error::MiscomputesDensities(off, MOST)),
    }
}

fn on_cpu(cpu: &Cpu, field: &AnyField<'_>, points: &[[f32; 3]]) -> Vec<f32> {
    let mut probe = Probe::new(cpu.limits);
    for (a, row) in probe.points().iter_mut().enumerate() {
        row.iter_mut().zip(points).for_each(|(to, point)| *to = point[a]);
    }
    probe.densities(cpu.level, field, points.len()).to_vec()
}

/// The largest difference, a part of the largest value.
fn differ(found: &[f32], expected: &[f32]) -> f32 {
    let size = expected.iter().fold(f32::MIN_POSITIVE, |most, value| value.abs().max(most));
    let off = |(a, b): (&f32, &f32)| (a - b).abs() / size;
    let larger = |most: f32, off| if most.is_nan() || off <= most { most } else { off };
    found.iter().zip(expected).map(off).fold(0.0, larger)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_by_hand() {
        assert_eq!(differ(&[1.0, 2.0], &[1.0, 2.0]), 0.0);
        assert_eq!(differ(&[1.0, 2.5], &[1.0, 2.0]), 0.25);
        assert_eq!(differ(&[0.0; 2], &[0.0; 2]), 0.0);
        assert!(differ(&[f32::NAN, 2.0], &[1.0, 2.0]).is_nan());
    }
}
