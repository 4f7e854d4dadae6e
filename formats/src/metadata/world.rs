//! WORLD.

use serde::{Deserialize, Serialize};

use super::Fields;
use crate::FormatError;
use crate::about::World;

/// WORLD; the fields are those of [`World`], zeros where nothing is known.
#[derive(Serialize, Deserialize)]
struct WorldV1 {
    up: [f32; 3],
    metres: f32,
}

pub(crate) fn read(mut fields: Fields<'_>) -> Result<World, FormatError> {
    let WorldV1 { up, metres } = fields.take()?;
    let length = up[0] * up[0] + up[1] * up[1] + up[2] * up[2];
    fields.check("up", length == 0.0 || (length - 1.0).abs() < 1e-3)?;
    fields.check("metres", (0.0..f32::INFINITY).contains(&metres))?;
    fields.finish()?;
    Ok(World { up: (length > 0.0).then_some(up), metres: (metres > 0.0).then_some(metres) })
}

pub(crate) fn write(world: &World) -> impl Serialize {
    let World { up, metres } = *world;
    WorldV1 { up: up.unwrap_or_default(), metres: metres.unwrap_or_default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::{SectionId, kind};
    use crate::metadata::{encode, test_section};

    #[test]
    fn bytes_of_world_v1() {
        let read = |world: &World| {
            let bytes = encode(&write(world));
            read(Fields::open(&test_section(kind::WORLD, &bytes)).unwrap())
        };
        let bad = |field| {
            let section = SectionId::first(kind::WORLD);
            Err(FormatError::Value { section, field })
        };
        let world = World { up: Some([0.0, -1.0, 0.0]), metres: Some(0.5) };
        let bytes = encode(&write(&world));
        assert_eq!(bytes, [0, 0, 0, 0, 0, 0, 0x80, 0xbf, 0, 0, 0, 0, 0, 0, 0, 0x3f]);
        for world in [world, World { up: None, ..world }, World::default()] {
            assert_eq!(read(&world), Ok(world));
        }
        for up in [[0.5; 3], [1.0, 1.0, 0.0], [f32::NAN, 0.0, 1.0]] {
            assert_eq!(read(&World { up: Some(up), ..world }), bad("up"));
        }
        for metres in [-1.0, f32::NAN, f32::INFINITY] {
            let world = World { metres: Some(metres), ..world };
            assert_eq!(read(&world), bad("metres"));
        }
        assert_eq!(([0.0, 0.0, 1.0], [0.0, -1.0, 0.0]), (World::default().up(), world.up()));
    }
}
