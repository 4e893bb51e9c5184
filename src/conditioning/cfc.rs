//! To be written: cfc.
