//! The latch lever, its stop and its excitation.

pub mod design;
pub mod excitation;
pub mod lever;
pub mod parameters;
pub mod stop;

pub use design::Design;
