//! Where radiance fields fail: [`modes`] says how photographs, cameras or settings are spoilt and
//! what that may cost, and a [`Row`] what it did cost and whether the program said so.
//!
//! A [`Mode`] makes a [`Case`] of a strength: what is trained, what is looked at, and what both
//! are compared with. [`page`] and [`drawing`] show the rows.

mod change;
pub mod drawing;
mod mode;
pub mod modes;
pub mod page;
mod row;

pub use change::{Change, Damage};
pub use mode::{Bar, Case, Context, Mode, Photos, Training, Viewing};
pub use modes::all;
pub use row::{Row, Verdict, csv, read_csv};
