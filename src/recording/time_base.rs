//! Time bases: from printed stamps to a uniform rate, or to a resampled one with a finding.
