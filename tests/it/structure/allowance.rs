//! What the tests of structure let pass.

/// Names that several types may have, each with the reason.
pub(super) const SHARED_NAMES: &[(&str, &str)] = &[
    (
        "Arguments",
        "the command line of the program, and that of each study, each in its own file",
    ),
    (
        "Options",
        "those of each study, named with it: `basins::Options`",
    ),
    ("Row", "a line of the CSV file of each study"),
];
