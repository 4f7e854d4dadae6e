//! Exports of phone apps that track with ARKit: Polycam, Record3D, 3d Scanner App.
//!
//! All give camera-to-world poses with OpenGL camera axes (right, up, back) in metres, in a
//! world whose y is up: ARKit's. Here z is up, as after nerfstudio's `polycam_utils.py`: a point
//! (x, y, z) becomes (z, x, y).

mod polycam;
mod record3d;
mod scanner;

use std::path::Path;

use super::listing::Listing;
use super::{DatasetError, LoadOptions, Split};

/// Which app's export it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum App {
    Polycam,
    Record3d,
    Scanner,
}

/// The app that has written a folder.
pub(super) fn app(folder: &Path) -> Option<App> {
    let signs = [
        (App::Polycam, polycam::is_export as fn(&Path) -> bool),
        (App::Record3d, record3d::is_export),
        (App::Scanner, scanner::is_export),
    ];
    signs.into_iter().find(|(_, is_export)| is_export(folder)).map(|(app, _)| app)
}

/// Reads and checks the cameras of a split.
pub(super) fn list(
    app: App,
    folder: &Path,
    split: Split,
    options: &LoadOptions,
) -> Result<Listing, DatasetError> {
    let listing = match app {
        App::Polycam => polycam::list(folder, split, options),
        App::Record3d => record3d::list(folder, split, options),
        App::Scanner => scanner::list(folder, split, options),
    };
    Ok(Listing { metres: Some(1.0), ..listing? })
}

/// A pose in a world whose z is up, from one in which y is; both row after row.
fn upright(pose: [f64; 16]) -> [f64; 16] {
    let [x, y, z, last]: [[f64; 4]; 4] =
        std::array::from_fn(|row| std::array::from_fn(|column| pose[4 * row + column]));
    let turned = [z, x, y, last];
    std::array::from_fn(|i| turned[i / 4][i % 4])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_up_stays_up() {
        // At (1, 2, 3), right x, up y.
        let pose = [1., 0., 0., 1., 0., 1., 0., 2., 0., 0., 1., 3., 0., 0., 0., 1.];
        // At (3, 1, 2), right y, up z, back x.
        let turned = [0., 0., 1., 3., 1., 0., 0., 1., 0., 1., 0., 2., 0., 0., 0., 1.];
        assert_eq!(upright(pose), turned);
    }
}
