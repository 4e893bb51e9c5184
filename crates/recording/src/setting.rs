//! The settings of a question, by the names that every interface uses for them.
//!
//! Errors, findings and reasons name a setting. Each interface words how it is given: as an option of
//! a command line, a key of a file or a field of a page.

use std::fmt;

macro_rules! settings {
    ($($(#[doc = $doc:literal])+ $name:ident = $key:literal,)+) => {
        /// A setting of a question.
        ///
        /// Displayed, it reads ``the setting `time_unit` ``.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Setting {
            $($(#[doc = $doc])+ $name,)+
        }

        impl Setting {
            /// Lists every setting.
            pub const ALL: &[Self] = &[$(Self::$name),+];

            /// Returns the key that files and documents use.
            pub fn key(self) -> &'static str {
                match self {
                    $(Self::$name => $key,)+
                }
            }
        }
    };
}

settings! {
    /// Format of the recording.
    InputFormat = "input_format",
    /// Channel to judge.
    Channel = "channel",
    /// Second in-plane channel, for a design with an axis.
    RadialChannel = "radial_channel",
    /// Column that holds the time.
    TimeColumn = "time_column",
    /// Unit of that column.
    TimeUnit = "time_unit",
    /// Clock of a log's messages that gives the time.
    TimeSource = "time_source",
    /// Sheet of a workbook.
    Sheet = "sheet",
    /// Line of a text table that names its columns.
    HeaderLine = "header_line",
    /// Line of a text table that holds the units of its columns.
    UnitLine = "unit_line",
    /// Last line of a text table.
    LastLine = "last_line",
    /// Lines of a text table that are skipped.
    SkipLines = "skip_lines",
    /// Decimal mark of a text table.
    Decimal = "decimal",
    /// Sample rate of a recording without time [Hz].
    RateHz = "rate_hz",
    /// Instant of first contact on the recording's clock [s].
    TimeZero = "time_zero",
    /// Unit of acceleration.
    Unit = "unit",
    /// Acceleration that one of the samples means, where they are another quantity.
    Sensitivity = "sensitivity",
    /// Remarks that a person has read and accepts.
    AcceptedRemarks = "accepted_remarks",
    /// Velocity change that a person knows from another source [m/s].
    VelocityChange = "velocity_change",
    /// Doubts about a recording unlike a crash that a person settles.
    Accept = "accept",
    /// Factors between the acceleration at the sensor's place and the one at the latch.
    Transfer = "transfer",
    /// Judgement of every lateral channel of that side in the file.
    Siblings = "siblings",
    /// Check of the recording as a sled pulse.
    Sled206 = "sled206",
    /// Sign of the recorded acceleration that opens the lever.
    OpensWhen = "opens_when",
    /// Window whose mean is removed.
    Bias = "bias",
    /// Channel frequency class.
    Filter = "filter",
    /// Standard of the filter.
    FilterStandard = "filter_standard",
    /// Course of the acceleration between samples.
    Between = "between",
    /// Rate fed to the model.
    Resample = "resample",
    /// Judged window.
    Window = "window",
    /// Design file.
    Design = "design",
    /// Override of one design key.
    Set = "set",
    /// Stop model.
    Model = "model",
    /// Integrator.
    Method = "method",
    /// Steps of a fixed-step integrator per natural period.
    StepsPerPeriod = "steps_per_period",
    /// Error that an integrator allows in a step [rad].
    Tolerance = "tolerance",
    /// Largest ensemble.
    Members = "members",
    /// Seed of the ensemble.
    Seed = "seed",
    /// Initial angle [rad].
    Phi0 = "phi0",
    /// Initial angular velocity [rad/s].
    Omega0 = "omega0",
    /// Change of a limit on input.
    Limit = "limit",
    /// Distance of a counterweight from the pivot [m].
    CounterweightRadius = "counterweight_radius",
    /// Permission for pairs of a gate's baseline to be missing.
    AllowRemoved = "allow_removed",
    /// Folder of a report.
    Out = "out",
    /// Store of a gate.
    Store = "store",
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the setting `{}`", self.key())
    }
}
