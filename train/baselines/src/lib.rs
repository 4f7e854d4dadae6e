//! What NeRF was compared with in its paper, as honest baselines: [local light field
//! fusion](Method::Llff), [scene representation networks](Method::Srn) and [neural
//! volumes](Method::NeuralVolumes). They are trained on one scene, on CPUs, in minutes; what
//! differs from their papers is said in docs/methods.md. Their files are read by this crate alone.
//!
//! # Example
//! ```
//! use std::time::Instant;
//!
//! use pocketnerf_baselines::{Baseline, Method, Origin, Photographs, Renderer, Run};
//! use pocketnerf_train::builtin;
//! use pocketnerf_train::dataset::Split;
//! use pocketnerf_train::lens::Lens;
//! use pocketnerf_train::picture::Painter;
//! use pocketnerf_train::trainer::Length;
//!
//! // The built-in scene as thumbnails, and a few steps.
//! let dataset = builtin::dataset(Split::Train, 16);
//! let camera = dataset.views[0].camera;
//! let origin = Origin::of(&dataset, 0, 16);
//! let photographs = Photographs::new(dataset, None)?;
//! let mut run = Run::new(Method::Srn, &photographs, origin, Length::Steps(5), Instant::now())?;
//! while run.step(&photographs)?.is_some() {}
//!
//! // From the bytes of its file to a picture.
//! let bytes = run.finish()?.to_bytes();
//! let baseline = Baseline::from_bytes(&bytes)?;
//! let mut renderer = Renderer::new(&baseline);
//! let picture = renderer.paint(&camera, &Lens::Pinhole)?;
//! assert_eq!(picture.rgba.len(), 4 * 25 * 25);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod error;
mod file;
#[cfg(test)]
mod golden;
mod llff;
mod network;
mod neural_volumes;
mod origin;
mod photographs;
mod renderer;
mod run;
mod scene;
mod srn;

pub use error::BaselineError;
pub use file::{Baseline, is_baseline};
pub use origin::Origin;
pub use photographs::{Photographs, Place};
pub use renderer::Renderer;
pub use run::{Run, StoredRun};
pub use scene::Method;
