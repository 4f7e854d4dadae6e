//! Damaged files of every convention of other programs are read or refused in one line.

use pocketnerf_tests::damage::mutate;
use pocketnerf_train::dataset::{LoadOptions, Split, load_with};
use pocketnerf_train::random::Random;

use crate::fixture::Folder;

/// Changes one of the files, so many times, and loads the folder. Both must happen: that it is
/// read, and that it is refused.
pub(crate) fn mutations(folder: &Folder, files: &[&str], times: usize) {
    let options = LoadOptions { hold_every: 0, ..LoadOptions::default() };
    let originals: Vec<Vec<u8>> =
        files.iter().map(|name| std::fs::read(folder.path().join(name)).unwrap()).collect();
    let mut random = Random::new(3, [files.len() as u64, originals[0].len() as u64, 0]);
    let start = folder.path().display().to_string();
    let (mut read, mut refused) = (0, 0);
    for i in 0..times {
        let file = i % files.len();
        let mut bytes = originals[file].clone();
        mutate(&mut random, &mut bytes);
        folder.write(files[file], &bytes);
        match load_with(folder.path(), Split::Train, &options) {
            Ok(dataset) => {
                read += 1;
                let numbers = dataset.views.iter().flat_map(|view| {
                    let camera = &view.camera;
                    camera.camera_to_world.into_iter().chain(camera.focal).chain(camera.center)
                });
                assert!(numbers.into_iter().all(f32::is_finite), "{i}");
            }
            Err(error) => {
                refused += 1;
                let line = error.to_string();
                let is_short = line.starts_with(&start) && line.len() < 1000;
                assert!(!line.contains('\n') && is_short, "{i}: {line}");
            }
        }
        folder.write(files[file], &originals[file]);
    }
    assert!(read > times / 50 && refused > times / 50, "{read} {refused}");
}
