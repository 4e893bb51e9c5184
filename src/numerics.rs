//! Integrators and root location that know no latch and no file: a time, a state, a function.
