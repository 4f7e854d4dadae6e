//! Exposure that changes from photograph to photograph, and photographs that show nothing.

use super::photo::Photo;
use super::{Suspect, Suspicion};
use crate::metrics::median;

/// So many photographs nearest to one tell how bright it should be.
const AROUND: usize = 4;
/// Of fewer photographs, those beside one are not near enough to tell.
const FEWEST: usize = 20;
/// A photograph is off that differs from each of those by so many stops (light from one side makes it
/// differ from some) ...
const OFF: f64 = 0.8;
/// ... at least, and so many times the usual difference of neighbours.
const TIMES: f64 = 4.0;
/// A usual difference of neighbours from which on all are uneven, stops.
const UNEVEN: f64 = 0.2;
/// Deviation of the luma below which a photograph shows nothing, of 255.
const FLAT: f64 = 0.5;

/// Photographs of nothing.
pub(super) fn flat(suspect: &Suspect<'_, '_>, photos: &[Option<Photo>]) -> Option<Suspicion> {
    let numbered = photos.iter().enumerate().filter_map(|(i, p)| Some((i, p.as_ref()?)));
    let flat: Vec<usize> = numbered.filter(|(_, photo)| is_flat(photo)).map(|(i, _)| i).collect();
    (!flat.is_empty()).then(|| {
        Suspicion::new(
            "flat",
            format!(
                "{}; take the frames out",
                suspect.some("photographs of one colour and nothing else", &flat)
            ),
        )
    })
}

fn is_flat(photo: &Photo) -> bool {
    photo.deviation.is_some_and(|deviation| deviation < FLAT)
}

/// Photographs that are brighter or darker than those that were taken beside them. Where cameras are
/// wrong, nobody knows which these are.
pub(super) fn exposure(suspect: &Suspect<'_, '_>, photos: &[Option<Photo>]) -> Option<Suspicion> {
    let numbered = photos.iter().enumerate().filter_map(|(i, p)| Some((i, p.as_ref()?)));
    let lights: Vec<(usize, f64)> = numbered
        .filter(|(_, photo)| !is_flat(photo))
        .filter_map(|(i, photo)| Some((i, photo.light?.log2())))
        .collect();
    if lights.len() < FEWEST {
        return None;
    }
    let differences = differences(suspect, &lights);
    let usual = median(differences.iter().map(|d| d.usual.abs())).unwrap_or(0.0);
    let is_off = |d: &&Difference| d.least > OFF && d.usual.abs() > TIMES * usual;
    let which: Vec<usize> = differences.iter().filter(is_off).map(|d| d.photo).collect();
    if usual > UNEVEN {
        return Some(Suspicion::new(
            "exposure",
            format!(
                "photographs differ from their neighbours by {usual:.2} stops in brightness, \
                 expected less than {UNEVEN}: `train` evens them out, but what is too bright in \
                 all of them is lost; take them with one exposure"
            ),
        ));
    }
    if !which.is_empty() {
        return Some(Suspicion::new(
            "exposure",
            format!(
                "{}; take them with one exposure, or take the frames out",
                suspect.some("photographs much brighter or darker than their neighbours", &which)
            ),
        ));
    }
    None
}

/// By how much a photograph is brighter or darker than those nearest to it, stops.
struct Difference {
    photo: usize,
    /// The median.
    usual: f64,
    /// From the one that is most like it; 0 where some are brighter and some darker.
    least: f64,
}

fn differences(suspect: &Suspect<'_, '_>, lights: &[(usize, f64)]) -> Vec<Difference> {
    let sights = suspect.sights();
    let middle = sights.iter().map(|s| s.position).sum::<glam::DVec3>() / sights.len() as f64;
    let spread = super::at(sights.iter().map(|s| s.position.distance(middle)), 0.5).max(1e-12);
    let difference = |&(photo, light): &(usize, f64)| {
        let apart = |j: usize| {
            let [a, b] = [sights[photo], sights[j]];
            a.position.distance(b.position) / spread + a.forward.distance(b.forward)
        };
        let others = lights.iter().filter(|(j, _)| *j != photo);
        let mut others: Vec<(f64, f64)> =
            others.map(|(j, other)| (apart(*j), light - other)).collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0));
        let around = || others.iter().take(AROUND).map(|(_, difference)| *difference);
        let usual = median(around())?;
        let least = around().map(|d| d * usual.signum()).fold(f64::INFINITY, f64::min);
        Some(Difference { photo, usual, least: least.max(0.0) })
    };
    lights.iter().filter_map(difference).collect()
}
