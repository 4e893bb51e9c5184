//! The configuration: defaults, a file, the environment, the command line, in this order; each
//! value knows where it comes from.

use crate::auth::Scope;
use axum::http::HeaderName;
use std::collections::BTreeMap;
use std::fmt;
use std::net::AddrParseError;
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A key of the configuration.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Its name, in files; in the environment it is `LATCHGATE_SERVE_` and the name in capitals.
    pub name: &'static str,
    /// Its value unless stated.
    pub default: &'static str,
    /// Its description.
    pub meaning: &'static str,
}

const fn key(name: &'static str, default: &'static str, meaning: &'static str) -> Key {
    Key {
        name,
        default,
        meaning,
    }
}

/// Every key.
pub const KEYS: &[Key] = &[
    key(
        "listen",
        "127.0.0.1:8420",
        "Address and port, or unix: and the path of a socket; port 0 takes a free one. Beyond the loopback only once a token exists, or `user_header` is stated.",
    ),
    key(
        "user_header",
        "",
        "Header in which a proxy names the user who signed in there; taken from the socket and from `proxies` alone. None unless stated.",
    ),
    key(
        "user_scopes",
        "read,submit",
        "What a user may do whom the proxy names.",
    ),
    key(
        "sign_out_url",
        "",
        "Where such a user signs out, for example /oauth2/sign_out.",
    ),
    key(
        "data",
        "",
        "Folder of the data; $XDG_STATE_HOME/latchgate or ~/.local/state/latchgate unless stated.",
    ),
    key(
        "proxies",
        "",
        "Addresses of proxies, with commas between: they may hold every connection, and are believed for whom they ask. Only once a token exists, or `user_header` is stated.",
    ),
    key(
        "without_jail",
        "false",
        "Start where the kernel does not give the whole jail.",
    ),
    key(
        "places",
        "0",
        "Children that work on jobs, the first on nothing else; 0 takes one for each core. One more is for people who wait.",
    ),
    key(
        "child_memory_mib",
        "1024",
        "Memory that a child may map [MiB].",
    ),
    key(
        "order_s",
        "120",
        "Time that one question may take [s], and its processor time.",
    ),
    key(
        "silence_s",
        "25",
        "Time that a child may say nothing while it works [s]; below 30.",
    ),
    key(
        "answer_mib",
        "256",
        "Bytes of the files of one report [MiB].",
    ),
    key("upload_mib", "192", "Bytes of one upload [MiB]."),
    key("upload_files", "512", "Files of one upload."),
    key(
        "body_s",
        "30",
        "Time in which some more of a body must come [s].",
    ),
    key("upload_s", "600", "Time that an upload may take [s]."),
    key(
        "header_s",
        "10",
        "Time in which the head of a request must come, and for which a connection may be idle [s].",
    ),
    key(
        "session_h",
        "168",
        "Time after which somebody who signed in must do so again [h].",
    ),
    key(
        "session_idle_h",
        "12",
        "Time without a request after which the same holds [h].",
    ),
    key(
        "keep_days",
        "0",
        "Age at which recordings are deleted [days]; 0 keeps them.",
    ),
    key(
        "upkeep_s",
        "3600",
        "Time between two looks for what is to be deleted by age, or that no row names [s].",
    ),
    key(
        "own_designs",
        "1000",
        "Designs, each version counted, that one token may keep.",
    ),
    key(
        "question_s",
        "10",
        "Time in which the whole body of a request must come that is no upload [s].",
    ),
    key("connections", "1024", "Connections at a time."),
    key(
        "address_connections",
        "128",
        "Connections of one address at a time, of IPv6 of its first 64 bits; `proxies` have no such bound.",
    ),
    key("queue", "200000", "Jobs that may wait."),
    key(
        "own_queue",
        "100000",
        "Jobs of one token that may wait or run.",
    ),
    key(
        "own_mib",
        "102400",
        "Bytes that one token may upload in all [MiB].",
    ),
    key(
        "gate_pairs",
        "10000",
        "Pairs of a recording and a design that one gate may have.",
    ),
    key(
        "gate_rules",
        "1000",
        "Requirements and exceptions that one gate may have.",
    ),
    key(
        "rate_per_s",
        "200",
        "Requests of one token per second, on average; without a token, of one address.",
    ),
    key(
        "rate_burst",
        "1000",
        "Requests of one token at once; without a token, of one address.",
    ),
    key(
        "free_mib",
        "256",
        "Space that uploads and jobs leave free on the disk [MiB].",
    ),
    key(
        "wait_s",
        "2",
        "Time for which a question waits for its answer before it becomes a job [s].",
    ),
    key(
        "drain_s",
        "60",
        "Time that work under way gets at the end [s].",
    ),
    key(
        "log",
        "info",
        "Least level that is logged: error, warn, info, debug or trace.",
    ),
    key("log_format", "json", "json or text."),
];

/// Returns the description of a key.
pub fn meaning(name: &str) -> &'static str {
    let key = KEYS.iter().find(|key| key.name == name);
    key.map_or("", |key| key.meaning)
}

/// Origin of a value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// The default.
    Default,
    /// A file.
    File(PathBuf),
    /// The environment.
    Environment(String),
    /// The command line.
    Flag,
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Default => f.write_str("default"),
            Self::File(path) => write!(f, "file {}", path.display()),
            Self::Environment(name) => write!(f, "environment {name}"),
            Self::Flag => f.write_str("command line"),
        }
    }
}

/// Values with their origins.
#[derive(Debug, Clone)]
pub struct Layers(BTreeMap<&'static str, (String, Origin)>);

impl Layers {
    /// Combines the layers.
    ///
    /// # Errors
    ///
    /// The mistake, in a sentence: an unknown key, a file that cannot be read.
    pub fn gather(
        file: Option<&Path>,
        environment: impl Iterator<Item = (String, String)>,
        flags: &[(String, String)],
    ) -> Result<Self, String> {
        let defaults = KEYS.iter();
        let mut layers = Self(
            defaults
                .map(|key| (key.name, (key.default.to_string(), Origin::Default)))
                .collect(),
        );
        if let Some(path) = file {
            let shown = path.display();
            let text =
                std::fs::read_to_string(path).map_err(|error| format!("{shown}: {error}"))?;
            let table: toml::Table =
                toml::from_str(&text).map_err(|error| format!("{shown}: {}", error.message()))?;
            for (name, value) in table {
                let value = match value {
                    toml::Value::String(text) => text,
                    toml::Value::Integer(number) => number.to_string(),
                    toml::Value::Boolean(word) => word.to_string(),
                    _ => {
                        return Err(format!(
                            "{shown}: `{name}` must be a text, a whole number or true or false"
                        ));
                    }
                };
                let origin = Origin::File(path.to_path_buf());
                layers
                    .put(&name, value, origin)
                    .map_err(|error| format!("{shown}: {error}"))?;
            }
        }
        for (name, value) in environment {
            let Some(key_name) = name.strip_prefix("LATCHGATE_SERVE_") else {
                continue;
            };
            let key_name = key_name.to_lowercase();
            if key_name == "config" {
                continue;
            }
            let origin = Origin::Environment(name.clone());
            layers
                .put(&key_name, value, origin)
                .map_err(|error| format!("{name}: {error}"))?;
        }
        for (name, value) in flags {
            layers.put(name, value.clone(), Origin::Flag)?;
        }
        layers.find_places();
        Ok(layers)
    }

    /// Sets the default places, so that `config show` shows the values in use.
    fn find_places(&mut self) {
        if self.text("data").is_empty()
            && let Some((data, from)) = default_data()
        {
            let value = (data.display().to_string(), Origin::Environment(from.into()));
            self.0.insert("data", value);
        }
    }

    fn put(&mut self, name: &str, value: String, origin: Origin) -> Result<(), String> {
        let Some(key) = KEYS.iter().find(|key| key.name == name) else {
            let names: Vec<&str> = KEYS.iter().map(|key| key.name).collect();
            return Err(format!("unknown key `{name}`; known: {}", names.join(", ")));
        };
        self.0.insert(key.name, (value, origin));
        Ok(())
    }

    /// Lists each key with its value and its origin.
    pub fn entries(&self) -> impl Iterator<Item = (&'static str, &str, &Origin)> {
        KEYS.iter().filter_map(|key| {
            let (value, origin) = self.0.get(key.name)?;
            Some((key.name, value.as_str(), origin))
        })
    }

    fn text(&self, name: &str) -> &str {
        self.0.get(name).map_or("", |(value, _)| value.as_str())
    }

    fn value<T: std::str::FromStr>(&self, name: &str, what: &str) -> Result<T, String> {
        let text = self.text(name);
        text.parse()
            .map_err(|_| format!("`{name}` must be {what}, found `{text}`"))
    }

    /// Returns a whole number within bounds.
    fn number(&self, name: &str, min: u64, max: u64) -> Result<u64, String> {
        let what = format!("a whole number from {min} to {max}");
        let number: u64 = self.value(name, &what)?;
        if (min..=max).contains(&number) {
            Ok(number)
        } else {
            Err(format!("`{name}` must be {what}, found {number}"))
        }
    }

    fn seconds(&self, name: &str, max: u64) -> Result<Duration, String> {
        Ok(Duration::from_secs(self.number(name, 1, max)?))
    }

    fn hours(&self, name: &str, max: u64) -> Result<Duration, String> {
        Ok(Duration::from_secs(self.number(name, 1, max)? * 3600))
    }

    fn mebibytes(&self, name: &str, max: u64) -> Result<u64, String> {
        Ok(self.number(name, 1, max)? << 20)
    }
}

/// Where requests come in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Listen {
    /// An address with a port.
    Tcp(SocketAddr),
    /// A socket in the file system.
    Unix(PathBuf),
}

impl Listen {
    /// Returns true if only this machine can connect, and no other machine by way of a proxy.
    pub fn is_private(&self) -> bool {
        matches!(self, Self::Tcp(address) if address.ip().is_loopback())
    }
}

impl std::str::FromStr for Listen {
    type Err = AddrParseError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text.strip_prefix("unix:") {
            Some(path) => Ok(Self::Unix(path.into())),
            None => text.parse().map(Self::Tcp),
        }
    }
}

impl fmt::Display for Listen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(address) => address.fmt(f),
            Self::Unix(path) => write!(f, "unix:{}", path.display()),
        }
    }
}

/// Users whom a proxy names.
#[derive(Debug, Clone)]
pub struct ProxyUsers {
    /// The header.
    pub header: HeaderName,
    /// What they may do.
    pub scopes: Vec<Scope>,
    /// Address at which they sign out; empty if not stated.
    pub sign_out_url: String,
}

fn users(layers: &Layers) -> Result<Option<ProxyUsers>, String> {
    if layers.text("user_header").is_empty() {
        return Ok(None);
    }
    let words = layers.text("user_scopes").split(',').map(str::trim);
    let scopes = words.map(|word| {
        let names = Scope::ALL.map(Scope::name).join(", ");
        Scope::of(word).ok_or_else(|| format!("`user_scopes` takes {names}, found `{word}`"))
    });
    Ok(Some(ProxyUsers {
        header: layers.value("user_header", "the name of a header")?,
        scopes: scopes.collect::<Result<_, _>>()?,
        sign_out_url: layers.text("sign_out_url").into(),
    }))
}

/// The configuration, checked.
#[derive(Debug, Clone)]
pub struct Config {
    /// Where requests come in.
    pub listen: Listen,
    /// Users whom a proxy names.
    pub users: Option<ProxyUsers>,
    /// Folder of the data.
    pub data: PathBuf,
    /// Addresses of proxies whose headers on the client are trusted.
    pub proxies: Vec<IpAddr>,
    /// True if children work in an incomplete jail.
    pub without_jail: bool,
    /// Children that work on jobs.
    pub places: usize,
    /// Memory that a child may map [bytes].
    pub child_memory_bytes: u64,
    /// Time that one question may take.
    pub order_time: Duration,
    /// Longest silence of a child.
    pub silence: Duration,
    /// Bytes of the files of one report.
    pub answer_bytes: u64,
    /// Bytes of one upload.
    pub upload_bytes: u64,
    /// Files of one upload.
    pub upload_files: usize,
    /// Time in which some more of a body must come.
    pub body_time: Duration,
    /// Time that an upload may take.
    pub upload_time: Duration,
    /// Time in which the head of a request must come.
    pub header_time: Duration,
    /// Time after which somebody who signed in must do so again.
    pub session: Duration,
    /// Time without a request after which the same holds.
    pub session_idle: Duration,
    /// Age at which recordings are deleted.
    pub keep: Option<Duration>,
    /// Time between two looks for what is to be removed.
    pub upkeep: Duration,
    /// Designs that one token may keep.
    pub own_designs: u64,
    /// Time in which the whole body of a request must come that is no upload.
    pub question_time: Duration,
    /// Connections at a time.
    pub connections: usize,
    /// Connections of one address at a time.
    pub address_connections: usize,
    /// Jobs that may wait.
    pub queue: u64,
    /// Jobs of one token that may wait or run.
    pub own_queue: u64,
    /// Bytes that one token may upload.
    pub own_bytes: u64,
    /// Pairs of one gate.
    pub gate_pairs: u64,
    /// Requirements and exceptions of one gate.
    pub gate_rules: u64,
    /// Requests of one token per second.
    pub rate_per_s: u64,
    /// Requests of one token at once.
    pub rate_burst: u64,
    /// Space that is left free [bytes].
    pub free_bytes: u64,
    /// Time for which a question waits for its answer.
    pub wait: Duration,
    /// Time that work under way gets at the end.
    pub drain: Duration,
    /// Least level that is logged.
    pub log: tracing::Level,
    /// True if logs are JSON lines.
    pub log_json: bool,
}

impl Config {
    /// Checks every value.
    ///
    /// # Errors
    ///
    /// The first mistake, in a sentence.
    pub fn of(layers: &Layers) -> Result<Self, String> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let data = match layers.text("data") {
            "" => return Err("no folder for the data: state `data`".into()),
            stated => PathBuf::from(stated),
        };
        Ok(Self {
            listen: layers.value(
                "listen",
                "an address and a port, for example 127.0.0.1:8420, or unix:/path/of/a/socket",
            )?,
            users: users(layers)?,
            data,
            proxies: proxies(layers)?,
            without_jail: layers.value("without_jail", "true or false")?,
            places: match layers.number("places", 0, 1024)? {
                0 => cores,
                stated => usize::try_from(stated).unwrap_or(cores),
            },
            child_memory_bytes: layers.number("child_memory_mib", 64, 1 << 20)? << 20,
            order_time: layers.seconds("order_s", 86_400)?,
            silence: layers.seconds("silence_s", 29)?,
            answer_bytes: layers.mebibytes("answer_mib", 1 << 20)?,
            upload_bytes: layers.mebibytes("upload_mib", 1 << 20)?,
            upload_files: usize::try_from(layers.number("upload_files", 1, 100_000)?).unwrap_or(1),
            body_time: layers.seconds("body_s", 3600)?,
            upload_time: layers.seconds("upload_s", 86_400)?,
            header_time: layers.seconds("header_s", 3600)?,
            session: layers.hours("session_h", 24 * 366)?,
            session_idle: layers.hours("session_idle_h", 24 * 366)?,
            keep: match layers.number("keep_days", 0, 36_500)? {
                0 => None,
                days => Some(Duration::from_secs(days * 86_400)),
            },
            upkeep: layers.seconds("upkeep_s", 86_400)?,
            own_designs: layers.number("own_designs", 1, 1 << 40)?,
            question_time: layers.seconds("question_s", 3600)?,
            address_connections: usize::try_from(layers.number(
                "address_connections",
                1,
                1 << 20,
            )?)
            .unwrap_or(1),
            connections: usize::try_from(layers.number("connections", 1, 1 << 20)?).unwrap_or(1),
            queue: layers.number("queue", 1, 1 << 40)?,
            own_queue: layers.number("own_queue", 1, 1 << 40)?,
            own_bytes: layers.mebibytes("own_mib", 1 << 40)?,
            gate_pairs: layers.number("gate_pairs", 1, 1 << 20)?,
            gate_rules: layers.number("gate_rules", 1, 1 << 20)?,
            rate_per_s: layers.number("rate_per_s", 1, 1 << 32)?,
            rate_burst: layers.number("rate_burst", 1, 1 << 32)?,
            free_bytes: layers.number("free_mib", 0, 1 << 40)? << 20,
            wait: Duration::from_secs(layers.number("wait_s", 0, 60)?),
            drain: layers.seconds("drain_s", 86_400)?,
            log: layers.value("log", "error, warn, info, debug or trace")?,
            log_json: match layers.text("log_format") {
                "json" => true,
                "text" => false,
                other => {
                    return Err(format!(
                        "`log_format` must be json or text, found `{other}`"
                    ));
                }
            },
        })
    }
}

fn proxies(layers: &Layers) -> Result<Vec<IpAddr>, String> {
    let words = layers.text("proxies").split(',').map(str::trim);
    let addresses = words.filter(|word| !word.is_empty()).map(|word| {
        let address = word.parse::<IpAddr>();
        let message = |_| format!("`proxies` takes addresses with commas between, found `{word}`");
        address
            .map(|address| address.to_canonical())
            .map_err(message)
    });
    addresses.collect()
}

/// Returns the default folder of the data, and the environment variable that it comes from.
fn default_data() -> Option<(PathBuf, &'static str)> {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    let places = [
        ("XDG_STATE_HOME", "latchgate"),
        ("HOME", ".local/state/latchgate"),
    ];
    let mut dirs = places
        .into_iter()
        .filter_map(|(name, below)| Some((PathBuf::from(set(name)?).join(below), name)));
    dirs.next()
}
