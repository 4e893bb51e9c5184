//! What hostile uploads and clients can do: nothing to anybody else.

use crate::support::{Client, Folder, HANG, ServedEnd, Service, served_end, signal, wait_for};
use seccompiler::{BpfProgram, SeccompAction, SeccompFilter};
use serde_json::json;
use std::io::Write;
use std::net::TcpStream;
use std::process::Command;

/// Each thing that a child must not do is stopped.
#[test]
fn cli_the_jail_stops_what_a_child_tries() {
    let folder = Folder::new();
    let (code, text) = folder.run(&["jail"]);
    assert_eq!(code, 0, "{text}");
    assert_eq!(
        text.lines()
            .filter(|line| line.contains(": stopped"))
            .count(),
        10,
        "{text}"
    );
}

/// The trials touch nothing that others laid out under the name of their folder.
#[test]
fn regress_trials_are_made_in_a_folder_of_their_own() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let (temporary, foreign) = (folder.0.join("tmp"), folder.0.join("foreign"));
    std::fs::create_dir_all(foreign.join("unfinished")).unwrap();
    std::fs::create_dir(&temporary).unwrap();
    let kept = foreign.join("unfinished/kept");
    std::fs::write(&kept, "a file of somebody else").unwrap();
    // The shell's number is that of the program that takes its place.
    let script = "ln -s \"$1\" \"$TMPDIR/latchgate-trials-$$\"; exec \"$0\" jail --data \"$1\"";
    let mut child = Command::new("sh")
        .args(["-c", script, crate::support::PROGRAM])
        .arg(&foreign)
        .env("TMPDIR", &temporary)
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let own = || {
        let entries = std::fs::read_dir(&temporary).unwrap().flatten();
        let mut folders = entries.filter(|entry| entry.file_type().unwrap().is_dir());
        folders.next().map(|entry| entry.path())
    };
    wait_for("its folder is there", || own().is_some());
    let about = std::fs::metadata(own().unwrap()).unwrap();
    assert_eq!(about.permissions().mode() & 0o777, 0o700);
    assert!(child.wait().unwrap().success());
    assert!(kept.exists(), "it belongs to somebody else");
    assert_eq!(own(), None, "its own folder goes");
}

/// Starts something under a kernel that lacks a call.
fn under_a_kernel_without<T: Send>(call: i64, start: impl FnOnce() -> T + Send) -> T {
    let rules = [(call, Vec::new())].into();
    let refused = SeccompAction::Errno(libc::ENOSYS.unsigned_abs());
    let arch = std::env::consts::ARCH.try_into().unwrap();
    let filter = SeccompFilter::new(rules, SeccompAction::Allow, refused, arch).unwrap();
    let filter: BpfProgram = filter.try_into().unwrap();
    std::thread::scope(|scope| {
        // The filter is that of the thread, and of what it starts.
        let thread = scope.spawn(move || {
            seccompiler::apply_filter(&filter).unwrap();
            start()
        });
        thread.join().unwrap()
    })
}

/// Where the kernel lacks a part of the jail the service does not start, unless that is said.
#[test]
fn cli_without_the_whole_jail_nothing_starts_unasked() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let jail = service.client().get("/v1/limits").json()["jail"].clone();
    assert_eq!(
        (&jail["lacking"], &jail["files"]),
        (&json!([]), &json!("all"))
    );
    assert_eq!(service.end(), 0);
    for (call, lacks) in [
        (libc::SYS_landlock_create_ruleset, "files (Landlock)"),
        (libc::SYS_seccomp, "calls of the system (seccomp)"),
    ] {
        let output = under_a_kernel_without(call, || {
            let mut command = Command::new("timeout");
            command.args([
                "300",
                crate::support::PROGRAM,
                "--listen",
                "127.0.0.1:0",
                "--data",
            ]);
            command.arg(folder.data()).output().unwrap()
        });
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(4), "{text}");
        assert!(
            text.contains(lacks) && text.contains("--without-jail"),
            "{text}"
        );
    }
    let call = libc::SYS_landlock_create_ruleset;
    let service = under_a_kernel_without(call, || {
        let mut command = Command::new(crate::support::PROGRAM);
        command
            .arg("--without-jail")
            .arg("--data")
            .arg(folder.data());
        Service::of(command, &folder)
    });
    let client = service.client();
    let jail = client.get("/v1/limits").expect(200).json()["jail"].clone();
    assert_eq!(
        (&jail["files"], &jail["seccomp"]),
        (&json!("no"), &json!(true))
    );
    client.upload("burst.csv");
}

/// Each child's jail is looked at, and a child with less than the whole one gets no order.
#[test]
fn verif_a_child_with_less_than_the_jail_is_ended() {
    use latchgate_service::pool::{ChildOptions, Order, Slot, Trial};
    use latchgate_service::store::BlobFolder;
    let folder = Folder::new();
    let blobs = BlobFolder::open(&folder.0.join("blobs")).unwrap();
    let program = folder.0.join("child");
    let order = |lacking: &str, without_jail: bool| {
        let hello = json!({"says": "hello", "jail": {"files": "no", "tcp": "all", "seccomp": true,
            "memory_bytes": 1, "lacking": if lacking.is_empty() { json!([]) } else { json!([lacking]) }}});
        let answer = json!({"says": "answer", "files": [], "holds": [],
            "answer": {"kind": "tried", "stopped": true, "how": "told"}});
        let mut said = Vec::new();
        for words in [hello, answer] {
            let text = words.to_string();
            said.extend_from_slice(&(text.len() as u32).to_le_bytes());
            said.extend_from_slice(text.as_bytes());
        }
        std::fs::write(folder.0.join("said"), said).unwrap();
        let script = format!(
            "#!/bin/sh\ncat {}\nexec cat > /dev/null\n",
            folder.0.join("said").display()
        );
        // What another thread starts meanwhile would hold a file open that is written here, and
        // no program can be run that somebody may write.
        let text = folder.0.join("text");
        std::fs::write(&text, script).unwrap();
        let paths = [text.display().to_string(), program.display().to_string()];
        run("install", &["-m", "700", &paths[0], &paths[1]]);
        let mut slot = Slot::new(ChildOptions {
            program: program.clone(),
            memory_bytes: 1 << 30,
            order_time: HANG,
            silence: HANG,
            answer_bytes: 1 << 20,
            without_jail,
        })
        .unwrap();
        let trial = Order::Try {
            trial: Trial::OpenFile,
        };
        let outcome = slot.order(&trial, None, &blobs, &mut |_| {});
        outcome.map(|_| ()).map_err(|lost| lost.to_string())
    };
    assert_eq!(order("", false), Ok(()));
    assert_eq!(order("files (Landlock): no", true), Ok(()));
    let told = order("files (Landlock): no", false).unwrap_err();
    assert!(
        told.contains("its jail lacks files (Landlock): no"),
        "{told}"
    );
}

/// An upload that takes more memory than a child may is unusable, with the reason; its neighbours
/// are judged.
#[test]
fn verif_a_recording_that_ends_its_reader_is_unusable() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["child_memory_mib=96", "places=2"]);
    let client = service.client();
    let large = format!("t_s,acc_y_g\n{}", "0.0000001,1.00000001\n".repeat(3 << 20));
    let answer = client
        .send("POST", "/v1/recordings?name=large.csv", large.as_bytes())
        .expect(201);
    let recording = answer.json();
    assert_eq!(
        recording["problem"]["code"], "ends-its-reader",
        "{recording}"
    );
    assert_eq!(recording["problem"]["verdict"], "unusable");
    let detail = recording["problem"]["detail"].as_str().unwrap();
    assert!(
        detail.contains("signal 6") && detail.contains("3 of 3"),
        "{detail}"
    );
    let asked = client.post(
        "/v1/verdicts?wait=60",
        &json!({"recording": recording["id"]}),
    );
    assert_eq!(asked.expect(422).json()["verdict"], "unusable");
    let path = format!("/v1/recordings/{}", recording["id"].as_str().unwrap());
    let kept = client.get(&path).expect(200).json();
    assert_eq!(kept, recording, "answered from the store");
    let id = client.upload("burst.csv")["id"].clone();
    client
        .post(
            "/v1/verdicts?wait=60",
            &json!({"recording": id, "request": {"members": 0}}),
        )
        .expect(200);
}

/// A child that had too little memory says nothing about the recording once it may take more.
#[test]
fn regress_a_refusal_ends_with_the_limit_that_made_it() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["child_memory_mib=96", "places=1"]);
    let rows = (0..1_200_000).map(|row| format!("{:.4},0.01\n", f64::from(row) * 1e-4));
    let large = format!("t_s,acc_y_g\n{}", rows.collect::<String>());
    let path = "/v1/recordings?name=large.csv";
    let client = service.client();
    let id = client.send("POST", path, large.as_bytes()).expect(201);
    let id = id.json()["id"].clone();
    let question = json!({"recording": id, "request": {"members": 0}});
    let refused = client.post("/v1/verdicts?wait=60", &question).expect(422);
    assert_eq!(refused.json()["code"], "ends-its-reader");
    assert_eq!(service.end(), 0);
    let service = Service::start(&folder, &["child_memory_mib=1024", "places=1"]);
    let client = service.client();
    let path = format!("/v1/recordings/{}", id.as_str().unwrap());
    let listing = client.get(&path).expect(200).json();
    assert_eq!(listing.get("problem"), None, "{listing}");
    client.post("/v1/verdicts?wait=0", &question).expect(202);
}

/// A table whose questions take some 100 µs a sample, as long as they may: it can be judged, since of one that cannot
/// little is followed.
fn slow_table(samples: u32) -> String {
    let quiet = samples / 20;
    let mut table = String::from("t_s,acc_y_g\n");
    for sample in 0..samples {
        let at = f64::from(sample);
        let is_push = (quiet..samples - quiet).contains(&sample);
        let top = if is_push {
            32.0 + 8.0 * (at * 1.37e-3).sin()
        } else {
            0.0
        };
        let noise = 0.01 * (f64::from(sample * 7 % 11) - 5.0);
        let push = top * (at * std::f64::consts::TAU / 40.0).sin() + noise;
        table += &format!("{:.5},{push:.3}\n", at * 1e-5);
    }
    table
}

/// Keeps a recording whose questions take a second or two, so that a child is met at work.
fn slow_recording(client: &Client) -> serde_json::Value {
    let path = "/v1/recordings?name=slow.csv";
    let kept = client.send("POST", path, slow_table(40_000).as_bytes());
    kept.expect(201).json()["id"].clone()
}

fn slow_question(id: &serde_json::Value) -> serde_json::Value {
    json!({"recording": id, "request": {"members": 512, "opens_when": "both"}})
}

fn run(program: &str, arguments: &[&str]) {
    let status = Command::new(program).args(arguments).status();
    assert!(status.unwrap().success(), "{program} {arguments:?}");
}

/// Signals that somebody sends to the children, as a terminal or a supervisor does, cost time and
/// say nothing about the recording.
#[test]
fn regress_signals_from_outside_are_no_fault_of_the_recording() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["places=1"]);
    let client = service.client();
    let id = slow_recording(&client);
    let metric = |name: &str| -> u64 {
        let text = client.get("/metrics").text();
        let found = text.lines().find_map(|line| line.strip_prefix(name));
        found.unwrap().trim().parse().unwrap()
    };
    let lost = || metric("latchgate_children_lost_total ");
    let mut jobs: Vec<String> = Vec::new();
    let is_in = |job: &String, wanted: &str| {
        let state = client.get(job).json()["state"].clone();
        assert_ne!(state, "refused", "{}", client.get(job).text());
        state == wanted
    };
    let ended = |job: &String| is_in(job, "done");
    for signal in ["-INT", "-TERM", "-HUP", "-KILL"] {
        let before = lost();
        let mut looks = 0;
        wait_for("a child is met at work", || {
            // One that was quicker than the signal is asked again with other levers.
            if jobs.last().is_none_or(&ended) {
                let mut question = slow_question(&id);
                question["request"]["seed"] = json!(jobs.len() + 1);
                let asked = client.post("/v1/verdicts?wait=0", &question);
                let job = asked.expect(202).json()["job"].clone();
                jobs.push(format!("/v1/jobs/{}", job.as_str().unwrap()));
                looks = 0;
            }
            if jobs.last().is_some_and(|job| is_in(job, "running")) {
                looks += 1;
            }
            // Once for each question, later for each next one: whoever ends children that are yet without work,
            // again and again, never meets one at work.
            if looks == 1 + jobs.len() % 8 {
                for child in service.children() {
                    // It may have ended meanwhile.
                    let _ = Command::new("kill")
                        .args([signal, &child])
                        .stderr(std::process::Stdio::null())
                        .status();
                }
            }
            lost() > before
        });
    }
    wait_for("they are answered", || jobs.iter().all(&ended));
    // A Ctrl-C on a terminal goes to the group of the service, which is not theirs.
    for child in service.children() {
        let stat = std::fs::read_to_string(format!("/proc/{child}/stat")).unwrap();
        let group = stat.rsplit_once(") ").unwrap().1.split(' ').nth(2).unwrap();
        assert_eq!(group, child);
    }
}

/// Where no child can be started for a while, the question waits for better times.
#[test]
fn regress_a_child_that_cannot_be_started_is_no_fault_of_the_recording() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["places=1"]);
    let client = service.client();
    let id = slow_recording(&client);
    let process = service.child.id().to_string();
    let limits = std::fs::read_to_string(format!("/proc/{process}/limits")).unwrap();
    let open_files = limits
        .lines()
        .find(|line| line.starts_with("Max open files"));
    let soft = open_files.unwrap().split_whitespace().nth(3).unwrap();
    assert!(soft.parse::<u64>().unwrap() >= 2 * 1024 + 64, "{soft}");
    let asked = client.post("/v1/verdicts?wait=0", &slow_question(&id));
    let job = asked.expect(202).json()["job"].clone();
    run("prlimit", &["--pid", &process, "--nofile=4:"]);
    for child in service.children() {
        run("kill", &["-KILL", &child]);
    }
    // More often than a recording may end its reader: that many times it is not the recording's fault.
    wait_for("no child could be started several times", || {
        let log = std::fs::read_to_string(&service.log).unwrap();
        log.matches("no process could be started").count() > 3
    });
    run(
        "prlimit",
        &["--pid", &process, &format!("--nofile={soft}:")],
    );
    let job = format!("/v1/jobs/{}", job.as_str().unwrap());
    wait_for("it is answered", || {
        let state = client.get(&job).expect(200).json()["state"].clone();
        assert_ne!(state, "refused", "{}", client.get(&job).text());
        state == "done"
    });
}

/// Connections must not be able to take the descriptors that children need.
#[test]
fn cli_too_few_open_files_are_refused_at_start() {
    let folder = Folder::new();
    let data = folder.data().display().to_string();
    let script =
        "ulimit -n 190; exec \"$0\" --listen 127.0.0.1:0 --data \"$1\" --set connections=64";
    let mut command = Command::new("timeout");
    let command = command.args(["300", "sh", "-c", script, crate::support::PROGRAM, &data]);
    let output = command.output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(4), "{text}");
    assert!(
        text.contains("64 connections need 448 open files"),
        "{text}"
    );
}

/// A question that would take hours, by steps far smaller than anybody needs.
fn endless_question(id: &serde_json::Value) -> serde_json::Value {
    let request = json!({"opens_when": "both", "method": "rk4", "steps_per_period": 100_000_000});
    json!({"recording": id, "request": request})
}

/// While a question takes long, its neighbours are answered.
#[test]
fn verif_a_question_that_takes_long_holds_up_no_other() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["order_s=86400", "places=2"]);
    let client = service.client();
    let slow = slow_recording(&client);
    let asked = client.post("/v1/verdicts?wait=0", &endless_question(&slow));
    let job = asked.expect(202).json()["job"].clone();
    let job = format!("/v1/jobs/{}", job.as_str().unwrap());
    let is_at_work = || client.get(&job).expect(200).json()["state"] == "running";
    wait_for("it is at work", is_at_work);
    let id = client.upload("burst.csv")["id"].clone();
    for torque in 0..3 {
        let set = format!("lever.preload_torque_nm=2.{torque}");
        let asking = json!({"recording": id, "request": {"members": 0}, "set": [set]});
        client.post("/v1/verdicts?wait=60", &asking).expect(200);
    }
    assert!(is_at_work(), "{}", client.get(&job).text());
}

/// A question that takes too long is ended, and not refused for ever.
#[test]
fn verif_a_question_that_takes_too_long_is_ended() {
    let folder = Folder::new();
    // A patient service reads the recording first, however long that takes.
    let service = Service::start(&folder, &[]);
    let slow = slow_recording(&service.client());
    assert_eq!(service.end(), 0);
    let service = Service::start(&folder, &["order_s=2", "wait_s=60"]);
    let client = service.client();
    let asking = endless_question(&slow);
    let job = client.post("/v1/verdicts?wait=0", &asking).expect(202);
    let job = job.json()["job"].clone();
    let job = format!("/v1/jobs/{}", job.as_str().unwrap());
    let mut ended = serde_json::Value::Null;
    wait_for("it is ended", || {
        ended = client.get(&job).expect(200).json();
        ended["state"] == "refused"
    });
    // What took too long here may be answered by a machine with less to do.
    let problem = &ended["problem"];
    assert_eq!(problem["code"], "reader-was-late", "{ended}");
    assert_eq!(problem.get("verdict"), None, "{ended}");
    let detail = problem["detail"].as_str().unwrap();
    assert!(detail.contains("longer than 2 s"), "{detail}");
    // Another time it may be answered: it is worked on again, not refused from the store.
    client.post("/v1/verdicts?wait=0", &asking).expect(202);
}

/// Begins a form in chunks.
fn begun_form(service: &Service) -> TcpStream {
    let mut stream = TcpStream::connect(&service.address).unwrap();
    stream.set_read_timeout(Some(HANG)).unwrap();
    stream.set_write_timeout(Some(HANG)).unwrap();
    let host = &service.address;
    let head = format!(
        "POST /v1/recordings HTTP/1.1\r\nHost: {host}\r\nTransfer-Encoding: chunked\r\n\
         Content-Type: multipart/form-data; boundary=part\r\n\r\n"
    );
    stream.write_all(head.as_bytes()).unwrap();
    stream
}

/// Sends chunks until they are no longer taken; returns how many bytes were, and the answer.
fn sent_until_refused(
    mut stream: TcpStream,
    pieces: impl Iterator<Item = Vec<u8>>,
) -> (u64, String) {
    let mut sent = 0;
    for piece in pieces {
        let mut chunk = format!("{:x}\r\n", piece.len()).into_bytes();
        chunk.extend_from_slice(&piece);
        chunk.extend_from_slice(b"\r\n");
        if stream.write_all(&chunk).is_err() {
            break;
        }
        sent += piece.len() as u64;
        // What lies in the buffers of the system is not taken: it must be read before more is sent.
        wait_for("what was sent is read, or the form is refused", || {
            served_end(&stream) != ServedEnd::Unread
        });
    }
    let mut answer = Vec::new();
    let _ = std::io::Read::read_to_end(&mut stream, &mut answer);
    (sent, String::from_utf8_lossy(&answer).into_owned())
}

/// What a form holds beside its files is bounded: before the first part, in a part's head, and in all.
#[test]
fn regress_a_form_is_bounded_beside_its_files() {
    let folder = Folder::new();
    let service = Service::start(&folder, &["upload_mib=1", "rate_burst=100000"]);
    let filler = || std::iter::repeat_n(vec![b'x'; 8 << 10], 10 << 7);
    let disposition = "--part\r\nContent-Disposition: form-data; name=\"file\"; filename=\"";
    for begin in ["", disposition] {
        let mut stream = begun_form(&service);
        let first = format!("{:x}\r\n{begin}\r\n", begin.len());
        if !begin.is_empty() {
            stream.write_all(first.as_bytes()).unwrap();
        }
        let (sent, answer) = sent_until_refused(stream, filler());
        assert!(sent <= 256 << 10, "{sent} bytes were taken: {answer}");
        // The answer may be lost where the rest of the body is not taken.
        assert!(
            answer.is_empty() || answer.contains("form_head_bytes"),
            "{answer}"
        );
    }
    // Many parts, each with a head that is long enough to matter in all.
    let part = |number: u32| {
        let head = format!(
            "{disposition}{number}.csv\"\r\nX: {}\r\n\r\n",
            "x".repeat(8 << 10)
        );
        format!("{head}t\r\n").into_bytes()
    };
    let (sent, answer) = sent_until_refused(begun_form(&service), (0..500).map(part));
    assert!(sent <= 3 << 20, "{sent} bytes were taken: {answer}");
    // A form with many small parts, and one with a file that looks like a boundary, are taken.
    let names: Vec<String> = (0..300).map(|number| format!("{number:03}.csv")).collect();
    let table = signal("burst.csv");
    let odd = b"t_s,acc_y_g\n\r\n--par\r\r\n";
    let parts: Vec<(&str, &str, &[u8])> = names
        .iter()
        .map(|name| ("part", name.as_str(), &odd[..]))
        .chain([("file", "a.csv", &table[..])])
        .collect();
    let client = service.client();
    let recording = client.upload_form("?name=many", &parts).expect(201).json();
    let bytes = 300 * odd.len() + table.len();
    assert_eq!(recording["bytes"], bytes, "{recording}");
}

/// Uploads of each kind; `LATCHGATE_SERVICE_UPLOADS` says how many.
fn uploads() -> u32 {
    std::env::var("LATCHGATE_SERVICE_UPLOADS").map_or(12, |text| text.parse().unwrap())
}

/// Among as many uploads that are no recordings, every good one is judged right.
#[test]
fn verif_hostile_uploads_harm_no_good_one() {
    let folder = Folder::new();
    let service = Service::start(&folder, &[]);
    let client = service.client();
    let ask = |id: &serde_json::Value, number: u32| {
        let set = format!("lever.preload_torque_nm=2.{number:03}");
        json!({"recording": id, "request": {"members": 0}, "set": [set]})
    };
    let hostile = client.clone();
    let hostile = std::thread::spawn(move || {
        let good = signal("burst_imu.mcap");
        let mut state = 1_u64;
        for number in 0..uploads() {
            let mut bytes = good.clone();
            for _ in 0..20 {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                let at = (state >> 33) as usize % bytes.len();
                bytes[at] = (state >> 25) as u8;
            }
            let name = ["a.mcap", "a.csv", "a.ev5", "a.zip", "a.lvm"][number as usize % 5];
            let path = format!("/v1/recordings?name={number}{name}");
            let answer = hostile.send("POST", &path, &bytes);
            assert!(
                answer.status == 201 || answer.status == 503,
                "{}",
                answer.text()
            );
            if answer.status == 201 {
                let asking = json!({"recording": answer.json()["id"], "request": {"members": 0}});
                let status = hostile.post("/v1/verdicts?wait=60", &asking).status;
                assert!(matches!(status, 200 | 422), "{status}");
            }
        }
    });
    let lever = latchgate::pipeline::Design::reference();
    let card = std::fs::read(crate::support::root().join("signals/burst.csv.toml")).unwrap();
    let source = latchgate::pipeline::Source::bytes("burst.csv", signal("burst.csv"));
    let source = source.with_card(card.clone());
    let request = serde_json::from_str(r#"{"members": 0}"#).unwrap();
    let (limits, control) = Default::default();
    let prepared =
        latchgate::pipeline::Prepared::open(&source, &request, &limits, &control).unwrap();
    for number in 0..uploads() {
        let mut design = lever.clone();
        let preload = format!("lever.preload_torque_nm=2.{number:03}");
        latchgate::pipeline::apply_override(&mut design, &preload).unwrap();
        let expected = prepared
            .judge(&design, Default::default(), &control)
            .document;
        let name = format!("good-{number}.csv");
        let good = client.upload_bytes(&name, &signal("burst.csv"), Some(&card));
        let id = good.expect(201).json()["id"].clone();
        let served = client
            .post("/v1/verdicts?wait=60", &ask(&id, number))
            .expect(200)
            .json();
        assert_eq!(served["verdict"], expected.verdict.name());
        let peak = expected.nominal.map(|run| run.peak_angle_rad);
        assert_eq!(served["nominal"]["peak_angle_rad"].as_f64(), peak);
    }
    hostile.join().unwrap();
}

/// Sends 200 requests that stop in the head or in the body.
fn stalled(service: &Service) -> Vec<TcpStream> {
    let begin = |number: usize| {
        let mut stream = TcpStream::connect(&service.address).unwrap();
        let head = "POST /v1/recordings?name=a.csv HTTP/1.1\r\nHost: 127.0.0.1\r\n";
        stream.write_all(head.as_bytes()).unwrap();
        if number.is_multiple_of(2) {
            stream
                .write_all(b"Content-Length: 1000000\r\n\r\nt_s,")
                .unwrap();
        }
        stream
    };
    (0..200).map(begin).collect()
}

/// Clients that send their heads and bodies drop by drop hold up nobody: others are answered while
/// each of them is still there.
#[test]
fn verif_slow_clients_hold_up_nobody() {
    let folder = Folder::new();
    let patient = ["header_s=3600", "body_s=3600", "address_connections=1024"];
    let service = Service::start(&folder, &patient);
    let client = service.client();
    let slow = stalled(&service);
    let id = client.upload("burst.csv")["id"].clone();
    let question = json!({"recording": id, "request": {"members": 0}});
    client.post("/v1/verdicts?wait=60", &question).expect(200);
    let held = slow
        .iter()
        .filter(|stream| served_end(stream) != ServedEnd::Closed)
        .count();
    assert_eq!(held, slow.len(), "none was let go of before");
}

/// Clients that send nothing for a while are let go of.
#[test]
fn verif_stalled_clients_are_let_go_of() {
    let folder = Folder::new();
    let impatient = ["header_s=2", "body_s=2", "address_connections=1024"];
    let service = Service::start(&folder, &impatient);
    for mut stream in stalled(&service) {
        stream.set_read_timeout(Some(HANG)).unwrap();
        let mut answer = Vec::new();
        let read = std::io::Read::read_to_end(&mut stream, &mut answer);
        assert!(read.is_ok() || !answer.is_empty(), "{read:?}");
    }
}
