//! To be written: resample.
