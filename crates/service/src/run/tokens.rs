//! Tokens: made, listed, made anew and taken back.

use super::say;
use crate::app::Store;
use crate::auth::{OF_PROXY, Scope, Secret};
use crate::clock::now_ms;
use crate::store::{Ledger, StoreError, StoredToken};
use clap::Subcommand;
use latchgate::pipeline::calendar::day;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

const DAY_MS: i64 = 86_400_000;

#[derive(Debug, Subcommand)]
pub(super) enum TokenCommand {
    /// Make a token and print it, this once
    Create {
        /// Who holds it; one person may have several
        name: String,
        /// What it may do: read, submit, delete, admin, with commas between
        #[arg(long, default_value = "read,submit")]
        scopes: String,
        /// What tells it from the holder's others, for example a computer's name
        #[arg(long, default_value = "")]
        label: String,
        /// Days after which it ends; 0 for never
        #[arg(long, default_value_t = 365)]
        days: u32,
    },
    /// List the tokens
    List,
    /// Make a token that takes the place of another: same holder, scopes, label and time
    Rotate {
        /// Who holds it, or which of the holder's: NAME#NUMBER
        token: String,
        /// Hours for which the other one lasts yet
        #[arg(long, default_value_t = 0)]
        keep_h: u32,
    },
    /// Take tokens back, at once, and end their sessions
    Revoke {
        /// Who holds them, or one alone: NAME#NUMBER
        token: String,
    },
}

pub(super) fn run(command: TokenCommand, data: &Path) -> Result<ExitCode, String> {
    if !matches!(command, TokenCommand::Create { .. }) {
        Store::is_there(data)?;
    }
    let is_new = Store::is_there(data).is_err();
    let ledger = Store::beside(data)?.ledger;
    let error_text = |error: StoreError| error.to_string();
    let now = now_ms();
    match command {
        TokenCommand::Create {
            name,
            scopes,
            label,
            days,
        } => {
            let unknown = scopes.split(',').find(|word| Scope::of(word).is_none());
            if let Some(word) = unknown {
                let names = Scope::ALL.map(Scope::name).join(", ");
                return Err(format!("unknown scope `{word}`; known: {names}"));
            }
            if name.is_empty() || name.contains(|c: char| c.is_control() || c == '#') {
                return Err("a name has letters, none of them `#`".into());
            }
            if name.ends_with(OF_PROXY) {
                return Err(format!(
                    "names that end with `{OF_PROXY}` are those of a proxy's users"
                ));
            }
            if label.contains(|c: char| c.is_control()) || label.chars().count() > 100 {
                return Err("a label has up to 100 letters, none of them for control".into());
            }
            if is_new {
                let shown = data.display();
                let _ = writeln!(
                    io::stderr(),
                    "latchgate-serve: {shown} held no data, they begin here"
                );
            }
            make(&*ledger, name, label, scopes, i64::from(days) * DAY_MS)
        }
        TokenCommand::List => {
            for token in ledger.tokens().map_err(error_text)? {
                say(line(&token, now))?;
            }
            Ok(ExitCode::SUCCESS)
        }
        TokenCommand::Rotate { token, keep_h } => {
            let tokens = valid(&*ledger, &token, now)?;
            let [old] = &tokens[..] else {
                let names: Vec<String> = tokens.iter().map(StoredToken::reference).collect();
                return Err(format!("`{token}` means {}; name one", names.join(", ")));
            };
            let lasts_ms = old.ends_ms.map_or(0, |end| end - old.created_ms);
            let (name, label) = (old.name.clone(), old.label.clone());
            let made = make(&*ledger, name, label, old.scopes.clone(), lasts_ms)?;
            let keeps = (keep_h > 0).then(|| now + i64::from(keep_h) * 3_600_000);
            ledger.end_token(old.number, keeps).map_err(error_text)?;
            Ok(made)
        }
        TokenCommand::Revoke { token } => {
            for token in valid(&*ledger, &token, now)? {
                ledger.end_token(token.number, None).map_err(error_text)?;
            }
            Ok(ExitCode::SUCCESS)
        }
    }
}

/// Makes a token and prints it; it ends after `lasts_ms`, or never if that is 0.
fn make(
    ledger: &dyn Ledger,
    name: String,
    label: String,
    scopes: String,
    lasts_ms: i64,
) -> Result<ExitCode, String> {
    let secret = Secret::draw().map_err(|error| error.to_string())?;
    let now = now_ms();
    let mut token = StoredToken {
        number: 0,
        sha256: secret.sha256(),
        name,
        label,
        scopes,
        created_ms: now,
        ends_ms: (lasts_ms > 0).then(|| now + lasts_ms),
        used_ms: None,
        revoked: false,
    };
    token.number = ledger
        .put_token(&token)
        .map_err(|error| error.to_string())?;
    say(secret.reveal())
}

/// Finds the valid tokens of a holder, or the one of a number.
fn valid(ledger: &dyn Ledger, reference: &str, now_ms: i64) -> Result<Vec<StoredToken>, String> {
    let tokens = ledger.tokens().map_err(|error| error.to_string())?;
    let is_meant = |token: &StoredToken| token.name == reference || token.reference() == reference;
    let valid: Vec<StoredToken> = tokens
        .into_iter()
        .filter(|token| token.is_valid(now_ms) && is_meant(token))
        .collect();
    if valid.is_empty() {
        return Err(format!(
            "there is no valid token `{reference}`; `latchgate-serve token list` lists all"
        ));
    }
    Ok(valid)
}

fn line(token: &StoredToken, now_ms: i64) -> String {
    let on = |ms: i64| day(ms.div_euclid(DAY_MS));
    let state = match token.ends_ms {
        _ if token.revoked => "revoked".to_string(),
        Some(end) if end <= now_ms => format!("ended {}", on(end)),
        Some(end) => format!("ends {}", on(end)),
        None => "without end".to_string(),
    };
    let used = token.used_ms.map_or("never used".into(), |used| {
        format!("last used {}", on(used))
    });
    let label = if token.label.is_empty() {
        String::new()
    } else {
        format!("  ({})", token.label)
    };
    let made = on(token.created_ms);
    format!(
        "{}{label}  {}  made {made}  {used}  {state}",
        token.reference(),
        token.scopes
    )
}
