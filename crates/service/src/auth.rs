//! Who may do what: tokens with scopes, compared in constant time.

use crate::store::{Ledger, StoreError, StoredToken, sha256_hex};
use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use subtle::{Choice, ConstantTimeEq};

/// What a token may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scope {
    /// Look at recordings, verdicts and designs.
    Read,
    /// Upload recordings and designs, ask questions.
    Submit,
    /// See what the service is doing.
    Admin,
}

impl Scope {
    /// Lists every scope.
    pub const ALL: [Self; 3] = [Self::Read, Self::Submit, Self::Admin];

    /// Returns the word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Submit => "submit",
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

    /// Shows it.
    pub fn reveal(&self) -> &str {
        &self.0
    }

    /// Returns its hash, which is what is stored.
    pub fn sha256(&self) -> String {
        sha256_hex(self.0.as_bytes())
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Secret(..)")
    }
}

/// Who asks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Visitor {
    /// Name of the token; `local` where no token exists.
    pub name: String,
    scopes: Vec<Scope>,
}

impl Visitor {
    /// Returns one who may do nothing that anybody is asked for.
    pub fn nobody() -> Self {
        Self {
            name: "nobody".into(),
            scopes: Vec::new(),
        }
    }

    /// Tells whether the visitor may do something.
    pub fn may(&self, scope: Scope) -> bool {
        self.scopes.contains(&scope)
    }
}

/// What came of a look at a token.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Seen {
    /// No token exists: whoever reaches the loopback may do everything.
    Open(Visitor),
    /// A token that is known.
    Known(Visitor),
    /// None, or one that is not known.
    Stranger,
}

/// Time for which the list of tokens is taken as read.
const FRESH: Duration = Duration::from_secs(1);

/// The tokens as they were last read.
#[derive(Debug, Default)]
pub struct Door {
    tokens: Mutex<Option<(Instant, Vec<StoredToken>)>>,
}

impl Door {
    /// Looks at the token that someone presents.
    ///
    /// # Errors
    ///
    /// [`StoreError`] if the tokens cannot be read; nobody is let in then.
    pub fn look(&self, ledger: &dyn Ledger, presented: Option<&str>) -> Result<Seen, StoreError> {
        let mut kept = locked(&self.tokens);
        let fresh = kept
            .as_ref()
            .is_some_and(|(read, _)| read.elapsed() < FRESH);
        if !fresh {
            *kept = Some((Instant::now(), ledger.tokens()?));
        }
        let tokens = kept.as_ref().map_or(&[][..], |(_, tokens)| tokens);
        if tokens.is_empty() {
            return Ok(Seen::Open(Visitor {
                name: "local".into(),
                scopes: Scope::ALL.to_vec(),
            }));
        }
        let found = presented.and_then(|presented| find(tokens, presented));
        Ok(found.map_or(Seen::Stranger, |token| {
            Seen::Known(Visitor {
                name: token.name.clone(),
                scopes: token.scopes.split(',').filter_map(Scope::of).collect(),
            })
        }))
    }
}

/// Finds a token; every one is compared to its end, whatever was found before.
fn find<'a>(tokens: &'a [StoredToken], presented: &str) -> Option<&'a StoredToken> {
    let presented = sha256_hex(presented.as_bytes());
    let mut found = None;
    for token in tokens {
        let same: Choice = token.sha256.as_bytes().ct_eq(presented.as_bytes());
        let held = same & Choice::from(u8::from(!token.revoked));
        if bool::from(held) {
            found = Some(token);
        }
    }
    found
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
