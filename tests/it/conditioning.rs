//! Guards the order of conditioning, the bias with its standard error, and the defaults.
