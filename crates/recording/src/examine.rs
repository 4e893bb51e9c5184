//! What a file says of a channel is judged here, once for all formats.

pub(crate) mod clock;
pub(crate) mod worded;
