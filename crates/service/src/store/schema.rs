//! The tables. Each row's body is JSON text under a hash, and the columns beside it serve searches; of a token or a
//! session the columns themselves are under the hash.

/// Version of the tables.
pub(super) const VERSION: i64 = 4;

/// Makes the tables.
pub(super) const TABLES: &str = "
CREATE TABLE IF NOT EXISTS recordings (
    number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, owner TEXT NOT NULL,
    bytes INTEGER NOT NULL, body TEXT NOT NULL, sum TEXT NOT NULL,
    listing TEXT, listing_sum TEXT,
    name TEXT NOT NULL DEFAULT '', created_ms INTEGER NOT NULL DEFAULT 0);
CREATE INDEX IF NOT EXISTS recordings_by_owner ON recordings (owner, bytes);
CREATE TABLE IF NOT EXISTS deletions (
    number INTEGER PRIMARY KEY AUTOINCREMENT, recording TEXT NOT NULL,
    body TEXT NOT NULL, sum TEXT NOT NULL, is_open INTEGER NOT NULL DEFAULT 1);
CREATE INDEX IF NOT EXISTS deletions_by_recording ON deletions (recording, number);
CREATE TABLE IF NOT EXISTS jobs (
    number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, owner TEXT NOT NULL,
    body TEXT NOT NULL, sum TEXT NOT NULL, state TEXT NOT NULL,
    attempt INTEGER NOT NULL DEFAULT 0, failures INTEGER NOT NULL DEFAULT 0,
    not_before_ms INTEGER NOT NULL DEFAULT 0, lease_ms INTEGER NOT NULL DEFAULT 0,
    answer TEXT, answer_sum TEXT, program TEXT);
CREATE INDEX IF NOT EXISTS jobs_open ON jobs (state, number);
CREATE INDEX IF NOT EXISTS jobs_by_owner ON jobs (owner, state);
CREATE TABLE IF NOT EXISTS results (
    number INTEGER PRIMARY KEY AUTOINCREMENT, report_id TEXT NOT NULL UNIQUE,
    recording TEXT NOT NULL, verdict TEXT NOT NULL, design TEXT NOT NULL, words TEXT NOT NULL,
    body TEXT NOT NULL, sum TEXT NOT NULL);
CREATE INDEX IF NOT EXISTS results_by_recording ON results (recording, number);
CREATE TABLE IF NOT EXISTS designs (
    name TEXT NOT NULL, version INTEGER NOT NULL, body TEXT NOT NULL, sum TEXT NOT NULL,
    owner TEXT NOT NULL DEFAULT '', is_deleted INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY (name, version));
CREATE TABLE IF NOT EXISTS gates (
    number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, name TEXT NOT NULL,
    body TEXT NOT NULL, sum TEXT NOT NULL, outcome TEXT, outcome_sum TEXT);
CREATE TABLE IF NOT EXISTS pairs (
    gate TEXT NOT NULL, number INTEGER NOT NULL, job TEXT NOT NULL,
    PRIMARY KEY (gate, number)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS tokens (
    number INTEGER PRIMARY KEY AUTOINCREMENT, sha256 TEXT NOT NULL UNIQUE, name TEXT NOT NULL,
    label TEXT NOT NULL DEFAULT '', scopes TEXT NOT NULL, created_ms INTEGER NOT NULL,
    ends_ms INTEGER, used_ms INTEGER, revoked INTEGER NOT NULL DEFAULT 0, sum TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS looked (number INTEGER PRIMARY KEY, at_ms INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS sessions (
    sha256 TEXT PRIMARY KEY, token INTEGER NOT NULL, created_ms INTEGER NOT NULL,
    seen_ms INTEGER NOT NULL, sum TEXT NOT NULL);
";

/// Changes data of version 2 to version 3, before [`FROM_3`].
pub(super) const FROM_2: &str = "
ALTER TABLE recordings ADD COLUMN name TEXT NOT NULL DEFAULT '';
ALTER TABLE recordings ADD COLUMN created_ms INTEGER NOT NULL DEFAULT 0;
UPDATE recordings SET name = coalesce(json_extract(body, '$.manifest.name'), ''),
    created_ms = coalesce(json_extract(body, '$.created_ms'), 0) WHERE json_valid(body);
ALTER TABLE designs ADD COLUMN owner TEXT NOT NULL DEFAULT '';
ALTER TABLE designs ADD COLUMN is_deleted INTEGER NOT NULL DEFAULT 0;
ALTER TABLE tokens RENAME TO tokens_2;
CREATE TABLE tokens (
    number INTEGER PRIMARY KEY AUTOINCREMENT, sha256 TEXT NOT NULL UNIQUE, name TEXT NOT NULL,
    label TEXT NOT NULL DEFAULT '', scopes TEXT NOT NULL, created_ms INTEGER NOT NULL,
    ends_ms INTEGER, used_ms INTEGER, revoked INTEGER NOT NULL DEFAULT 0);
INSERT INTO tokens (sha256, name, scopes, created_ms, revoked)
    SELECT sha256, name, scopes, created_ms, revoked FROM tokens_2 ORDER BY created_ms;
DROP TABLE tokens_2;
";

/// Changes data of version 3 to version 4, before [`TABLES`]. The tokens get their sums after it; sessions are short,
/// and people sign in again.
pub(super) const FROM_3: &str = "
ALTER TABLE tokens ADD COLUMN sum TEXT NOT NULL DEFAULT '';
DROP TABLE IF EXISTS sessions;
";
