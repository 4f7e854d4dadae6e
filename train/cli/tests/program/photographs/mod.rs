//! What is learnt of the photographs beside the scene.

mod exposure;
mod fitted;
mod fog;
mod refined;
mod teachers;
