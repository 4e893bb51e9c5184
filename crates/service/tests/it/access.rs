//! Who may do what.

use crate::support::{Folder, HANG, Service, let_the_tokens_age, signal, wait_for};
use latchgate_service::auth::{Door, Presented, Recognition, Scope, SessionTimes, matching_secret};
use latchgate_service::http::declared;
use latchgate_service::store::{Ledger, SqliteLedger, StoredToken};
use serde_json::{Value, json};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::fs;
use std::time::{Duration, Instant};
use subtle::{Choice, ConstantTimeEq};

/// Fills a route's path in.
fn path_of(route: &str) -> String {
    route
        .replace("{file}", "report.html")
        .replace("{name}", "app.js")
        .replace("{id}", &"0".repeat(64))
        .replace("{report_id}", &"0".repeat(64))
}

/// Every route is declared with what it needs, and each token may do what its scopes say.
#[test]
fn cli_every_route_asks_for_its_scope() {
    let folder = Folder::new();
    let tokens: Vec<(Scope, String)> = Scope::ALL
        .into_iter()
        .map(|scope| (scope, folder.token(scope.name(), scope.name())))
        .collect();
    let service = Service::start(&folder, &[]);
    for (method, route, needs) in declared() {
        let path = path_of(route);
        let asked = |token: Option<&str>| {
            let client = match token {
                Some(token) => service.client().bearer(token),
                None => service.client(),
            };
            client.send(method, &path, &[]).status
        };
        let Some(needs) = needs else {
            // Whoever signs in with no token at all is told so.
            let status = asked(None);
            let signs_in = (method, route) == ("POST", "/login");
            assert!(
                status != 403 && (status != 401 || signs_in),
                "{method} {route}"
            );
            continue;
        };
        assert_eq!(asked(None), 401, "{method} {route} without a token");
        assert_eq!(
            asked(Some("lg_0")),
            401,
            "{method} {route} with another token"
        );
        for (scope, token) in &tokens {
            let status = asked(Some(token));
            assert!(status < 500, "{method} {route}: {status}");
            assert_eq!(
                status == 403,
                needs.iter().any(|needed| needed != scope),
                "{method} {route} with {scope:?}: {status}"
            );
        }
    }
}

/// The description lists no route that is not declared, and the other way round.
#[test]
fn tidy_every_described_route_is_declared() {
    let description: Value = serde_json::from_str(&latchgate_service::http::openapi()).unwrap();
    let mut described = BTreeSet::new();
    for (path, methods) in description["paths"].as_object().unwrap() {
        for (method, operation) in methods.as_object().unwrap() {
            described.insert((method.to_uppercase(), path.clone()));
            // What stands in the path is named there, and the rest is of the query.
            for parameter in operation["parameters"].as_array().into_iter().flatten() {
                let of_path =
                    path.contains(&format!("{{{}}}", parameter["name"].as_str().unwrap()));
                assert_eq!(parameter["in"] == "path", of_path, "{path}: {parameter}");
            }
        }
    }
    let declared: BTreeSet<(String, String)> = declared()
        .map(|(method, path, _)| (method.to_string(), path.to_string()))
        .collect();
    let missing: Vec<_> = described.difference(&declared).collect();
    assert!(missing.is_empty(), "described, not declared: {missing:?}");
    let pages: Vec<_> = declared
        .difference(&described)
        .filter(|(_, path)| path.starts_with("/v1"))
        .collect();
    assert!(pages.is_empty(), "declared, not described: {pages:?}");
}

/// What a route needs, and how it refuses who has not that, stands in the description as it is
/// enforced.
#[test]
fn tidy_the_description_says_what_each_route_needs() {
    let description: Value = serde_json::from_str(&latchgate_service::http::openapi()).unwrap();
    let schemes = &description["components"]["securitySchemes"];
    assert_eq!(schemes["token"]["scheme"], "bearer");
    let mut asked = 0;
    for (method, path, needs) in declared() {
        let operation = &description["paths"][path][method.to_lowercase()];
        if operation.is_null() {
            continue;
        }
        let of_token = &operation["security"][0]["token"];
        let names: Option<Vec<&str>> =
            needs.map(|scopes| scopes.iter().map(|scope| scope.name()).collect());
        assert_eq!(*of_token, json!(names), "{method} {path}");
        asked += usize::from(needs.is_some());
        for status in ["401", "403", "429", "4XX", "5XX"] {
            let content = &operation["responses"][status]["content"];
            let described = content.get("application/problem+json").is_some();
            let expected = needs.is_some() || !matches!(status, "401" | "403");
            assert_eq!(described, expected, "{method} {path}: {status}");
        }
    }
    assert!(asked > 20, "{asked}");
}

/// What is refused is a problem document where programs ask, and a page where people do: a path that
/// is no text, a query that does not fit, an address or a method that is not known.
#[test]
fn cli_refusals_are_documents_for_programs_and_pages_for_people() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    for (method, path, status) in [
        ("GET", "/v1/none", 404),
        ("GET", "/v1/recordings/%ff", 400),
        ("GET", "/v1/gates/%ff/summary.json", 400),
        ("GET", "/v1/verdicts?limit=0", 400),
        ("GET", "/v1/verdicts?limit=201", 400),
        ("GET", "/v1/recordings?limit=0", 400),
        ("GET", "/v1/gates?limit=0", 400),
        ("GET", "/v1/gates?limit=many", 400),
        ("POST", "/v1/verdicts?wait=61", 400),
        ("DELETE", "/v1/gates", 405),
        ("POST", "/metrics", 405),
    ] {
        let answer = client.send(method, path, &[]).expect(status);
        let kind = answer.header("content-type");
        assert_eq!(kind, Some("application/problem+json"), "{method} {path}");
        let problem = answer.json();
        assert_eq!(problem["status"], status);
        assert!(
            problem["detail"]
                .as_str()
                .is_some_and(|text| text.len() > 10)
        );
    }
    let text = client.get("/v1/verdicts?limit=0").text();
    assert!(text.contains("from 1 to 200, found 0"), "{text}");
    for (method, path, status) in [
        ("GET", "/none", 404),
        ("GET", "/recordings/%ff", 400),
        ("GET", "/verdicts/none", 404),
        ("GET", "/gates/none/runs/first", 400),
        ("GET", "/?cursor=first", 400),
        ("GET", "/?limit=0", 400),
        ("GET", "/assets/none", 404),
        ("POST", "/gates", 405),
    ] {
        let answer = client.send(method, path, &[]).expect(status);
        let kind = answer.header("content-type").unwrap_or("").to_string();
        assert!(kind.starts_with("text/html"), "{method} {path}: {kind}");
        assert!(answer.text().contains("<h1>"), "{method} {path}");
    }
}

/// A limit is refused with its name, its value, what was found and the way out; `/v1/limits` lists it
/// with the same value.
#[test]
fn cli_a_limit_is_named_with_its_way_out() {
    let check = |settings: &[&str], name: &str, status: u16, refuse: &dyn Fn(&Service) -> Value| {
        let folder = Folder::new();
        let service = Service::start(&folder, settings);
        let problem = refuse(&service);
        assert_eq!(
            (&problem["status"], &problem["limit"]["name"]),
            (&json!(status), &json!(name))
        );
        let mut listed = Value::Null;
        wait_for("the limits are listed", || {
            // A client whose allowance is used up has another one later.
            let answer = service.client().get("/v1/limits");
            let is_listed = answer.status == 200;
            listed = answer.json();
            is_listed
        });
        let listed = listed["limits"].as_array().unwrap();
        let listed = listed.iter().find(|own| own["name"] == name).unwrap();
        assert_eq!(problem["limit"]["value"], listed["value"], "{name}");
        assert!(
            problem["limit"]["found"]
                .as_str()
                .is_some_and(|found| !found.is_empty())
        );
        let detail = problem["detail"].as_str().unwrap();
        let value = listed["value"].to_string();
        assert!(detail.contains(name) && detail.contains(&value), "{detail}");
        let way_out = ["configuration", "try again in", "recordings go to"];
        assert!(
            way_out.iter().any(|words| detail.contains(words)),
            "{detail}"
        );
    };
    let upload = |service: &Service| {
        let client = service.client();
        client
            .upload_bytes("burst.csv", &signal("burst.csv"), None)
            .json()
    };
    let gate = |service: &Service| {
        upload(service);
        let text = "[[recordings]]\nfiles = \"burst.csv\"\n[[designs]]\nname = \"a\"\n[[designs]]\nname = \"b\"\n";
        let answer = service.client().send("POST", "/v1/gates", text.as_bytes());
        assert!(matches!(answer.status, 413) || answer.header("retry-after").is_some());
        answer.json()
    };
    check(&["free_mib=1000000000"], "free_bytes", 507, &upload);
    check(&["upload_mib=1"], "upload_bytes", 413, &|service| {
        let client = service.client();
        client
            .upload_bytes("a.csv", &vec![b'0'; 2 << 20], None)
            .json()
    });
    check(&["own_queue=1"], "own_queue", 429, &gate);
    check(&["queue=1"], "queue", 503, &gate);
    check(&["log=info"], "body_bytes", 413, &|service| {
        let client = service.client().with("Content-Type", "application/json");
        client
            .send("POST", "/v1/verdicts", &vec![b' '; (1 << 20) + 1])
            .json()
    });
    check(&["rate_per_s=1", "rate_burst=1"], "rate", 429, &|service| {
        let mut problem = Value::Null;
        wait_for("one is too many", || {
            let answer = service.client().get("/v1/limits");
            let is_refused = answer.status == 429;
            problem = answer.json();
            is_refused
        });
        problem
    });
}

/// What is shown is what is used: no place is left empty.
#[test]
fn cli_the_configuration_shows_where_the_data_lie() {
    let shown = |variable: &str| {
        let output = std::process::Command::new(crate::support::PROGRAM)
            .args(["config", "show", "--origin"])
            .env_remove("XDG_STATE_HOME")
            .env("HOME", "/srv/people/lab")
            .env(variable, "/srv/state")
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let text = shown("XDG_STATE_HOME");
    let line = r#"data = "/srv/state/latchgate"  # environment XDG_STATE_HOME"#;
    assert!(text.contains(line), "{text}");
    let text = shown("OTHER");
    let line = r#"data = "/srv/people/lab/.local/state/latchgate"  # environment HOME"#;
    assert!(text.contains(line), "{text}");
}

#[test]
fn cli_a_token_is_taken_back() {
    let folder = Folder::new();
    let token = folder.token("lab", "read,submit");
    let service = Service::start(&folder, &[]);
    let client = service.client().bearer(&token);
    client.get("/v1/verdicts").expect(200);
    let list = || folder.run(&["token", "list"]).1;
    let text = list();
    assert!(text.starts_with("lab#1  read,submit  made 2"), "{text}");
    assert!(
        text.contains("  last used 2") && text.contains("  ends 2"),
        "{text}"
    );
    assert_eq!(folder.run(&["token", "revoke", "lab"]).0, 0);
    let_the_tokens_age();
    client.get("/v1/verdicts").expect(401);
    assert!(list().trim_end().ends_with("revoked"), "{}", list());
    let (code, text) = folder.run(&["token", "revoke", "lab"]);
    assert_eq!(code, 4);
    assert!(text.contains("no valid token `lab`"), "{text}");
    // Its holder gets another one under the same name.
    let again = folder.token("lab", "read");
    let_the_tokens_age();
    let client = service.client().bearer(&again);
    client.get("/v1/verdicts").expect(200);
}

/// One person has several tokens, each with an end; a new one takes the place of one alone.
#[test]
fn cli_a_person_has_several_tokens() {
    let folder = Folder::new();
    let create = |label: &str, days: &str| {
        let arguments = ["token", "create", "ada", "--label", label, "--days", days];
        let text = folder.run(&arguments).1;
        text.lines().next().unwrap().to_string()
    };
    let (desk, laptop) = (create("desk", "30"), create("laptop", "0"));
    let service = Service::start(&folder, &[]);
    let status = |token: &str| service.client().bearer(token).get("/v1/verdicts").status;
    assert_eq!((status(&desk), status(&laptop)), (200, 200));
    let text = folder.run(&["token", "list"]).1;
    assert!(
        text.contains("ada#1  (desk)") && text.contains("  ends 2"),
        "{text}"
    );
    assert!(
        text.contains("ada#2  (laptop)") && text.contains("without end"),
        "{text}"
    );
    let (code, text) = folder.run(&["token", "rotate", "ada"]);
    assert_eq!(code, 4);
    assert!(text.contains("ada#1, ada#2"), "{text}");
    let (code, new) = folder.run(&["token", "rotate", "ada#1"]);
    assert_eq!(code, 0, "{new}");
    let_the_tokens_age();
    let statuses = [&desk, new.trim(), &laptop].map(status);
    assert_eq!(statuses, [401, 200, 200], "the old one ends");
    let text = folder.run(&["token", "list"]).1;
    assert!(text.contains("ada#3  (desk)"), "{text}");
    // One that is kept for some hours opens yet, and says when it ends.
    let (_, newest) = folder.run(&["token", "rotate", "ada#2", "--keep-h", "24"]);
    let_the_tokens_age();
    assert_eq!([newest.trim(), &laptop].map(status), [200, 200]);
    // What has ended opens nothing: the clock is past its end.
    let connection = rusqlite::Connection::open(folder.data().join("ledger.sqlite")).unwrap();
    connection
        .execute("UPDATE tokens SET ends_ms = 1 WHERE number = 2", [])
        .unwrap();
    let_the_tokens_age();
    assert_eq!(status(&laptop), 401);
}

/// A token reads and asks only where its scopes say so: `submit` alone sees nothing that is stored.
#[test]
fn regress_a_token_that_submits_reads_nothing() {
    let folder = Folder::new();
    let (both, submit) = (
        folder.token("b", "read,submit"),
        folder.token("s", "submit"),
    );
    let service = Service::start(&folder, &[]);
    let both = service.client().bearer(&both);
    let id = both.upload("burst.csv")["id"].clone();
    let secret =
        json!({"name": "secret", "design": {"base": "paper", "lever": {"preload_torque_nm": 2.0}}});
    both.post("/v1/designs", &secret).expect(201);
    let submit = service.client().bearer(&submit);
    submit
        .upload_bytes("own.csv", b"t_s,acc_y_g\n0,1\n0.001,2\n", None)
        .expect(201);
    let copied = json!({"name": "mine", "design": "secret@1"});
    submit.post("/v1/designs", &copied).expect(403);
    submit
        .post("/v1/designs", &json!({"name": "mine"}))
        .expect(201);
    let question = json!({"recording": id});
    submit.post("/v1/verdicts", &question).expect(403);
    submit.post("/v1/what-if", &question).expect(403);
    submit
        .send("POST", "/v1/gates", b"[[recordings]]\nfiles = \"*\"\n")
        .expect(403);
}

/// Designs have a share for each token, a longest name, and come in parts without their numbers.
#[test]
fn regress_designs_are_bounded() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["own_designs=3"]);
    let client = service.client();
    let keep = |torque: f64| {
        let design = json!({"base": "paper", "lever": {"preload_torque_nm": torque}});
        client.post("/v1/designs", &json!({"name": "d", "design": design}))
    };
    let long = json!({"name": "d", "design": {"base": "paper", "name": "n".repeat(1000)}});
    let refused = client.post("/v1/designs", &long).expect(400).json();
    assert!(
        refused["detail"]
            .as_str()
            .unwrap()
            .contains("up to 200 letters, found 1000")
    );
    for number in 1..=3 {
        keep(f64::from(number)).expect(201);
    }
    let problem = keep(4.0).expect(507).json();
    assert_eq!(problem["limit"]["name"], "own_designs", "{problem}");
    let first = client.get("/v1/designs?limit=2").expect(200).json();
    let named = |list: &Value| -> Vec<String> {
        let designs = list["designs"].as_array().unwrap().iter();
        designs
            .map(|own| own["reference"].as_str().unwrap().to_string())
            .collect()
    };
    assert_eq!(named(&first), ["d@3", "d@2"]);
    assert!(first["designs"][0]["design"].is_null() && first["designs"][0]["owner"] == "local");
    let rest = client
        .get(&format!("/v1/designs?limit=2&cursor={}", first["next"]))
        .json();
    assert_eq!(named(&rest), ["d@1"]);
    // What is deleted makes room, and its number is never given again.
    client.send("DELETE", "/v1/designs/d", &[]).expect(400);
    client.send("DELETE", "/v1/designs/d@3", &[]).expect(204);
    client.send("DELETE", "/v1/designs/d@3", &[]).expect(404);
    client.get("/v1/designs/d@3").expect(404);
    assert_eq!(client.get("/v1/designs/d").expect(200).json()["version"], 2);
    assert_eq!(keep(3.0).expect(201).json()["reference"], "d@4");
}

#[test]
fn cli_beyond_the_loopback_a_token_must_exist() {
    let folder = Folder::new();
    let (code, text) = folder.run(&["--listen", "0.0.0.0:0"]);
    assert_eq!(code, 4);
    assert!(text.contains("token create"), "{text}");
}

/// A token stands in no file, no log and no answer.
#[test]
fn cli_a_token_is_kept_nowhere() {
    let folder = Folder::new();
    let token = folder.token("canary", "read,submit,admin");
    let service = Service::start(&folder, &["log=trace"]);
    let client = service.client().bearer(&token);
    let id = client
        .upload_bytes("burst.csv", &signal("burst.csv"), None)
        .json()["id"]
        .clone();
    let asking = json!({"recording": id, "request": {"members": 0}});
    let answer = client.post("/v1/verdicts?wait=60", &asking).expect(200);
    assert!(!answer.text().contains(&token));
    for path in ["/", "/metrics", "/v1/limits", "/v1/verdicts"] {
        let text = String::from_utf8_lossy(&client.get(path).body).into_owned();
        assert!(!text.contains(&token), "{path}");
    }
    client.get(&format!("/v1/verdicts?filter={}", &token[..20]));
    let log = service.log.clone();
    assert_eq!(service.end(), 0);
    let secret = token.trim_start_matches("lg_").as_bytes().to_vec();
    let mut open = vec![folder.0.clone()];
    let mut looked = 0;
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(
                fs::read_dir(path)
                    .unwrap()
                    .map(|entry| entry.unwrap().path()),
            );
            continue;
        }
        let bytes = fs::read(&path).unwrap();
        looked += 1;
        assert!(
            !bytes.windows(secret.len()).any(|window| window == secret),
            "{}",
            path.display()
        );
    }
    assert!(looked > 5 && fs::read_to_string(log).unwrap().contains("canary"));
}

#[test]
fn cli_a_page_from_elsewhere_changes_nothing() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let upload = |client: &crate::support::Client| {
        client
            .send("POST", "/v1/recordings?name=a.csv", b"t_s,a_g\n0,1\n")
            .status
    };
    assert_eq!(
        upload(&client.clone().with("Origin", "http://elsewhere.example")),
        403
    );
    assert_eq!(upload(&client.clone().with("Origin", "null")), 403);
    assert_eq!(
        upload(&client.clone().with("Sec-Fetch-Site", "cross-site")),
        403
    );
    assert_eq!(
        upload(&client.clone().with("Sec-Fetch-Site", "same-site")),
        403
    );
    let own = format!("http://{}", service.address);
    assert_eq!(upload(&client.clone().with("Origin", &own)), 201);
    // A name that someone else points here is not known.
    client
        .with("Host", "elsewhere.example")
        .get("/v1/verdicts")
        .expect(401);
}

#[test]
fn cli_every_answer_carries_its_headers() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    for path in ["/healthz", "/v1/verdicts", "/v1/nothing", "/openapi.json"] {
        let answer = client.get(path);
        let policy = answer.header("content-security-policy").unwrap();
        assert!(
            policy.starts_with("default-src 'self'") && !policy.contains("unsafe"),
            "{path}"
        );
        assert_eq!(
            answer.header("x-content-type-options"),
            Some("nosniff"),
            "{path}"
        );
    }
    let id = client.upload("burst.csv")["id"].clone();
    let asking = json!({"recording": id, "request": {"members": 0}});
    let document = client
        .post("/v1/verdicts?wait=60", &asking)
        .expect(200)
        .json();
    let path = format!("/v1/verdicts/{}", document["report_id"].as_str().unwrap());
    let page = client.get(&format!("{path}/report.html")).expect(200);
    let policy = page.header("content-security-policy").unwrap();
    assert!(
        policy.starts_with("sandbox") && policy.contains("default-src 'none'"),
        "{policy}"
    );
    let table = client.get(&format!("{path}/series.csv")).expect(200);
    let name = table.header("content-disposition").unwrap();
    assert!(
        name.starts_with("attachment; filename=\"burst.csv-") && name.ends_with("-series.csv\""),
        "{name}"
    );
}

#[test]
fn cli_a_token_has_its_rate_and_its_share() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["rate_per_s=1", "rate_burst=5"]);
    let client = service.client();
    let began = Instant::now();
    let mut answered = 0;
    // On a slow machine more come in between, one for each second.
    let refused = loop {
        let answer = client.get("/v1/limits");
        if answer.status == 429 {
            break answer;
        }
        answer.expect(200);
        answered += 1;
        let allowed = 5.0 + began.elapsed().as_secs_f64();
        assert!(f64::from(answered) <= allowed, "{answered} of {allowed}");
        assert!(began.elapsed() < HANG, "none was refused");
    };
    assert!(answered >= 5, "of a burst of 5 {answered} were answered");
    assert!(refused.header("retry-after").is_some());
    drop(service);
    // A single upload cannot go beyond the share either, whether or not it says how long it is.
    let service = Service::start(&folder, &["own_mib=1"]);
    let client = service.client();
    let table = format!("t_s,acc_y_g\n{}", "0.0001,1\n".repeat(200_000));
    for answer in [
        client.send("POST", "/v1/recordings?name=long.csv", table.as_bytes()),
        client.upload_bytes("long.csv", table.as_bytes(), None),
    ] {
        let problem = answer.expect(507).json();
        assert_eq!(problem["limit"]["name"], "own_bytes", "{problem}");
        assert_eq!(problem["limit"]["value"], 1 << 20);
    }
    drop(service);
    let service = Service::start(&folder, &["own_queue=1", "places=1"]);
    let client = service.client();
    let id = client.upload("burst.csv")["id"].clone();
    let mut refused = 0;
    for torque in 0..12 {
        let set = format!("lever.preload_torque_nm=2.{torque:02}");
        // One that takes longer than the others need to come.
        let request = json!({"members": 10_000, "opens_when": "both"});
        let answer = client.post(
            "/v1/verdicts?wait=0",
            &json!({"recording": id, "request": request, "set": [set]}),
        );
        assert!(matches!(answer.status, 202 | 429), "{}", answer.status);
        refused += u32::from(answer.status == 429);
    }
    assert!(refused > 0);
}

/// A secret that counts how often it is compared. It can be compared in constant time alone: there is
/// no `PartialEq` that ends at the first byte that differs.
struct CountedSecret<'a> {
    byte: u8,
    comparisons: &'a Cell<usize>,
}

impl ConstantTimeEq for CountedSecret<'_> {
    fn ct_eq(&self, other: &Self) -> Choice {
        self.comparisons.set(self.comparisons.get() + 1);
        self.byte.ct_eq(&other.byte)
    }
}

/// A search among secrets compares each of them once and in constant time, wherever the right one is
/// and if none is: the work says nothing of how much of a secret is right.
#[test]
fn verif_every_stored_secret_is_compared_once_in_constant_time() {
    let stored = *b"abcdefgh";
    for (presented, expected) in [
        (b'a', Some(0)),
        (b'd', Some(3)),
        (b'h', Some(7)),
        (b'z', None),
    ] {
        let comparisons = Cell::new(0);
        let secret = |byte| CountedSecret {
            byte,
            comparisons: &comparisons,
        };
        let secrets = stored.map(secret);
        let index = matching_secret(secrets.iter(), &secret(presented));
        assert_eq!(index, expected, "{}", char::from(presented));
        assert_eq!(comparisons.get(), stored.len(), "{}", char::from(presented));
    }
}

/// A token is looked up by its SHA-256: what is nearly right has nothing in common with what is stored,
/// and what is stored opens nothing. The hash of `abc` is that of FIPS 180-4.
#[test]
fn val_a_token_is_looked_up_by_its_hash() {
    const SHA256_OF_ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    let folder = Folder::new();
    let ledger = SqliteLedger::open(&folder.0.join("ledger.sqlite")).unwrap();
    let token = StoredToken {
        number: 0,
        sha256: SHA256_OF_ABC.into(),
        name: "lab".into(),
        label: String::new(),
        scopes: "read".into(),
        created_ms: 0,
        ends_ms: None,
        used_ms: None,
        revoked: false,
    };
    let number = ledger.put_token(&token).unwrap();
    let door = Door::new(SessionTimes {
        idle_ms: 3_600_000,
        whole_ms: 3_600_000,
    });
    let session = door.sign_in(&ledger, number).unwrap();
    let stored_session = ledger.sessions().unwrap()[0].sha256.clone();
    let session_of = |secret: &str| Presented::Session(secret.into());
    let token_of = |secret: &str| Presented::Token(secret.into());
    for (presented, is_known) in [
        (token_of("abc"), true),
        (token_of("abd"), false),
        (token_of("ab"), false),
        (token_of(SHA256_OF_ABC), false),
        (session_of(session.reveal()), true),
        (session_of(&stored_session), false),
        (session_of("abc"), false),
    ] {
        let recognition = door.look(&ledger, Some(&presented)).unwrap();
        let expected = match &recognition {
            Recognition::Known(visitor) => is_known && visitor.token == Some(number),
            Recognition::Stranger => !is_known,
            Recognition::Open(_) => false,
        };
        assert!(expected, "{presented:?}: {recognition:?}");
    }
}

/// The page's sign-in sets a cookie that no script reads and no other page sends; it opens what its
/// token opens, until one signs out.
#[test]
fn cli_a_person_signs_in_and_out() {
    let folder = Folder::new();
    let token = folder.token("lab", "read");
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let asked = client
        .clone()
        .with("Accept", "text/html")
        .get("/")
        .expect(303);
    assert_eq!(asked.header("location"), Some("/login"));
    assert!(
        client
            .get("/login")
            .expect(200)
            .text()
            .contains("name=\"token\"")
    );
    let form = client
        .clone()
        .with("Content-Type", "application/x-www-form-urlencoded");
    let wrong = form.send("POST", "/login", b"token=lg_0").expect(401);
    assert!(wrong.text().contains("name=\"token\""), "the field stays");
    assert!(wrong.header("set-cookie").is_none());
    let body = format!("token={token}");
    let signed = form.send("POST", "/login", body.as_bytes()).expect(303);
    assert_eq!(signed.header("location"), Some("/"));
    let cookie = signed.header("set-cookie").unwrap();
    assert!(
        cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict"),
        "{cookie}"
    );
    let own = cookie.split(';').next().unwrap();
    let person = client.clone().with("Cookie", own);
    assert!(
        person
            .get("/")
            .expect(200)
            .text()
            .contains("Would the door")
    );
    assert!(
        person
            .get("/login")
            .expect(200)
            .text()
            .contains("Signed in as <strong>lab")
    );
    person.send("POST", "/v1/gates", b"").expect(403);
    // The cookie is no token, and a token is no cookie.
    assert!(!cookie.contains(&token), "{cookie}");
    let secret = own.split_once('=').unwrap().1;
    client
        .clone()
        .bearer(secret)
        .get("/v1/verdicts")
        .expect(401);
    let as_cookie = format!("latchgate-session={token}");
    client
        .clone()
        .with("Cookie", &as_cookie)
        .get("/v1/verdicts")
        .expect(401);
    person.get("/v1/verdicts").expect(200);
    let out = person.send("POST", "/logout", &[]).expect(303);
    assert!(out.header("set-cookie").unwrap().contains("Max-Age=0"));
    assert!(out.header("clear-site-data").unwrap().contains("cache"));
    // Wherever else somebody signed in with the token is shown, and ended as one.
    let again = || {
        let signed = form.send("POST", "/login", body.as_bytes()).expect(303);
        let cookie = signed.header("set-cookie").unwrap();
        let own = cookie.split(';').next().unwrap().to_string();
        client.clone().with("Cookie", &own)
    };
    let (desk, laptop) = (again(), again());
    let page = desk.get("/login").expect(200).text();
    assert_eq!(page.matches(", last used ").count(), 2, "{page}");
    desk.send("POST", "/logout", b"everywhere=true").expect(303);
    for session in [&desk, &laptop] {
        session.get("/v1/verdicts").expect(401);
    }
    // Whoever kept the cookie has nothing.
    person.get("/v1/verdicts").expect(401);
    // Where TLS ends at a proxy the cookie never goes without, nor to another host or port.
    let behind = form
        .with("X-Forwarded-Proto", "https")
        .send("POST", "/login", body.as_bytes());
    let cookie = behind.header("set-cookie").unwrap();
    assert!(
        cookie.starts_with("__Host-") && cookie.ends_with("; Secure"),
        "{cookie}"
    );
    // Nobody slips a session under by the plain name there.
    let own = cookie.split(';').next().unwrap();
    let behind = client.clone().with("X-Forwarded-Proto", "https");
    let both = format!("latchgate-session=other; {own}");
    behind
        .clone()
        .with("Cookie", &both)
        .get("/v1/verdicts")
        .expect(200);
    let plain = own.replace("__Host-", "");
    behind
        .with("Cookie", &plain)
        .get("/v1/verdicts")
        .expect(401);
}

/// A session ends some time after it was used last, some time after it began, and with its token.
#[test]
fn regress_a_session_has_an_end() {
    let folder = Folder::new();
    let token = folder.token("lab", "read");
    let service = Service::start(&folder, &["session_h=3", "session_idle_h=1"]);
    let client = service.client();
    let sign_in = || {
        let form = client
            .clone()
            .with("Content-Type", "application/x-www-form-urlencoded");
        let signed = form
            .send("POST", "/login", format!("token={token}").as_bytes())
            .expect(303);
        let cookie = signed
            .header("set-cookie")
            .unwrap()
            .split(';')
            .next()
            .unwrap()
            .to_string();
        client.clone().with("Cookie", &cookie)
    };
    let connection = rusqlite::Connection::open(folder.data().join("ledger.sqlite")).unwrap();
    let hour = 3_600_000;
    let aged = |change: &str| {
        let person = sign_in();
        person.get("/v1/verdicts").expect(200);
        connection.execute(change, []).unwrap();
        let_the_tokens_age();
        person.get("/v1/verdicts").expect(401);
    };
    aged(&format!("UPDATE sessions SET seen_ms = seen_ms - {hour}"));
    aged(&format!(
        "UPDATE sessions SET created_ms = created_ms - 3 * {hour}"
    ));
    let person = sign_in();
    // It outlives a restart, and is kept by its hash alone.
    let whole = fs::read(folder.data().join("ledger.sqlite")).unwrap();
    let secret = person.headers[0].1.split_once('=').unwrap().1.as_bytes();
    assert!(!whole.windows(secret.len()).any(|window| window == secret));
    assert_eq!(folder.run(&["token", "revoke", "lab"]).0, 0);
    let_the_tokens_age();
    person.get("/v1/verdicts").expect(401);
}

/// Uploads that come at once pass a token's share no more than those that come one by one; what was
/// known counts once.
#[test]
fn cli_uploads_at_once_keep_to_the_share() {
    let folder = Folder::new();
    let token = folder.token("lab", "read,submit");
    let service = Service::start(&folder, &["own_mib=1"]);
    let client = service.client().bearer(&token);
    let body = |number: u32| {
        let mut body = format!("t_s,acc_y_g\n{number},0\n").into_bytes();
        body.resize(300 << 10, b'#');
        body
    };
    let hands: Vec<_> = (0..8)
        .map(|number| {
            let (client, body) = (client.clone(), body(number));
            std::thread::spawn(move || {
                let path = format!("/v1/recordings?name=n{number}.csv");
                client.send("POST", &path, &body)
            })
        })
        .collect();
    let answers: Vec<_> = hands.into_iter().map(|hand| hand.join().unwrap()).collect();
    let kept = answers.iter().filter(|answer| answer.status == 201).count();
    assert_eq!(kept, 3, "of 8 times 300 KiB 1 MiB holds three");
    for answer in answers.iter().filter(|answer| answer.status != 201) {
        assert_eq!(
            (answer.status, &answer.json()["limit"]["name"]),
            (507, &json!("own_bytes"))
        );
    }
    let listed = client.get("/v1/recordings").expect(200).json();
    let listed = listed["recordings"].as_array().unwrap();
    assert_eq!(listed.len(), 3, "what was refused is not kept");
}

/// Whoever may only read changes nothing on the disk, whatever the query says.
#[test]
fn verif_a_reader_writes_nothing() {
    let folder = Folder::new();
    let (reader, writer) = (folder.token("r", "read"), folder.token("w", "read,submit"));
    let service = Service::start(&folder, &[]);
    let client = service.client().bearer(&writer);
    let id = client.upload("burst.csv")["id"].clone();
    let question = json!({"recording": id, "request": {"members": 0}});
    let verdict = client.post("/v1/verdicts?wait=60", &question).expect(200);
    let place = verdict.header("location").unwrap().to_string();
    let before = blobs(&folder);
    assert!(before > 1, "{before} files");
    let reader = service.client().bearer(&reader);
    let recording = format!("/v1/recordings/{}", id.as_str().unwrap());
    for number in 0..20 {
        let range = format!("t0=0.0{number:02}&t1=0.0{}", number + 30);
        reader
            .get(&format!("{place}/series.csv?{range}"))
            .expect(200);
        let request = format!("{recording}?request=%7B%22header_line%22:{}%7D", number + 1);
        reader.get(&request);
    }
    for path in [&place, &recording, "/", "/gates", "/designs"] {
        reader.get(path).expect(200);
    }
    assert_eq!(blobs(&folder), before);
}

/// Counts the files that are kept, and those that are under way.
pub(crate) fn blobs(folder: &Folder) -> usize {
    let folders = fs::read_dir(folder.data().join("blobs")).unwrap().flatten();
    folders
        .map(|folder| fs::read_dir(folder.path()).unwrap().count())
        .sum()
}

/// Two services on one folder would take each other's jobs and uploads away: the second is refused,
/// and the first goes on.
#[test]
fn cli_a_folder_has_one_service() {
    let folder = Folder::new();
    let mut first = Service::start(&folder, &[]);
    first.client().get("/readyz").expect(200);
    let second = |settings: &[&str]| {
        let mut command = std::process::Command::new(crate::support::PROGRAM);
        command.args(["--listen", "127.0.0.1:0", "--data"]);
        command.arg(folder.data()).args(settings);
        command.stdin(std::process::Stdio::null());
        let mut child = command
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        let began = Instant::now();
        while child.try_wait().unwrap().is_none() && began.elapsed() < HANG {
            std::thread::sleep(Duration::from_millis(20));
        }
        let _ = child.kill();
        let output = child.wait_with_output().unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), text)
    };
    let (code, text) = second(&[]);
    assert_eq!(code, Some(4), "{text}");
    assert!(
        text.contains("another process serves this folder"),
        "{text}"
    );
    first.client().upload("burst.csv");
    // One that was killed leaves no lock behind.
    first.child.kill().unwrap();
    first.child.wait().unwrap();
    Service::start(&folder, &[])
        .client()
        .get("/readyz")
        .expect(200);
}

/// A token that was just made works at once, in requests and at the page's sign-in, whatever was read a moment before.
#[test]
fn cli_a_new_token_works_at_once() {
    let folder = Folder::new();
    let first = folder.token("first", "read");
    let service = Service::start(&folder, &[]);
    let client = service.client();
    for number in 0..5 {
        client
            .clone()
            .bearer(&first)
            .get("/v1/verdicts")
            .expect(200);
        let token = folder.token(&format!("new-{number}"), "read");
        client
            .clone()
            .bearer(&token)
            .get("/v1/verdicts")
            .expect(200);
        let token = folder.token(&format!("person-{number}"), "read");
        let form = client
            .clone()
            .with("Content-Type", "application/x-www-form-urlencoded");
        form.send("POST", "/login", format!("token={token}").as_bytes())
            .expect(303);
        client
            .clone()
            .bearer("lg_0")
            .get("/v1/verdicts")
            .expect(401);
    }
}

/// An unknown credential has the tokens read again if something was written since, and not otherwise.
#[test]
fn verif_a_guess_costs_no_reading() {
    let folder = Folder::new();
    let path = folder.0.join("ledger.sqlite");
    let (ledger, beside) = (
        SqliteLedger::open(&path).unwrap(),
        SqliteLedger::open(&path).unwrap(),
    );
    let put = |secret: &str| {
        let token = StoredToken {
            number: 0,
            sha256: latchgate_service::store::sha256_hex(secret.as_bytes()),
            name: secret.into(),
            label: String::new(),
            scopes: "read".into(),
            created_ms: 1,
            ends_ms: None,
            used_ms: None,
            revoked: false,
        };
        beside.put_token(&token).unwrap();
    };
    let door = Door::new(SessionTimes {
        idle_ms: 1000,
        whole_ms: 1000,
    });
    let known = |secret: &str| {
        let seen = door.look_anew(&ledger, &Presented::Token(secret.into()));
        matches!(seen.unwrap(), Recognition::Known(_))
    };
    put("one");
    assert!(known("one") && !known("two"));
    let before = ledger.change().unwrap();
    assert!(!known("two") && !known("three"));
    assert_eq!(ledger.change().unwrap(), before, "a guess writes nothing");
    put("two");
    assert_ne!(ledger.change().unwrap(), before);
    assert!(known("two") && !known("three"));
}
