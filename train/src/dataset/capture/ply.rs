//! Points of a PLY file: `x`, `y` and `z` of its vertices, as text or binary.

use std::path::Path;

use glam::DVec3;

/// Longer files are not read, bytes.
const LONGEST: u64 = 1 << 30;
/// A header ends before so many bytes.
const HEADER: usize = 1 << 16;

/// How numbers are written.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    Text,
    Little,
    Big,
}

/// What a header says.
struct Header {
    form: Form,
    vertices: usize,
    /// The bytes of each property of a vertex, and whether it is a float.
    sizes: Vec<(usize, bool)>,
    /// Which of them are x, y and z.
    place: [usize; 3],
    /// Bytes.
    len: usize,
}

/// The points that are finite; else what was found and what was expected.
pub(in crate::dataset) fn points(file: &Path) -> Result<Vec<DVec3>, String> {
    let unreadable = |error: std::io::Error| format!("cannot be read: {error}");
    let len = std::fs::metadata(file).map_err(unreadable)?.len();
    if len > LONGEST {
        return Err(format!("{len} bytes, at most {LONGEST} are read"));
    }
    let bytes = std::fs::read(file).map_err(unreadable)?;
    let header = Header::parse(&bytes)?;
    let body = &bytes[header.len..];
    let points = match header.form {
        Form::Text => header.text(body)?,
        form => header.binary(body, form)?,
    };
    Ok(points.into_iter().filter(|point| point.is_finite()).collect())
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let begin = &bytes[..bytes.len().min(HEADER)];
        let end = begin.windows(10).position(|part| part == b"end_header");
        let end = end.filter(|_| begin.starts_with(b"ply")).ok_or("no header of a PLY file")?;
        let line_end = begin[end..].iter().position(|c| *c == b'\n').ok_or("it ends early")?;
        let text = std::str::from_utf8(&begin[..end]).map_err(|_| "a header that is no text")?;
        let (mut form, mut vertices, mut is_vertex) = (None, None, false);
        let (mut sizes, mut place) = (Vec::new(), [None; 3]);
        for line in text.lines() {
            let words: Vec<&str> = line.split_whitespace().collect();
            match &words[..] {
                ["format", "ascii", _] => form = Some(Form::Text),
                ["format", "binary_little_endian", _] => form = Some(Form::Little),
                ["format", "binary_big_endian", _] => form = Some(Form::Big),
                ["element", "vertex", count] => {
                    vertices = count.parse().ok();
                    is_vertex = true;
                }
                ["element", name, _] if vertices.is_none() => {
                    return Err(format!("{name} before vertices, expected these first"));
                }
                ["element", ..] => is_vertex = false,
                ["property", kind, name] if is_vertex => {
                    if let Some(axis) = ["x", "y", "z"].iter().position(|axis| axis == name) {
                        place[axis] = Some(sizes.len());
                    }
                    sizes.push(size(kind).ok_or_else(|| format!("a property {kind}"))?);
                }
                ["property", "list", ..] if is_vertex => {
                    return Err("a list in vertices".to_owned());
                }
                _ => {}
            }
        }
        let form = form.ok_or("no known format")?;
        let vertices = vertices.ok_or("no number of vertices")?;
        let [Some(x), Some(y), Some(z)] = place else { return Err("no x, y and z".to_owned()) };
        Ok(Self { form, vertices, sizes, place: [x, y, z], len: end + line_end + 1 })
    }

    fn text(&self, body: &[u8]) -> Result<Vec<DVec3>, String> {
        let text = String::from_utf8_lossy(body);
        let lines = text.lines().filter(|line| !line.trim().is_empty());
        let points: Option<Vec<DVec3>> = lines
            .take(self.vertices)
            .map(|line| {
                let words: Vec<&str> = line.split_whitespace().collect();
                let [x, y, z] = self.place.map(|at| words.get(at)?.parse().ok());
                Some(DVec3::new(x?, y?, z?))
            })
            .collect();
        let points = points.ok_or("a vertex is no line of numbers")?;
        self.complete(points.len()).map(|()| points)
    }

    fn binary(&self, body: &[u8], form: Form) -> Result<Vec<DVec3>, String> {
        let stride: usize = self.sizes.iter().map(|(bytes, _)| bytes).sum();
        let begin = self.place.map(|at| self.sizes[..at].iter().map(|(bytes, _)| bytes).sum());
        self.complete(body.len() / stride.max(1))?;
        let vertices = body.chunks_exact(stride).take(self.vertices);
        let point = |vertex: &[u8]| {
            let axis = |a: usize| -> Option<f64> {
                let begin: usize = begin[a];
                let mut bytes = vertex[begin..begin + self.sizes[self.place[a]].0].to_vec();
                if form == Form::Big {
                    bytes.reverse();
                }
                match (bytes.len(), self.sizes[self.place[a]].1) {
                    (4, true) => Some(f32::from_le_bytes(bytes.try_into().ok()?).into()),
                    (8, true) => Some(f64::from_le_bytes(bytes.try_into().ok()?)),
                    _ => None,
                }
            };
            Some(DVec3::new(axis(0)?, axis(1)?, axis(2)?))
        };
        let points: Option<Vec<DVec3>> = vertices.map(point).collect();
        Ok(points.ok_or("x, y and z that are no floats")?)
    }

    fn complete(&self, found: usize) -> Result<(), String> {
        let expected = self.vertices;
        if found < expected {
            return Err(format!("cut off: {found} of {expected} vertices"));
        }
        Ok(())
    }
}

/// Bytes of a type, and whether it is a float.
fn size(kind: &str) -> Option<(usize, bool)> {
    Some(match kind {
        "char" | "uchar" | "int8" | "uint8" => (1, false),
        "short" | "ushort" | "int16" | "uint16" => (2, false),
        "int" | "uint" | "int32" | "uint32" => (4, false),
        "float" | "float32" => (4, true),
        "double" | "float64" => (8, true),
        _ => return None,
    })
}
