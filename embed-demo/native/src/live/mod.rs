//! A model that is still learnt, shown while it is.
//!
//! Whoever learns the model answers a [`Feed`] between two steps; a thread of its own paints, for a
//! fixed share of the processor's time that [`governor`] keeps. Pictures go to a window or to a
//! terminal.

pub mod feed;
pub mod governor;
mod painting;
pub mod terminal;
pub mod window;

pub use feed::Feed;
