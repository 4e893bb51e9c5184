//! To be written: quality.
