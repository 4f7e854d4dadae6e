//! PHOTOGRAPHS.

use serde::{Deserialize, Serialize};

use super::Fields;
use crate::FormatError;
use crate::photographs::{POSE_BYTES, Photographs};

/// PHOTOGRAPHS; the fields are those of [`Photographs`].
#[derive(Serialize, Deserialize)]
struct PhotographsV1<'a> {
    focal: f32,
    bounds: [[f32; 3]; 2],
    poses: &'a [u8],
}

pub(crate) fn read<'a>(mut fields: Fields<'a>) -> Result<Photographs<'a>, FormatError> {
    let PhotographsV1 { focal, bounds, poses } = fields.take()?;
    fields.check("focal", focal.is_finite() && focal > 0.0)?;
    fields.finite("bounds", bounds.as_flattened())?;
    let [low, high] = bounds;
    fields.check("bounds", (0..3).all(|a| low[a] <= high[a]))?;
    let most = Photographs::MOST * POSE_BYTES;
    fields.check("poses", poses.len() <= most && poses.len().is_multiple_of(POSE_BYTES))?;
    fields.finish()?;
    Ok(Photographs { focal, bounds, poses })
}

pub(crate) fn write<'a>(photographs: &Photographs<'a>) -> impl Serialize + use<'a> {
    let Photographs { focal, bounds, poses } = *photographs;
    PhotographsV1 { focal, bounds, poses }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::container::{SectionId, kind};
    use crate::metadata::{encode, test_section};

    fn fields(bytes: &[u8]) -> Fields<'_> {
        Fields::open(&test_section(kind::PHOTOGRAPHS, bytes)).unwrap()
    }

    fn bad<T>(field: &'static str) -> Result<T, FormatError> {
        Err(FormatError::Value { section: SectionId::first(kind::PHOTOGRAPHS), field })
    }

    #[test]
    fn bytes_of_v1() {
        let poses = [0, 0, 0xff, 0xff, 0, 0x80, 0xff, 0x7f, 0xff, 0x7f, 0xff, 0x7f];
        let bounds = [[-1.0, 0.0, 2.0], [1.0, 0.5, 3.0]];
        let photographs = Photographs { focal: 1.5, bounds, poses: &poses };
        let bytes = encode(&write(&photographs));
        #[rustfmt::skip]
        let golden = [
            0, 0, 0xc0, 0x3f,
            0, 0, 0x80, 0xbf,  0, 0, 0, 0,     0, 0, 0, 0x40,
            0, 0, 0x80, 0x3f,  0, 0, 0, 0x3f,  0, 0, 0x40, 0x40,
            12,  0, 0, 0xff, 0xff, 0, 0x80, 0xff, 0x7f, 0xff, 0x7f, 0xff, 0x7f,
        ];
        assert_eq!(bytes, golden);
        assert_eq!(read(fields(&bytes)), Ok(photographs));
        // The first is at the low x, the high y and the middle z, and looks along -z.
        let pose = photographs.poses().next().unwrap();
        assert_eq!(pose[..8], [1.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 0.5]);
        assert_eq!(pose[8..11], [0.0, 0.0, 1.0]);
        assert!((pose[11] - 2.5).abs() < 1e-4);
        let read = |photographs: &Photographs<'_>| {
            let bytes = encode(&write(photographs));
            read(fields(&bytes)).map(|_| ())
        };
        for focal in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            let error = bad("focal");
            assert_eq!(read(&Photographs { focal, ..photographs }), error, "{focal}");
        }
        for low in [f32::NAN, 2.0] {
            let bounds = [[low, 0.0, 2.0], bounds[1]];
            let error = bad("bounds");
            assert_eq!(read(&Photographs { bounds, ..photographs }), error, "{low}");
        }
        for n in [11, 12 * (Photographs::MOST + 1)] {
            let error = bad("poses");
            assert_eq!(read(&Photographs { poses: &[0; 800][..n], ..photographs }), error, "{n}");
        }
        assert_eq!(read(&Photographs { poses: &[], ..photographs }), Ok(()));
    }
}
