//! Model files: their bytes, what is in them and what they show.

mod antialias;
mod camera;
mod compact;
mod compare;
mod detail;
mod golden;
mod mutated;
mod packed;
mod query;
mod rounded;
mod specification;
mod still_life;
mod unknown;
