//! Fog that photographs do not forbid.

mod clearing;
mod near_cameras;
