//! Why a lever could not be followed to the end, by any method.

/// Why a method could not follow the lever to the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Breakdown {
    /// Angle or angular velocity is no longer a finite number.
    NotFinite,
    /// More steps than any honest run needs.
    TooManySteps,
    /// The step fell below the resolution of time.
    StepVanished,
    /// The motion in the stop dies away so fast that a sample would take too many steps.
    StopTooDamped,
    /// A sample held more meetings with the stop than any chatter can.
    TooManyEvents,
}

impl Breakdown {
    /// Returns a few words for people.
    pub fn text(self) -> &'static str {
        match self {
            Self::NotFinite => "the state grew beyond all numbers",
            Self::TooManySteps => "it needed too many steps",
            Self::StepVanished => "its step fell below the resolution of time",
            Self::TooManyEvents => "it met and left the stop too often within a sample",
            Self::StopTooDamped => "the stop is so damped that a sample would take too many steps",
        }
    }
}
