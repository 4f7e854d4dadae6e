//! The `.pnerf` model file: a radiance field and everything needed to render it, in a few
//! hundred kilobytes to a few megabytes.
//!
//! [`open`] reads in place: the weights stay in the bytes they came in (a mapped
//! file, flash memory, `include_bytes!`), at any alignment, without a heap and
//! without copying. [`ModelFile::verify`] checks every byte; [`open_verified`]
//! does both: call it on files from untrusted sources.
//! `SPEC.md` beside this crate specifies the format.
//!
//! # Features
//! * none: reading, `no_std` without a heap.
//! * `alloc`: [`write`](write()) and [`ContainerWriter`].
//! * `std` (default): [`write_atomically`], faster checksums.
//! * `ndc`, `contracted` (default): the spaces of forward-facing captures and of scenes without
//!   an end, beside boxes.
//! * `hash-grid`, `nerf` (default): kinds of field. A file of a kind that is left out is
//!   refused by name; at least one is needed. `all-kinds`: every kind of field and space.
//! * `import`: [`import`], the checkpoints that other programs wrote.
//!
//! # Example
#![cfg_attr(all(feature = "alloc", feature = "hash-grid"), doc = "```")]
#![cfg_attr(not(all(feature = "alloc", feature = "hash-grid")), doc = "```ignore")]
//! use pocketnerf_core::encoding::{GridIndex, HashGrid, HashGridConfig, MAX_LEVELS};
//! use pocketnerf_core::field::{Decoder, HashGridField, Shading};
//! use pocketnerf_core::network::{Dense, Mlp};
//! use pocketnerf_core::{
//!     AnyField, ColorSpace, DType, Display, Layout, Model, Sampling, Space, TensorView,
//! };
//! use pocketnerf_formats::{About, Precision};
//!
//! // A small hash grid: one level of 64 entries, whose value becomes log density and one
//! // feature; the feature and a constant become a colour.
//! let config = HashGridConfig {
//!     n_levels: 1,
//!     n_features_per_level: 1,
//!     log2_hashmap_size: 6,
//!     base_resolution: 2,
//!     per_level_scale: 1.0,
//!     index: GridIndex::Blocked,
//! };
//! let weights: Vec<u8> = (0..64).flat_map(|i| (0.1 * i as f32).to_le_bytes()).collect();
//! let tensor = |rows: u32, cols: u32| {
//!     let bytes = &weights[..4 * (rows * cols) as usize];
//!     TensorView::new(bytes, DType::F32, [rows, cols], 0, Layout::RowMajor)
//! };
//! let mut levels = [TensorView::EMPTY; MAX_LEVELS];
//! levels[0] = tensor(64, 1)?;
//! let model = Model {
//!     field: AnyField::HashGrid(HashGridField {
//!         grid: HashGrid { config, levels },
//!         decoder: Decoder {
//!             density: Mlp::new(&[Dense { weight: tensor(1, 2)?, bias: None }])?,
//!             color: Mlp::new(&[Dense { weight: tensor(2, 3)?, bias: None }])?,
//!             n_features: 1,
//!             sh_degree: 1,
//!             shading: Shading::PerSample,
//!             log_density_bias: 0.0,
//!         },
//!     }),
//!     space: Space::Box { min: [-1.0; 3], max: [1.0; 3] },
//!     occupancy: None,
//!     sampling: Sampling { step: 0.01, near: 0.0, far: 4.0, min_transmittance: 1e-3 },
//!     hierarchical: None,
//!     display: Display { background: [1.0; 3], color_space: ColorSpace::Srgb, tolerance: Display::TOLERANCE },
//! };
//!
//! let bytes = pocketnerf_formats::write(&model, &About::default(), Precision::F16)?;
//! let file = pocketnerf_formats::open_verified(&bytes)?;
//! assert_eq!(file.model.space, model.space);
//! assert_eq!(file.tensors().count(), 3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]
#![cfg_attr(not(feature = "alloc"), allow(dead_code, reason = "what the writer alone needs"))]
#![cfg_attr(
    not(feature = "import"),
    allow(rustdoc::broken_intra_doc_links, reason = "the writer, the checkpoints")
)]

#[cfg(any(feature = "alloc", test))]
extern crate alloc;
#[cfg(any(feature = "std", test))]
extern crate std;

mod about;
#[cfg(feature = "std")]
mod atomic;
mod container;
mod directory;
mod error;
#[cfg(feature = "import")]
pub mod import;
mod metadata;
mod packed;
mod photographs;
mod reader;
mod tensor_name;
#[cfg(feature = "alloc")]
mod write;

pub use about::{About, DefaultCamera, MAX_PICTURE_SIDE, PixelOrigin, Provenance, Scene, World};
#[cfg(feature = "std")]
pub use atomic::write_atomically;
pub use container::{
    ALIGNMENT, CRITICAL, Container, HEADER_BYTES, Header, MAGIC, MAJOR, MAX_SECTIONS, MINOR, RAW,
    Section, SectionId, kind,
};
pub use error::FormatError;
pub use metadata::MAX_METADATA_BYTES;
pub use metadata::field::tensors;
#[cfg(feature = "alloc")]
pub use packed::unpacked;
pub use packed::{
    PACKED_BLOCKS, PACKED_CELLS, PACKED_HALVES, PACKED_PLANES, PACKED_TABLE, PACKED_VOXELS,
    is_packed, unpack_into, unpacked_len,
};
#[cfg(feature = "alloc")]
pub use photographs::PhotographList;
pub use photographs::Photographs;
pub use reader::{ModelFile, open, open_verified};
pub use tensor_name::{Role, TensorName};
#[cfg(all(feature = "alloc", feature = "planes"))]
pub use write::packed_plane_len;
#[cfg(feature = "alloc")]
pub use write::{ContainerWriter, Precision, WriteError, pack, with_quality, with_world, write};
