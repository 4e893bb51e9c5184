//! What fuzzing shares: the targets, and an allocator that refuses requests beyond a bound.

pub mod allocator;
pub mod seeds;
pub mod targets;

#[global_allocator]
static ALLOCATOR: allocator::Bounded = allocator::Bounded;
