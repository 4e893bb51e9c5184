//! The words that laboratories use, in capitals.

/// Words that take the worth from a sample. Umlauts are written out, as in all lists here.
pub(super) const FAULTS: &[&str] = &[
    "INVALID",
    "INVALIDATED",
    "QUESTIONABLE",
    "QUES",
    "EXCEED",
    "EXCEEDED",
    "EXCEEDS",
    "SATURATE",
    "SATURATED",
    "SATURATES",
    "SATURATION",
    "CLIPPED",
    "CLIPED",
    "CLIPPING",
    "CLIPS",
    "OVERRANGE",
    "OVERRANGED",
    "OVERLOAD",
    "OVERLOADED",
    "OVERFLOW",
    "OFFSCALE",
    "LOST",
    "LOSS",
    "FAIL",
    "FAILED",
    "FAILS",
    "FAILURE",
    "FAULT",
    "FAULTY",
    "DISCONNECTED",
    "BROKE",
    "BROKEN",
    "SEVERED",
    "SHORTED",
    "DROPOUT",
    "DROPOUTS",
    "ERRATIC",
    "UNRELIABLE",
    "UNUSABLE",
    "UNUSEABLE",
    "INOPERATIVE",
    "INOPERABLE",
    "NONFUNCTIONAL",
    "SUSPECT",
    "DEFECT",
    "DEFECTIVE",
    "MALFUNCTION",
    "MALFUNCTIONED",
    "MEANINGLESS",
    "BAD",
    "DAMAGED",
    "INTERMITTENT",
    "DETACHED",
    "LOOSE",
    "DEBONDED",
    "UNPLUGGED",
    "CORRUPT",
    "CORRUPTED",
    "DEAD",
    "DISREGARD",
    "DISREGARDED",
    "DISCARD",
    "DISCARDED",
    "IGNORE",
    "DISAPPEARED",
    "TRUNCATED",
    "TRUNCATES",
    "UNGUELTIG",
    "UNBRAUCHBAR",
    "AUSGEFALLEN",
    "AUSFALL",
    "UEBERSTEUERT",
    "UEBERSTEUERUNG",
    "ABGERISSEN",
    "ABGEFALLEN",
    "GERISSEN",
    "KABELBRUCH",
    "KABELRISS",
    "GESTOERT",
    "FEHLERHAFT",
    "DEFEKT",
    "OVL",
    "OVLD",
    "OVERRUN",
    "OVERRUNS",
    "UNDERRUN",
    "ERRONEOUS",
    "FLATLINE",
    "FLATLINED",
    "FLATLINES",
    "BOTTOMED",
    "RAILED",
    "PEGGED",
    "MAXED",
    "JUNK",
    "DIED",
];

/// What carries a signal.
pub(super) const CARRIERS: &[&str] = &[
    "CABLE",
    "CABLES",
    "WIRE",
    "WIRES",
    "LEAD",
    "CONNECTOR",
    "SENSOR",
    "ACCELEROMETER",
    "KABEL",
    "STECKER",
    "UMBILICAL",
    "UMBILICALS",
    "HARNESS",
];

/// Successions of words, each one of several, that take the worth from a sample.
pub(super) const FAULTY_PHRASES: &[&[&[&str]]] = &[
    &[&["OVER", "OUT", "OVR"], &["RANGE", "RANGED"]],
    &[&["OUT"], &["OF"], &["RANGE", "SCALE"]],
    &[&["OFF"], &["SCALE"]],
    &[
        &[
            "REACHED", "REACHES", "HIT", "HITS", "BEYOND", "ABOVE", "OVER", "PAST",
        ],
        &["FULL"],
        &["SCALE"],
    ],
    &[&["FULL"], &["SCALE"], &["REACHED", "HIT"]],
    &[
        CARRIERS,
        &[
            "CUT",
            "SEPARATED",
            "PULLED",
            "DAMAGE",
            "TORN",
            "SNAPPED",
            "OPEN",
            "MISSING",
        ],
    ],
    &[
        &["CAME", "TORN", "PULLED", "FELL", "RIPPED", "KNOCKED"],
        &["OFF", "OUT", "AWAY"],
    ],
    &[
        &["WENT", "GOES", "GOING"],
        &["OPEN", "DEAD", "BAD", "OFF", "FLAT"],
    ],
    &[&["OPEN", "SHORT"], &["CIRCUIT"]],
    &[
        &["DATA", "SIGNAL", "RECORD", "RECORDING", "DATEN"],
        &[
            "END", "ENDS", "ENDED", "STOP", "STOPS", "STOPPED", "CEASES", "CEASED", "MISSING",
            "ENDEN", "FEHLEN",
        ],
    ],
    &[
        &["END"],
        &["OF"],
        &["DATA", "SIGNAL", "RECORD", "RECORDING"],
    ],
    &[
        &["WRONG", "INCORRECT", "FALSCHE", "FALSCHES"],
        &[
            "POLARITY",
            "SIGN",
            "UNIT",
            "UNITS",
            "SCALE",
            "SCALING",
            "DATA",
            "AXIS",
            "CALIBRATION",
            "SENSITIVITY",
            "RANGE",
            "DATEN",
            "VORZEICHEN",
        ],
    ],
    &[COUNTED, NOT_KEPT],
    &[NOT_KEPT, COUNTED],
    &[&["GAP", "GAPS"], &["IN"], COUNTED],
    &[COUNTED, &["GAP", "GAPS"]],
    &[&["FLAT"], &["LINE", "LINED", "LINES"]],
    &[
        &[
            "DATA",
            "SIGNAL",
            "CHANNEL",
            "SENSOR",
            "RECORDING",
            "ACQUISITION",
            "COLLECTION",
            "MEASUREMENT",
            "DAQ",
            "ADC",
            "GAIN",
            "SCALING",
        ],
        &["ERROR", "ERRORS"],
    ],
];

/// What a recorder counts.
pub(super) const COUNTED: &[&str] = &[
    "SAMPLE", "SAMPLES", "DATA", "POINT", "POINTS", "SCAN", "SCANS", "ROW", "ROWS", "BLOCK",
    "BLOCKS", "PACKET", "PACKETS",
];

/// What becomes of those that are not in the record.
const NOT_KEPT: &[&str] = &[
    "SKIPPED",
    "DROPPED",
    "MISSED",
    "MISSING",
    "OVERWRITTEN",
    "LOST",
];

/// Words that take the worth from a sample if they are all that is said beside it.
pub(super) const FAULTS_ALONE: &[&str] = &[
    "CLIP", "CLIPS", "GAP", "GAPS", "ERROR", "ERR", "OPEN", "SHORT", "SKIPPED", "DROPPED",
    "MISSED", "MISSING",
];

/// Words by whose misspellings a fault is known: "QUESTIONALBE".
pub(super) const OFTEN_MISSPELT: &[&str] = &[
    "QUESTIONABLE",
    "INVALID",
    "SATURATED",
    "SATURATION",
    "OVERLOADED",
    "ERRONEOUS",
    "MALFUNCTION",
    "DISCONNECTED",
    "UNRELIABLE",
    "INOPERATIVE",
    "INTERMITTENT",
    "DEFECTIVE",
    "FLATLINED",
    "DISREGARD",
    "TRUNCATED",
    "EXCEEDED",
];

/// Successions of words that are worth a look: whether the samples were mended is not said.
pub(super) const DOUBTFUL_PHRASES: &[&[&[&str]]] = &[
    &[
        &["AXES", "AXIS", "CHANNELS", "WIRES", "LEADS", "CABLES"],
        &["SWITCHED", "CROSSED", "MIXED"],
    ],
    // A unit in words may contradict the one that counts.
    &[&["UNIT", "UNITS"], &["M", "MM"], &["S", "S2", "SS", "SEC2"]],
    &[&["DATA"], &["IN"], &["M", "MM"], &["S", "S2", "SS", "SEC2"]],
];

/// Words between "only" and the time for which samples are good: "USE ONLY THE FIRST 30 MS".
pub(super) const UP_TO: &[&str] = &[
    "FIRST", "THE", "FOR", "UP", "TO", "UNTIL", "TILL", "ABOUT", "APPROX", "USE", "DATA", "VALID",
    "GOOD", "DIE", "ERSTEN", "BIS",
];

/// Words that show that it is the samples of which there are "only" some.
pub(super) const OF_SAMPLES: &[&str] = &[
    "DATA",
    "USE",
    "USED",
    "SIGNAL",
    "RECORD",
    "RECORDED",
    "RECORDING",
    "CHANNEL",
    "CURVE",
    "FIRST",
    "DATEN",
    "ERSTEN",
];

/// Words for what is worth a look.
pub(super) const DOUBTS: &[&str] = &[
    "SPIKE",
    "SPIKES",
    "NOISE",
    "NOISY",
    "DRIFT",
    "DRIFTS",
    "SHIFT",
    "SHIFTED",
    "ANOMALY",
    "ANOMALIES",
    "ANOMALOUS",
    "WRONG",
    "INCORRECT",
    // A sign that was turned over: whether before the samples were stored is not said.
    "REVERSED",
    "INVERTED",
    "SWAPPED",
    "VERTAUSCHT",
    "STOERUNG",
    "ERROR",
    "ERRORS",
    "GAP",
    "GAPS",
    "GLITCH",
    "GLITCHES",
    "DISCONTINUITY",
    "DISCONTINUITIES",
    "TIMEOUT",
    "INTERCHANGED",
    "EXCHANGED",
    "MISLABELED",
    "MISLABELLED",
];

/// Words for samples that can be used.
pub(super) const GOOD: &[&str] = &[
    "VALID",
    "GOOD",
    "USABLE",
    "USEABLE",
    "OK",
    "OKAY",
    "ACCEPTABLE",
    "RELIABLE",
    "ACCURATE",
    "CORRECT",
    "GUELTIG",
    "GUELTIGE",
    "BRAUCHBAR",
    "BRAUCHBARE",
    "VERWERTBAR",
    "VERWERTBARE",
    "VAILD",
];

/// Words whose denial takes the worth from the samples: "NO DATA", "DO NOT USE".
pub(super) const NEEDED: &[&str] = &[
    "DATA",
    "SIGNAL",
    "OUTPUT",
    "RESPONSE",
    "DATEN",
    "MESSDATEN",
    "USE",
    "USED",
    "TRUST",
    "TRUSTED",
    "FUNCTION",
    "FUNCTIONAL",
    "FUNCTIONING",
    "WORK",
    "WORKING",
    "OPERATIONAL",
    "OPERATING",
    "VERWENDEN",
];

/// Words whose denial does so if it is the samples that are spoken of: "DATA NOT RECORDED",
/// but not "SERIAL NUMBER NOT RECORDED".
pub(super) const NEEDED_OF_DATA: &[&str] = &[
    "RECORD",
    "RECORDED",
    "COLLECTED",
    "ACQUIRED",
    "AVAILABLE",
    "CONNECTED",
    "MEASURED",
    "INSTALLED",
];

/// What is spoken of, if it is the samples.
pub(super) const DATA: &[&str] = &[
    "DATA",
    "DATEN",
    "SIGNAL",
    "CHANNEL",
    "KANAL",
    "SENSOR",
    "ACCELEROMETER",
    "CURVE",
    "DID",
];

/// What may well be missing: "NO DATA LOST", "NO SIGNAL CONDITIONING".
pub(super) const MAY_BE_MISSING: &[&str] = &[
    "LOST",
    "LOSS",
    "LOSSES",
    "MISSING",
    "DROPOUT",
    "DROPOUTS",
    "CLIPPING",
    "CLIPPED",
    "SATURATION",
    "CORRUPTED",
    "CORRUPTION",
    "TRUNCATED",
    "NOISE",
    "CORRECTION",
    "CONDITIONING",
    "PROCESSING",
    "FILTERING",
    "PROBLEM",
    "PROBLEMS",
    "ISSUES",
    "ANOMALIES",
    "ERRORS",
    "OVERLOAD",
    "OVERLOADS",
    "OVERFLOW",
    "OVERRUN",
    "OVERRUNS",
    "UNDERRUN",
    "SKIPPED",
    "DROPPED",
    "MISSED",
    "GAP",
    "GAPS",
    "ERROR",
    "FAILURE",
    "FAILURES",
    "DISCONTINUITY",
    "DISCONTINUITIES",
    "SPIKES",
    "GLITCHES",
];

/// Words that deny the next one.
pub(super) const DENIALS: &[&str] = &[
    "NO", "NOT", "WITHOUT", "NON", "NEVER", "CANNOT", "CANT", "DONT", "DIDNT", "ISNT", "WASNT",
    "DOESNT", "KEIN", "KEINE", "KEINEN", "NICHT", "OHNE",
];

/// Words that stand between a denial and what it denies.
pub(super) const BETWEEN: &[&str] = &[
    "A",
    "AN",
    "THE",
    "ANY",
    "MORE",
    "FURTHER",
    "LONGER",
    "FULLY",
    "TO",
    "BE",
    "BEEN",
    "IS",
    "ARE",
    "WAS",
    "WERE",
    "HAS",
    "HAVE",
    "CONSIDERED",
    "DEEMED",
];

/// Words that point to the time before an instant.
pub(super) const BEFORE: &[&str] = &[
    "BEFORE", "PRIOR", "UNTIL", "TILL", "TO", "THROUGH", "FIRST", "WITHIN", "BIS", "VOR", "UP",
];

/// Words that set a limit to what is good.
pub(super) const LIMITING: &[&str] = &[
    "AFTER", "FROM", "SINCE", "BETWEEN", "ONLY", "AB", "NACH", "NUR", "PAST", "BEYOND", "ENDS",
    "END", "ENDED",
];

/// Words after which an instant stands.
pub(super) const AT: &[&str] = &[
    "AT", "AFTER", "FROM", "SINCE", "PAST", "BEYOND", "UNTIL", "TILL", "T", "AB", "BEI", "NACH",
];

/// Units that show that a number is no instant.
pub(super) const OTHER_UNITS: &[&str] = &[
    "G", "GS", "HZ", "KHZ", "V", "MV", "VOLT", "VOLTS", "PERCENT", "KM", "KPH", "KMH", "MPH", "N",
    "KN", "NM", "M", "MM", "CM", "IN", "INCH", "INCHES", "DEG", "DEGREES", "C", "F",
];

/// Words between the two ends of a stretch of time.
pub(super) const STRETCH: &[&str] = &["AND", "TO", "BIS", "UND"];

/// Words that fill the place of a comment.
pub(super) const NO_COMMENTS: &[&str] = &[
    "",
    "NO COMMENTS",
    "NO COMMENT",
    "NONE",
    "NO REMARKS",
    "KEINE",
    "NOVALUE",
    "N A",
    "NA",
    "OK",
];
