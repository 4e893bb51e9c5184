//! The tables. Each row's body is JSON text under a hash; the columns beside it serve searches.

/// Version of the tables.
pub(super) const VERSION: i64 = 2;

/// Makes the tables.
pub(super) const TABLES: &str = "
CREATE TABLE IF NOT EXISTS recordings (
    number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, owner TEXT NOT NULL,
    bytes INTEGER NOT NULL, body TEXT NOT NULL, sum TEXT NOT NULL,
    listing TEXT, listing_sum TEXT);
CREATE INDEX IF NOT EXISTS recordings_by_owner ON recordings (owner, bytes);
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
    PRIMARY KEY (name, version));
CREATE TABLE IF NOT EXISTS gates (
    number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, name TEXT NOT NULL,
    body TEXT NOT NULL, sum TEXT NOT NULL, outcome TEXT, outcome_sum TEXT);
CREATE TABLE IF NOT EXISTS pairs (
    gate TEXT NOT NULL, number INTEGER NOT NULL, job TEXT NOT NULL,
    PRIMARY KEY (gate, number)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS tokens (
    sha256 TEXT PRIMARY KEY, name TEXT NOT NULL UNIQUE, scopes TEXT NOT NULL,
    created_ms INTEGER NOT NULL, revoked INTEGER NOT NULL DEFAULT 0);
";
