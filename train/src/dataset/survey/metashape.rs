//! Metashape: File > Export > Export Cameras, as Agisoft XML.
//!
//! A camera's `transform` is a 4x4 matrix from its axes (right, down, forward) to its component's
//! world, row after row. A component's (or in older files the chunk's) `transform`, a rotation, a
//! translation and a scale, leads on to a world that components share: of the globe where there
//! are references, with the origin in its middle.

use std::collections::HashMap;
use std::path::Path;

use glam::{DMat3, DMat4, DVec3, DVec4};
use roxmltree::Node;

use super::calibration::Sensor;
use super::photos::Photos;
use super::xml::{child, number, numbers, parse};
use super::{Cameras, missing, text};
use crate::dataset::DatasetError;
use crate::dataset::listing::{Frame, relative_path};

const HINT: &str = "align the photographs in Metashape and export its cameras as Agisoft XML";
/// Metres: what is farther from the origin is on the globe, whose radius is 6,357,000 or more.
const GLOBE: f64 = 6_300_000.0;

/// Whether a text that begins so is a file of cameras.
pub(super) fn is_own(begin: &str) -> bool {
    begin.contains("<document") && begin.contains("<chunk")
}

/// A similarity: p becomes scale · rotation · p + translation.
#[derive(Clone, Copy)]
struct Similarity {
    rotation: DMat3,
    translation: DVec3,
    scale: f64,
}

/// An aligned camera.
struct Camera {
    label: String,
    sensor: Sensor,
    component: Option<String>,
    pose: DMat4,
}

/// What a chunk says.
struct Chunk {
    cameras: Vec<Camera>,
    /// Of cameras that are not aligned, or whose sensor is not calibrated.
    unaligned: usize,
    disabled: usize,
    components: HashMap<String, Similarity>,
    own: Option<Similarity>,
}

pub(super) fn read(folder: &Path, file: &Path) -> Result<Cameras, DatasetError> {
    let refuse = |problem| DatasetError::Export { file: file.to_owned(), problem, hint: HINT };
    let text = text(file, HINT)?;
    let mut chunk = Chunk::parse(&text).map_err(refuse)?;
    let mut notes = Vec::new();
    chunk.keep_one_world(&mut notes);
    let (photos, total) = (Photos::new(folder), chunk.cameras.len());
    let (mut frames, mut poses, mut absent) = (Vec::new(), Vec::new(), Vec::new());
    for camera in &chunk.cameras {
        let Some(path) = photos.find(&camera.label).map_err(refuse)? else {
            absent.push(camera.label.clone());
            continue;
        };
        let Sensor { intrinsics, lens, .. } = camera.sensor;
        frames.push(Frame::new(relative_path(path), [0.0; 16], intrinsics, lens));
        let pose = chunk.world(camera).pose(camera.pose);
        poses.push(pose.transpose().to_cols_array());
    }
    missing(file, &absent, total, &mut notes)?;
    if chunk.unaligned > 0 {
        let all = total + chunk.unaligned;
        notes.push(format!("{} of {all} cameras are not aligned: left out", chunk.unaligned));
    }
    if chunk.disabled > 0 {
        notes.push(format!("{} cameras are disabled: they are left out", chunk.disabled));
    }
    if chunk.cameras.iter().any(|camera| camera.sensor.is_rolling) {
        notes.push("rolling shutters are taken for global ones: motion may blur models".to_owned());
    }
    let middle = poses.iter().map(|pose| DVec3::new(pose[3], pose[7], pose[11])).sum::<DVec3>()
        / poses.len().max(1) as f64;
    let up = (middle.length() > GLOBE).then_some(middle);
    Ok(Cameras { frames, poses, up, notes })
}

impl Chunk {
    fn parse(text: &str) -> Result<Self, String> {
        let document = parse(text)?;
        let mut chunks = document.root_element().children().filter(|c| c.has_tag_name("chunk"));
        let chunk = chunks.next().ok_or("no <chunk>")?;
        if chunks.next().is_some() {
            return Err("several chunks, expected one".to_owned());
        }
        let mut sensors = HashMap::new();
        for sensor in elements(chunk, "sensors", "sensor") {
            let id = sensor.attribute("id").unwrap_or_default();
            let read = Sensor::read(sensor).map_err(|problem| format!("sensor {id}: {problem}"))?;
            sensors.insert(id, read);
        }
        let mut components = HashMap::new();
        for component in elements(chunk, "components", "component") {
            let id = component.attribute("id").unwrap_or_default();
            let similarity = Similarity::read(component);
            let similarity = similarity.map_err(|problem| format!("component {id}: {problem}"))?;
            components.extend(similarity.map(|similarity| (id.to_owned(), similarity)));
        }
        let own = Similarity::read(chunk)?;
        let (cameras, unaligned, disabled) = (Vec::new(), 0, 0);
        let mut found = Self { cameras, unaligned, disabled, components, own };
        for camera in elements(chunk, "cameras", "camera") {
            let label = camera.attribute("label").unwrap_or_default().to_owned();
            let wrong = |problem| format!("camera \"{label}\": {problem}");
            let sensor = camera.attribute("sensor_id").and_then(|id| sensors.get(id));
            let matrix = numbers::<16>(camera, "transform").map_err(wrong)?;
            match (sensor.copied().flatten(), matrix) {
                _ if is_off(camera) => found.disabled += 1,
                (Some(sensor), Some(matrix)) => {
                    let component = camera.attribute("component_id").map(ToOwned::to_owned);
                    let pose = DMat4::from_cols_array(&matrix).transpose();
                    found.cameras.push(Camera { label, sensor, component, pose });
                }
                _ => found.unaligned += 1,
            }
        }
        if found.cameras.is_empty() {
            return Err("no aligned camera".to_owned());
        }
        found.cameras.sort_by(|a, b| a.label.cmp(&b.label));
        Ok(found)
    }

    /// Components that do not say where they are have nothing in common: keeps the one with
    /// the most cameras.
    fn keep_one_world(&mut self, notes: &mut Vec<String>) {
        let mut counts: Vec<(Option<String>, usize)> = Vec::new();
        for Camera { component, .. } in &self.cameras {
            match counts.iter_mut().find(|(known, _)| known == component) {
                Some((_, count)) => *count += 1,
                None => counts.push((component.clone(), 1)),
            }
        }
        let is_placed =
            |id: &Option<String>| id.as_ref().is_some_and(|id| self.components.contains_key(id));
        if counts.len() < 2 || counts.iter().all(|(id, _)| is_placed(id)) {
            return;
        }
        // The first of equals.
        let Some((best, count)) = counts.iter().rev().max_by_key(|(_, count)| *count) else {
            return;
        };
        notes.push(format!(
            "{} components without a common world: the one with the most cameras, {count}, is taken",
            counts.len()
        ));
        self.cameras.retain(|camera| camera.component == *best);
    }

    /// What leads from a camera's world to the common one.
    fn world(&self, camera: &Camera) -> Similarity {
        let component = camera.component.as_ref().and_then(|id| self.components.get(id));
        component.copied().or(self.own).unwrap_or(Similarity::NONE)
    }
}

/// Whether a camera takes no part.
fn is_off(camera: Node<'_, '_>) -> bool {
    matches!(camera.attribute("enabled"), Some("0" | "false" | "False"))
}

/// The elements of a name in a list, also in groups inside it.
fn elements<'a, 'd>(
    chunk: Node<'a, 'd>,
    list: &str,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'd>> {
    let list = child(chunk, list);
    list.into_iter().flat_map(|list| list.descendants()).filter(move |n| n.has_tag_name(name))
}

impl Similarity {
    const NONE: Self = Self { rotation: DMat3::IDENTITY, translation: DVec3::ZERO, scale: 1.0 };

    /// That of a component or chunk; `None` where it has none.
    fn read(node: Node<'_, '_>) -> Result<Option<Self>, String> {
        let Some(node) = child(node, "transform") else { return Ok(None) };
        let rotation = numbers::<9>(node, "rotation")?;
        let translation = numbers::<3>(node, "translation")?;
        let scale = number(node, "scale")?.unwrap_or(1.0);
        if !(1e-9..1e9).contains(&scale) {
            return Err(format!("a scale of {scale}, expected a number above 0"));
        }
        let rotation = rotation.map_or(DMat3::IDENTITY, |m| DMat3::from_cols_array(&m).transpose());
        let translation = translation.map_or(DVec3::ZERO, DVec3::from_array);
        Ok(Some(Self { rotation, translation, scale }))
    }

    /// A camera's pose there, with OpenGL camera axes.
    fn pose(self, pose: DMat4) -> DMat4 {
        let at = self.scale * (self.rotation * pose.w_axis.truncate()) + self.translation;
        let turned = DMat4::from_mat3(self.rotation) * pose;
        let axes = turned * DMat4::from_diagonal(DVec4::new(1.0, -1.0, -1.0, 1.0));
        DMat4::from_cols(axes.x_axis, axes.y_axis, axes.z_axis, at.extend(pose.w_axis.w))
    }
}
