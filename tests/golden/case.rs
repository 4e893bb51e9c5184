//! A case of the golden set, and how a table states it.

/// Index of the first sample and of the one after the last; sample 0 lies at first contact.
pub(super) const FROM: i64 = -200;
pub(super) const TO: i64 = 600;

/// Sample `k` [g] at 10 kHz.
pub(super) fn push(k: i64) -> f64 {
    let x = k as f64;
    let pulse = if (0..200).contains(&k) {
        30.0 * (std::f64::consts::PI * x / 200.0).sin()
    } else {
        0.0
    };
    pulse + 0.05 * (0.91 * x).sin() + 0.03 * (2.3 * x + 1.0).sin()
}

/// Sample `k` as files write it [g].
pub(super) fn g(k: i64) -> String {
    format!("{:.3}", push(k))
}

/// Time of sample `k` as files write it [s].
pub(super) fn s(k: i64) -> String {
    format!("{:.4}", k as f64 / 1e4)
}

/// How far the stamps of an irregular clock are off [µs]; its median step stays as it was.
pub(super) fn to_and_fro(k: i64) -> f64 {
    [0.0, 0.0, 5.0, 0.0, 0.0, -5.0][k.rem_euclid(6) as usize]
}

/// The numbers that the texts of all samples stand for.
pub(super) fn numbers(text: impl Fn(i64) -> String) -> Vec<f64> {
    (FROM..TO).map(|k| text(k).parse().unwrap()).collect()
}

/// A file with what must come out of it.
pub(super) struct Case {
    pub(super) name: String,
    pub(super) files: Vec<(String, Vec<u8>)>,
    /// Which of the files is opened; empty for their folder.
    pub(super) opened: String,
    pub(super) options: Vec<String>,
    pub(super) exit: i32,
    /// What is read; `None` where the file must be refused.
    pub(super) read: Option<Read>,
    /// Findings as `severity code`, in any order; those of the conditioning left aside.
    pub(super) findings: Vec<String>,
    /// Words that the message on stderr must hold.
    pub(super) says: Vec<String>,
}

/// What is read.
pub(super) struct Read {
    pub(super) channel: String,
    pub(super) unit: String,
    pub(super) rate_hz: f64,
    pub(super) start_s: f64,
    pub(super) samples: usize,
    /// The samples in `unit`; `None` where time was brought to a uniform clock.
    pub(super) values: Option<Vec<f64>>,
}

/// A file `name` that is read and passes: channel `acc_y_g` in g, until told otherwise.
pub(super) fn good(name: &str, bytes: impl Into<Vec<u8>>) -> Case {
    Case {
        name: name.into(),
        files: vec![(name.into(), bytes.into())],
        opened: name.into(),
        options: ["--opens-when", "negative"].map(String::from).to_vec(),
        exit: 0,
        read: Some(Read {
            channel: "acc_y_g".into(),
            unit: "g".into(),
            rate_hz: 10_000.0,
            start_s: -0.02,
            samples: (TO - FROM) as usize,
            values: Some(numbers(g)),
        }),
        findings: Vec::new(),
        says: Vec::new(),
    }
}

/// A file that is refused with a message that holds `says`.
pub(super) fn refused(name: &str, bytes: impl Into<Vec<u8>>, says: &[&str]) -> Case {
    Case {
        exit: 4,
        read: None,
        findings: vec!["blocking input-refused".into()],
        ..good(name, bytes)
    }
    .says(says)
}

impl Case {
    /// The other sign opens the lever.
    pub(super) fn positive_opens(mut self) -> Self {
        self.options[1] = "positive".into();
        self
    }

    /// Gives the case a name that says more than its file's.
    pub(super) fn named(mut self, name: &str) -> Self {
        self.name = name.into();
        self
    }

    pub(super) fn options(mut self, options: &[&str]) -> Self {
        self.options
            .extend(options.iter().map(|text| (*text).to_string()));
        self
    }

    /// Puts a further file beside the first.
    pub(super) fn beside(mut self, name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        self.files.push((name.into(), bytes.into()));
        self
    }

    pub(super) fn change(mut self, change: impl FnOnce(&mut Read)) -> Self {
        change(self.read.as_mut().expect("a file that is read"));
        self
    }

    pub(super) fn channel(self, name: &str) -> Self {
        self.change(|read| read.channel = name.into())
    }

    /// The unit, with the samples as their texts say in that unit.
    pub(super) fn unit(self, unit: &str, text: impl Fn(i64) -> String) -> Self {
        self.change(|read| {
            read.unit = unit.into();
            read.values = Some(numbers(text));
        })
    }

    pub(super) fn values(self, values: Vec<f64>) -> Self {
        self.change(|read| {
            read.samples = values.len();
            read.values = Some(values);
        })
    }

    /// As many samples of unstated value.
    pub(super) fn samples(self, samples: usize) -> Self {
        self.change(|read| {
            read.samples = samples;
            read.values = None;
        })
    }

    pub(super) fn clock(self, rate_hz: f64, start_s: f64) -> Self {
        self.change(|read| {
            read.rate_hz = rate_hz;
            read.start_s = start_s;
        })
    }

    pub(super) fn finds(mut self, findings: &[&str]) -> Self {
        self.findings
            .extend(findings.iter().map(|text| (*text).to_string()));
        self
    }

    /// A file that is read and cannot be judged, for a finding that blocks.
    pub(super) fn unusable(mut self, findings: &[&str], says: &[&str]) -> Self {
        self.exit = 4;
        assert!(findings.iter().any(|text| text.starts_with("blocking ")));
        self.finds(findings).says(says)
    }

    pub(super) fn says(mut self, words: &[&str]) -> Self {
        self.says
            .extend(words.iter().map(|text| (*text).to_string()));
        self
    }

    pub(super) fn exit(mut self, code: i32) -> Self {
        self.exit = code;
        self
    }
}
