//! To be written: bias.
