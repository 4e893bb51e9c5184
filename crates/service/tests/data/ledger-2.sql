-- A ledger as version 2 of the tables wrote it; made by latchgate-serve 0.1.0 before version 3.
BEGIN TRANSACTION;
CREATE TABLE designs (
    name TEXT NOT NULL, version INTEGER NOT NULL, body TEXT NOT NULL, sum TEXT NOT NULL,
    PRIMARY KEY (name, version));
INSERT INTO "designs" VALUES('stiff',1,'{"name":"stiff","version":1,"design":{"criterion":{"threshold_rad":0.1},"input":{"bias_g":0.1,"scale":0.01},"lever":{"center_of_mass_m":0.065,"mass_kg":0.1475,"moment_of_inertia_kg_m2":0.0008888,"pivot_damping_nm_s_per_rad":0.000093,"preload_torque_nm":2.0,"spring_stiffness_nm_per_rad":0.37},"modified":[],"name":"stiff","stop":{"damping_n_s_per_m":133.59,"radius_m":0.1,"restitution":0.8,"stiffness_n_per_m":10000000.0},"tolerance":{"restitution":0.02}},"created_ms":1795743020095}','1520a3096b2d8e35cc85ed489d0020768abbf989cc964298d2fe10283b7859e2');
CREATE TABLE gates (
    number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, name TEXT NOT NULL,
    body TEXT NOT NULL, sum TEXT NOT NULL, outcome TEXT, outcome_sum TEXT);
CREATE TABLE jobs (
    number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, owner TEXT NOT NULL,
    body TEXT NOT NULL, sum TEXT NOT NULL, state TEXT NOT NULL,
    attempt INTEGER NOT NULL DEFAULT 0, failures INTEGER NOT NULL DEFAULT 0,
    not_before_ms INTEGER NOT NULL DEFAULT 0, lease_ms INTEGER NOT NULL DEFAULT 0,
    answer TEXT, answer_sum TEXT, program TEXT);
CREATE TABLE pairs (
    gate TEXT NOT NULL, number INTEGER NOT NULL, job TEXT NOT NULL,
    PRIMARY KEY (gate, number)) WITHOUT ROWID;
CREATE TABLE recordings (
    number INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE, owner TEXT NOT NULL,
    bytes INTEGER NOT NULL, body TEXT NOT NULL, sum TEXT NOT NULL,
    listing TEXT, listing_sum TEXT);
INSERT INTO "recordings" VALUES(1,'2265762696178a06f8397f9fb31a32f93dade1f36e0d670701606318e47228b7','lab',95029,'{"manifest":{"name":"burst.csv","files":[{"name":"burst.csv","sha256":"c1d9a73d45a997d68b700d13e5c45d70888af2340d6dbf43210edc2815698bd9","bytes":95029}],"card":null},"created_ms":1795743020065}','6123130a9f6bfa1a64b33b972d5a72541b8471273aec9ab7b83ac1e35c83eda3','{"candidates":[],"channel":"acceleration y (g)","channels":[{"content_sha256":"1c8bbb5e43d0cd701a339ee83d21f9de69af4125967b0eabdec3f165043ba6c4","end_s":0.25,"findings":[{"at_s":null,"code":"pre-event","severity":"info","text":"before the event, over 981 samples: bias -0.0011 g ± 0.0018 g (standard error), noise 0.0492 g rms"}],"name":"acceleration y (g)","peak":-999.5922,"peak_time_s":0.014049999999999993,"sample_rate_hz":20000.0,"samples":6001,"spark":"▅▅▅▅▅▆▁█▄▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅","start_s":-0.05,"stated":{"filter_class":null,"full_scale":null,"location":null,"prefilter_hz":null,"remarks":[],"status":null,"test":{"date":null,"laboratory":null,"location":null,"sensor":null,"speed":null,"test":null,"vehicle":null}},"status":"taken","unit":"g","unit_source":"header"}],"findings":[],"format":"csv","mapping":{"data_line":2,"decimal":".","header_line":1,"separator":"comma","time_column":"time (s)","time_unit":"s"},"preview":["time (s),acceleration y (g)","-0.05000,-0.0241","-0.04995,-0.0348","-0.04990,-0.0246","-0.04985,0.0936","-0.04980,0.0890","-0.04975,0.0179","-0.04970,0.1034","-0.04965,0.0122","-0.04960,0.0468","-0.04955,-0.0784","-0.04950,0.0180","-0.04945,0.0451","-0.04940,0.0408","-0.04935,0.0779","-0.04930,0.0318","-0.04925,0.0501","-0.04920,0.0082","-0.04915,0.0237","-0.04910,0.0151","-0.04905,-0.0045","-0.04900,-0.0099","-0.04895,0.0653","-0.04890,0.0430"],"reason":"it is the only channel","sha256":"c1d9a73d45a997d68b700d13e5c45d70888af2340d6dbf43210edc2815698bd9"}','d8177138207becc2e033b18b48c1a4916b3b506c2f3328e1f2667698cafa6a9a');
CREATE TABLE results (
    number INTEGER PRIMARY KEY AUTOINCREMENT, report_id TEXT NOT NULL UNIQUE,
    recording TEXT NOT NULL, verdict TEXT NOT NULL, design TEXT NOT NULL, words TEXT NOT NULL,
    body TEXT NOT NULL, sum TEXT NOT NULL);
CREATE TABLE tokens (
    sha256 TEXT PRIMARY KEY, name TEXT NOT NULL UNIQUE, scopes TEXT NOT NULL,
    created_ms INTEGER NOT NULL, revoked INTEGER NOT NULL DEFAULT 0);
INSERT INTO "tokens" VALUES('910c8a17d220cd58fe311665bd88f7e6ed76dfa6d298289cfd29479cd1f7bd36','lab','read,submit',1700000000000,0);
INSERT INTO "tokens" VALUES('0000000000000000000000000000000000000000000000000000000000000000','gone','read,submit',1700000000001,1);
CREATE INDEX recordings_by_owner ON recordings (owner, bytes);
CREATE INDEX jobs_open ON jobs (state, number);
CREATE INDEX jobs_by_owner ON jobs (owner, state);
CREATE INDEX results_by_recording ON results (recording, number);
COMMIT;
PRAGMA user_version = 2;
