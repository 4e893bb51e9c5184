//! The latch lever, its stop and its excitation.
//!
//! `lever` and `stop` hold the numbers of eq. (2.1) and (2.2), `excitation` what moves the base, `catch` a second
//! body that blocks the lever;
//! `linkage` reduces several elements to one lever, `vector` has the vehicle's axes.
//! `design` is lever, stop, limit and tolerances as a file states them, and `parameters` the table
//! of all numbers of a design, `tolerance` how far one scatters, `criterion` what loses the door.

pub mod catch;
pub mod criterion;
pub mod design;
pub mod excitation;
pub mod lever;
pub mod linkage;
pub mod parameters;
pub mod stop;
pub mod tolerance;
pub mod vector;

pub use design::Design;
