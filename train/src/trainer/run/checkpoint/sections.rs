//! The sections of a checkpoint, from bytes to checked values.

use std::path::Path;

use pocketnerf_core::{DType, SimdLevel};
use pocketnerf_formats::{ModelFile, Role, Section, SectionId, open_verified};

use super::record::RecordV1;
use super::{Checkpoint, Learnt, Problem, kind};
use crate::field::rounding::EightBits;
use crate::field::{FieldConfig, Layout, Role as PartRole, Unusable};
use crate::trainer::occupancy::clearing::Clearing;
use crate::trainer::prepass::MOST_TEACHERS;
use crate::trainer::run::watch::Watch;

/// Version of every section so far.
pub(super) const V1: u16 = 1;

/// Everything but the dataset is checked here, lengths before memory is allocated.
pub(super) fn read(file: &Path, bytes: &[u8]) -> Result<Checkpoint, Problem> {
    let bytes = pocketnerf_formats::unpacked(bytes)?;
    let model_file = open_verified(&bytes)?;
    let record = RecordV1::from_bytes(section(&model_file, kind::TRAINER)?.bytes)
        .ok_or(Problem::State("section TRAINER"))?;
    let model = &model_file.model;
    let occupancy = model.occupancy.ok_or(Problem::Untrainable("no occupancy"))?;
    if occupancy.resolution() < 16 || !occupancy.resolution().is_power_of_two() {
        return Err(Problem::Untrainable("occupancy of another resolution"));
    }
    let field = field_config(&model_file)?;
    let layout = field.kind().layout();
    let parameters = parameters(&model_file, &layout)?;
    let averaged = record.averaged > 0;
    let kinds = [kind::POSES, kind::POSE_MEAN, kind::POSE_SQUARE, kind::POSE_SUM];
    let poses = of_photographs(&model_file, kinds, averaged)?;
    let kinds = [kind::GAINS, kind::GAIN_MEAN, kind::GAIN_SQUARE, kind::GAIN_SUM];
    let learnt_gains = of_photographs(&model_file, kinds, averaged)?;
    let resolution = occupancy.resolution();
    let clearing = clearing(&model_file)?;
    let others = (poses.is_some(), smooth(&model_file)?, clearing.is_some());
    let config = record.config(field, model.space, resolution, others);
    record.check(&config).map_err(Problem::State)?;
    let moments = |kind, n: usize| {
        let section = section(&model_file, kind)?;
        let (expected, found) = (4 * n as u64, section.bytes.len() as u64);
        if expected != found {
            return Err(Problem::Length { section: section.id, expected, found });
        }
        Ok(floats(section.bytes))
    };
    // Only the networks have a first moment.
    let mean = moments(kind::MEAN, parameters.len() - layout.networks_start())?;
    let square = moments(kind::SQUARE, parameters.len())?;
    let sum = match record.averaged {
        0 => Vec::new(),
        _ => moments(kind::SUM, parameters.len())?,
    };
    let scales = scales(&model_file, layout.tables().len())?;
    // How many there must be, the dataset will tell.
    let density = floats(section(&model_file, kind::DENSITY)?.bytes);
    if !density.iter().all(|d| *d >= 0.0) {
        return Err(Problem::State("section DENSITY"));
    }
    // These too.
    let sampler = match model_file.container().find(SectionId::first(kind::PIXEL_ERRORS)) {
        Some(_) => Some(floats(section(&model_file, kind::PIXEL_ERRORS)?.bytes)),
        None => None,
    };
    let watch = watch(&model_file)?;
    let best = match model_file.container().find(SectionId::first(kind::BEST)) {
        Some(_) => Some(moments(kind::BEST, parameters.len())?),
        None => None,
    };
    let simd = simd(&model_file)?;
    let gains = gains(&model_file)?;
    let provenance = model_file.about.provenance;
    Ok(Checkpoint {
        file: file.to_owned(),
        config,
        space: model.space,
        sampling: model.sampling,
        scene: model_file.about.scene.similarity().into(),
        world: model_file.about.world,
        teachers: teachers(&model_file)?,
        dataset: provenance.map_or_else(String::new, |p| p.dataset.to_owned()),
        record,
        mean,
        square,
        sum,
        density,
        clearing: clearing.unwrap_or(Clearing::NONE),
        scales,
        sampler,
        watch,
        best,
        simd,
        gains,
        of_photographs: poses.into_iter().chain(learnt_gains).collect(),
        coarse: occupancy.coarse_bytes().to_vec(),
        fine: occupancy.fine_bytes().to_vec(),
        parameters,
    })
}

/// How much surfaces are held to be smooth.
fn smooth(file: &ModelFile<'_>) -> Result<f32, Problem> {
    if file.container().find(SectionId::first(kind::SMOOTH_SURFACES)).is_none() {
        return Ok(0.0);
    }
    let weight = floats(section(file, kind::SMOOTH_SURFACES)?.bytes);
    match weight[..] {
        [weight] if weight.is_finite() && weight > 0.0 => Ok(weight),
        _ => Err(Problem::State("section SMOOTH_SURFACES")),
    }
}

/// How far cells have been cleared, where they are.
fn clearing(file: &ModelFile<'_>) -> Result<Option<Clearing>, Problem> {
    if file.container().find(SectionId::first(kind::CLEARING)).is_none() {
        return Ok(None);
    }
    let clearing = Clearing::from_bytes(section(file, kind::CLEARING)?.bytes);
    clearing.map(Some).ok_or(Problem::State("section CLEARING"))
}

/// The model files of teachers, in their order.
fn teachers(file: &ModelFile<'_>) -> Result<Vec<Vec<u8>>, Problem> {
    let of = |index| file.container().find(SectionId { kind: kind::TEACHER, index });
    let sections = (0..=MOST_TEACHERS).map_while(of).map(|section| match section.version {
        V1 if section.id.index < MOST_TEACHERS && open_verified(section.bytes).is_ok() => {
            Ok(section.bytes.to_vec())
        }
        V1 => Err(Problem::State("section TEACHER")),
        found => Err(Problem::Version { section: section.id, found }),
    });
    sections.collect()
}

/// A section of our own, in a version that we know.
fn section<'a>(file: &ModelFile<'a>, kind: u32) -> Result<Section<'a>, Problem> {
    let id = SectionId::first(kind);
    let section = file.container().find(id).ok_or(Problem::NotACheckpoint)?;
    if (section.version, section.encoding) != (V1, 0) {
        return Err(Problem::Version { section: id, found: section.version });
    }
    Ok(section)
}

/// How tables are rounded, where the file says it.
fn scales(file: &ModelFile<'_>, n_tables: usize) -> Result<Vec<u8>, Problem> {
    if file.container().find(SectionId::first(kind::SCALES)).is_none() {
        return Ok(Vec::new());
    }
    let section = section(file, kind::SCALES)?;
    let (expected, found) = (n_tables as u64, section.bytes.len() as u64);
    if ![expected, 2 * expected].contains(&found) {
        return Err(Problem::Length { section: section.id, expected, found });
    }
    if EightBits::all_of(section.bytes, n_tables).is_none() {
        return Err(Problem::State("section SCALES"));
    }
    Ok(section.bytes.to_vec())
}

/// What was seen of the held-out views.
fn watch(file: &ModelFile<'_>) -> Result<Watch, Problem> {
    if file.container().find(SectionId::first(kind::WATCH)).is_none() {
        return Ok(Watch::default());
    }
    let section = section(file, kind::WATCH)?;
    let watch = postcard::take_from_bytes::<Watch>(section.bytes).ok();
    let whole = watch.filter(|(watch, rest)| rest.is_empty() && watch.is_sound());
    whole.map(|(watch, _)| watch).ok_or(Problem::State("section WATCH"))
}

/// Which vector instructions the steps had, where the file says it.
fn simd(file: &ModelFile<'_>) -> Result<Option<SimdLevel>, Problem> {
    if file.container().find(SectionId::first(kind::SIMD)).is_none() {
        return Ok(None);
    }
    let name = std::str::from_utf8(section(file, kind::SIMD)?.bytes).ok();
    let level = name.and_then(|name| name.parse().ok());
    level.map(Some).ok_or(Problem::State("section SIMD"))
}

/// What is learnt of the photographs: the parameters, both moments and, where parameters are
/// `averaged`, the sum. How many there must be, the dataset will tell.
fn of_photographs(
    file: &ModelFile<'_>,
    kinds: [u32; 4],
    averaged: bool,
) -> Result<Option<Learnt>, Problem> {
    if file.container().find(SectionId::first(kinds[0])).is_none() {
        return Ok(None);
    }
    let mut all = [const { Vec::new() }; 4];
    for (values, kind) in all.iter_mut().zip(kinds).take(if averaged { 4 } else { 3 }) {
        *values = floats(section(file, kind)?.bytes);
    }
    let finite = all.iter().flatten().all(|value| value.is_finite());
    let [parameters, mean, square, sum] = all;
    let n = parameters.len();
    let alike = [mean.len(), square.len()] == [n; 2] && sum.len() == if averaged { n } else { 0 };
    if n == 0 || !finite || !alike || square.iter().any(|square| *square < 0.0) {
        return Err(Problem::State(match kinds[0] {
            kind::POSES => "section POSES",
            _ => "section GAINS",
        }));
    }
    Ok(Some(Learnt { kind: kinds[0], parameters, mean, square, sum }))
}

/// How photographs are evened out; as many as there are, the dataset will tell.
fn gains(file: &ModelFile<'_>) -> Result<Vec<[f32; 3]>, Problem> {
    if file.container().find(SectionId::first(kind::EXPOSURE)).is_none() {
        return Ok(Vec::new());
    }
    let section = section(file, kind::EXPOSURE)?;
    let values = floats(section.bytes);
    let (gains, rest) = values.as_chunks::<3>();
    let is_sound = |gain: &f32| gain.is_finite() && *gain > 0.0;
    if gains.is_empty() || !rest.is_empty() || !values.iter().all(is_sound) {
        return Err(Problem::State("section EXPOSURE"));
    }
    Ok(gains.to_vec())
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

/// The weights, in the order of the flat buffer, which is that of the file. A tensor may be
/// several ranges there.
fn parameters(file: &ModelFile<'_>, layout: &Layout) -> Result<Vec<f32>, Problem> {
    let missing = Problem::Untrainable("a bias is missing");
    let mut ranges = layout.ranges().iter().peekable();
    let mut values = Vec::with_capacity(layout.len());
    for (name, view) in file.tensors() {
        let is_constant = ranges.peek().is_some_and(|range| range.part.role == PartRole::Fixed);
        // What is not among the parameters is part of the field's shape.
        if name.role() == Role::Index || (name.role() == Role::Exact && !is_constant) {
            continue;
        }
        let mut left = view.rows() * view.cols();
        while left > 0 {
            let range = ranges.next().filter(|range| range.len() <= left);
            let Some(range) = range else { return Err(missing) };
            left -= range.len();
        }
        if view.dtype() != DType::F32 {
            return Err(Problem::Untrainable("weights in f16"));
        }
        values.extend(floats(view.bytes()));
    }
    if ranges.next().is_some() { Err(missing) } else { Ok(values) }
}

/// The shape of the field, for training.
fn field_config(file: &ModelFile<'_>) -> Result<FieldConfig, Problem> {
    let id = SectionId::first(kind::KIND);
    let own = file.container().find(id).map(|_| section(file, kind::KIND)).transpose()?;
    FieldConfig::of(&file.model.field, own.map(|section| section.bytes)).map_err(|why| match why {
        Unusable::Model(what) => Problem::Untrainable(what),
        Unusable::NoSection => Problem::NotACheckpoint,
        Unusable::Section => Problem::State("section KIND"),
    })
}
