//! Exposure that changes from photograph to photograph, and photographs that show nothing.

use super::photo::Photo;
use super::{Suspect, Suspicion};
use crate::metrics::median;

/// So many photographs nearest to one tell how bright it should be.
const AROUND: usize = 4;
/// Of fewer photographs, those beside one are not near enough to tell.
const FEWEST: usize = 20;
/// Stops by which a photograph is off ...
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
    let off = differences(suspect, &lights);
    let usual = median(off.iter().map(|(_, off)| off.abs())).unwrap_or(0.0);
    let is_off = |off: f64| off.abs() > OFF && off.abs() > TIMES * usual;
    let which: Vec<usize> = off.iter().filter(|(_, o)| is_off(*o)).map(|(i, _)| *i).collect();
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

/// By how much each differs from the median of those nearest to it, stops.
fn differences(suspect: &Suspect<'_, '_>, lights: &[(usize, f64)]) -> Vec<(usize, f64)> {
    let sights = suspect.sights();
    let middle = sights.iter().map(|s| s.position).sum::<glam::DVec3>() / sights.len() as f64;
    let spread = super::at(sights.iter().map(|s| s.position.distance(middle)), 0.5).max(1e-12);
    let difference = |&(i, light): &(usize, f64)| {
        let apart = |j: usize| {
            let [a, b] = [sights[i], sights[j]];
            a.position.distance(b.position) / spread + a.forward.distance(b.forward)
        };
        let mut others: Vec<(f64, f64)> =
            lights.iter().filter(|(j, _)| *j != i).map(|(j, light)| (apart(*j), *light)).collect();
        others.sort_by(|a, b| a.0.total_cmp(&b.0));
        let around = median(others.iter().take(AROUND).map(|(_, light)| *light));
        around.map(|around| (i, light - around))
    };
    lights.iter().filter_map(difference).collect()
}
