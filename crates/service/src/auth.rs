//! Authorisation: tokens with scopes, compared in constant time.

use crate::audit;
use crate::clock::now_ms;
use crate::store::{Ledger, StoreError, StoredSession, StoredToken, sha256_hex};
use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use subtle::{Choice, ConstantTimeEq};

/// A right that a token grants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scope {
    /// Look at recordings, verdicts and designs.
    Read,
    /// Upload recordings and designs; with `Read`, ask questions.
    Submit,
    /// Delete recordings and designs.
    Delete,
    /// See the state of the service.
    Admin,
}

impl Scope {
    /// Lists every scope.
    pub const ALL: [Self; 4] = [Self::Read, Self::Submit, Self::Delete, Self::Admin];

    /// Returns the word of the scope.
    pub fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Submit => "submit",
            Self::Delete => "delete",
            Self::Admin => "admin",
        }
    }

    /// Finds the scope of a word.
    pub fn of(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scope| scope.name() == word)
    }
}

/// A token, shown once and kept nowhere.
pub struct Secret(String);

impl Secret {
    /// Draws a token of 256 random bits.
    ///
    /// # Errors
    ///
    /// [`getrandom::Error`] if the system has no random numbers.
    pub fn draw() -> Result<Self, getrandom::Error> {
        let mut bits = [0; 32];
        getrandom::fill(&mut bits)?;
        Ok(Self(format!("lg_{}", crate::store::Hex(&bits))))
    }

    /// Returns the token.
    pub fn reveal(&self) -> &str {
        &self.0
    }

    /// Returns its hash, which is stored in its place.
    pub fn sha256(&self) -> String {
        sha256_hex(self.0.as_bytes())
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret(..)")
    }
}

/// Way of a visitor's authentication.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// None.
    Nobody,
    /// None needed: no token exists.
    Open,
    /// A token, or a session of it.
    Token,
    /// A name given by a proxy.
    Proxy,
}

/// End of the name of a user whom a proxy names; no token's holder has such a name. So the two are never one owner.
pub const OF_PROXY: &str = "@proxy";

/// Name of a visitor where no token exists: nobody is known.
pub const NOBODY: &str = "local";

/// The sender of a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Visitor {
    /// Name of the token's holder, or of a proxy's user with [`OF_PROXY`]; [`NOBODY`] where no token exists.
    pub name: String,
    scopes: Vec<Scope>,
    /// Number of the token.
    pub token: Option<i64>,
    /// How the visitor came in.
    pub way: Way,
    /// Address at which a user of a proxy signs out; empty if unknown.
    pub sign_out: String,
}

impl Visitor {
    /// Returns a visitor without any scope.
    pub fn nobody() -> Self {
        Self {
            name: "nobody".into(),
            scopes: Vec::new(),
            token: None,
            way: Way::Nobody,
            sign_out: String::new(),
        }
    }

    /// Returns the user that a proxy names.
    pub fn of_proxy(name: &str, scopes: Vec<Scope>, sign_out: &str) -> Self {
        Self {
            name: format!("{name}{OF_PROXY}"),
            scopes,
            token: None,
            way: Way::Proxy,
            sign_out: sign_out.into(),
        }
    }

    /// Returns true if the visitor has a scope.
    pub fn may(&self, scope: Scope) -> bool {
        self.scopes.contains(&scope)
    }
}

/// Credential of a request.
#[derive(Debug, Clone)]
pub enum Presented {
    /// A token.
    Token(String),
    /// The secret of a session, from the cookie.
    Session(String),
}

/// Result of checking a credential.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Recognition {
    /// No token exists, so whoever is at the machine may do everything; the guard decides who is.
    Open(Visitor),
    /// A valid token or session.
    Known(Visitor),
    /// No credential, or an unknown one.
    Stranger,
}

/// Time for which the cached tokens and sessions are used.
const FRESH: Duration = Duration::from_secs(1);

/// Time after which another use of a token or a session is written down [ms].
const NOTED_MS: i64 = 5 * 60_000;

/// Tokens and sessions as last read from the ledger.
#[derive(Debug, Default)]
struct TokenCache {
    /// Instant of that; `None` if they must be read again.
    read: Option<Instant>,
    /// What [`Ledger::change`] said before that.
    change: Option<i64>,
    tokens: Vec<StoredToken>,
    sessions: Vec<StoredSession>,
}

impl TokenCache {
    fn read_again(&mut self, ledger: &dyn Ledger) -> Result<(), StoreError> {
        // Before the tokens, so that a token which comes between the two is a change.
        let change = ledger.change()?;
        let tokens = ledger.tokens()?;
        if self.read.is_some() || !self.tokens.is_empty() {
            tell_changes(&self.tokens, &tokens);
        }
        self.tokens = tokens;
        self.sessions = ledger.sessions()?;
        self.change = Some(change);
        self.read = Some(Instant::now());
        Ok(())
    }
}

/// Lifetimes of a session.
#[derive(Debug, Clone, Copy)]
pub struct SessionTimes {
    /// Lifetime without use [ms].
    pub idle_ms: i64,
    /// Lifetime in total [ms].
    pub whole_ms: i64,
}

/// Checks credentials against cached tokens and sessions.
#[derive(Debug)]
pub struct Door {
    times: SessionTimes,
    cache: Mutex<TokenCache>,
}

impl Door {
    /// Returns a door with an empty cache.
    pub fn new(times: SessionTimes) -> Self {
        Self {
            times,
            cache: Mutex::default(),
        }
    }

    /// Checks a credential; reads tokens and sessions again if the cache is old.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if tokens or sessions cannot be read; no visitor is admitted then.
    pub fn look(
        &self,
        ledger: &dyn Ledger,
        presented: Option<&Presented>,
    ) -> Result<Recognition, StoreError> {
        let mut cache = locked(&self.cache);
        if cache.read.is_none_or(|read| read.elapsed() >= FRESH) {
            cache.read_again(ledger)?;
        }
        let recognition = self.recognise(Some(ledger), presented, &mut cache);
        Ok(recognition.unwrap_or(Recognition::Stranger))
    }

    /// Checks a credential that the cache does not know, so that a new token works at once: reads tokens and sessions
    /// again if anything was written since. A stranger's guesses therefore cost at most one reading for each commit.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if tokens or sessions cannot be read; no visitor is admitted then.
    pub fn look_anew(
        &self,
        ledger: &dyn Ledger,
        presented: &Presented,
    ) -> Result<Recognition, StoreError> {
        let mut cache = locked(&self.cache);
        if cache.read.is_none() || cache.change != Some(ledger.change()?) {
            cache.read_again(ledger)?;
        }
        let recognition = self.recognise(Some(ledger), Some(presented), &mut cache);
        Ok(recognition.unwrap_or(Recognition::Stranger))
    }

    /// Checks a credential without the disk; `None` if the cache is old or a use must be written down.
    pub fn look_again(&self, presented: Option<&Presented>) -> Option<Recognition> {
        let mut cache = self.cache.try_lock().ok()?;
        cache.read.filter(|read| read.elapsed() < FRESH)?;
        self.recognise(None, presented, &mut cache)
    }

    /// Checks a credential against the cache; `None` if a use must be written down and `ledger` is absent.
    fn recognise(
        &self,
        ledger: Option<&dyn Ledger>,
        presented: Option<&Presented>,
        cache: &mut TokenCache,
    ) -> Option<Recognition> {
        if cache.tokens.is_empty() {
            return Some(Recognition::Open(Visitor {
                name: NOBODY.into(),
                scopes: Scope::ALL.to_vec(),
                token: None,
                way: Way::Open,
                sign_out: String::new(),
            }));
        }
        let now = now_ms();
        let number = match presented {
            None => return Some(Recognition::Stranger),
            Some(Presented::Token(token)) => {
                let hashes = cache.tokens.iter().map(|stored| stored.sha256.as_str());
                matching_hash(hashes, token).map(|index| cache.tokens[index].number)
            }
            Some(Presented::Session(session)) => {
                let hashes = cache.sessions.iter().map(|stored| stored.sha256.as_str());
                match matching_hash(hashes, session) {
                    Some(index) if self.lasts(&cache.sessions[index], now) => {
                        let session = &mut cache.sessions[index];
                        if now - session.seen_ms > NOTED_MS {
                            let ledger = ledger?;
                            session.seen_ms = now;
                            noted(ledger.put_session(session));
                        }
                        Some(session.token)
                    }
                    _ => None,
                }
            }
        };
        let valid = |token: &&mut StoredToken| Some(token.number) == number && token.is_valid(now);
        let Some(token) = cache.tokens.iter_mut().find(valid) else {
            return Some(Recognition::Stranger);
        };
        if token.used_ms.is_none_or(|used| now - used > NOTED_MS) {
            let ledger = ledger?;
            token.used_ms = Some(now);
            noted(ledger.used_token(token.number, now));
        }
        Some(Recognition::Known(Visitor {
            name: token.name.clone(),
            scopes: token.scopes.split(',').filter_map(Scope::of).collect(),
            token: Some(token.number),
            way: Way::Token,
            sign_out: String::new(),
        }))
    }

    fn lasts(&self, session: &StoredSession, now_ms: i64) -> bool {
        now_ms - session.seen_ms < self.times.idle_ms
            && now_ms - session.created_ms < self.times.whole_ms
    }

    /// Begins a session with a token; returns the secret for the cookie.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if it cannot be kept.
    pub fn sign_in(&self, ledger: &dyn Ledger, token: i64) -> Result<Secret, StoreError> {
        let broken = |error: getrandom::Error| StoreError::Broken {
            reason: error.to_string(),
        };
        let (secret, now) = (Secret::draw().map_err(broken)?, now_ms());
        for session in ledger.sessions()? {
            if !self.lasts(&session, now) {
                ledger.end_session(&session.sha256)?;
            }
        }
        ledger.put_session(&StoredSession {
            sha256: secret.sha256(),
            token,
            created_ms: now,
            seen_ms: now,
        })?;
        locked(&self.cache).read = None;
        Ok(secret)
    }

    /// Ends every session of a token.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if that cannot be written.
    pub fn sign_out_everywhere(&self, ledger: &dyn Ledger, token: i64) -> Result<(), StoreError> {
        for session in ledger.sessions()? {
            if session.token == token {
                ledger.end_session(&session.sha256)?;
            }
        }
        locked(&self.cache).read = None;
        Ok(())
    }

    /// Ends a session.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if that cannot be written.
    pub fn sign_out(&self, ledger: &dyn Ledger, session: &str) -> Result<(), StoreError> {
        ledger.end_session(&sha256_hex(session.as_bytes()))?;
        locked(&self.cache).read = None;
        Ok(())
    }
}

/// Logs a use that could not be written down. It is no reason to refuse: on a full disk people can still read.
fn noted(outcome: Result<(), StoreError>) {
    if let Err(error) = outcome {
        tracing::warn!(%error, "the use of a token or a session was not noted");
    }
}

/// Records in the audit log which tokens were made and revoked since the last reading. The command line did it,
/// and its process has a log of its own.
fn tell_changes(before: &[StoredToken], now: &[StoredToken]) {
    for token in now {
        let earlier = before.iter().find(|earlier| earlier.number == token.number);
        let what = match earlier {
            None => "token made",
            Some(earlier) if token.revoked && !earlier.revoked => "token taken back",
            Some(earlier) if token.ends_ms != earlier.ends_ms => "token ends otherwise",
            Some(_) => continue,
        };
        audit::record(what, &token.reference(), "operator", "the command line");
    }
}

/// Returns the index of the hash of a secret.
fn matching_hash<'a>(hashes: impl Iterator<Item = &'a str>, presented: &str) -> Option<usize> {
    let presented = sha256_hex(presented.as_bytes());
    matching_secret(hashes.map(str::as_bytes), presented.as_bytes())
}

/// Returns the index of a secret among those stored, the last one if it is there twice. All are compared, each in
/// constant time, so that the time tells nothing. The bound lets them be compared in no other way.
pub fn matching_secret<'a, S: ConstantTimeEq + ?Sized + 'a>(
    stored: impl Iterator<Item = &'a S>,
    presented: &S,
) -> Option<usize> {
    let mut matching = None;
    for (index, secret) in stored.enumerate() {
        let is_same: Choice = secret.ct_eq(presented);
        if bool::from(is_same) {
            matching = Some(index);
        }
    }
    matching
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
