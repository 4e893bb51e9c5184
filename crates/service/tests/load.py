#!/usr/bin/env python3
"""Load on the loopback, open loop: what a verdict costs over HTTP and in the command line's process,
how long a what-if takes, what becomes of more than can be done.

    cargo build --release -p latchgate -p latchgate-service
    crates/service/tests/load.py [FOLDER OF THE PROGRAMS]

Prints figures; ends with 1 where one of them is beyond what docs/service.md states."""

import http.client, json, os, pathlib, resource, statistics, subprocess, sys, tempfile, threading, time

ROOT = pathlib.Path(__file__).resolve().parents[3]
PROGRAMS = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "target/release"
SIGNAL, CARD = ROOT / "signals/burst.csv", ROOT / "signals/burst.csv.toml"
TICKS = os.sysconf("SC_CLK_TCK")
failed = []


def cpu_of(process):
    """Processor seconds of a process, its threads and its children, those that ended too."""
    total = 0
    tree = [process]
    while tree:
        pid = tree.pop()
        try:
            fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
            total += sum(int(field) for field in fields[11:15])
            for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
                tree += (task / "children").read_text().split()
        except OSError:
            pass
    return total / TICKS


def memory_of(process):
    """Largest memory of a process and of its children that run [MiB]."""
    children = (task / "children" for task in pathlib.Path(f"/proc/{process}/task").iterdir())
    tree = [process] + [pid for ids in children for pid in ids.read_text().split()]
    texts = (pathlib.Path(f"/proc/{pid}/status").read_text() for pid in tree)
    return sum(int(text.split("VmHWM:")[1].split()[0]) for text in texts) / 1024


class Service:
    def __init__(self, *settings):
        self.data = tempfile.TemporaryDirectory()
        command = [PROGRAMS / "latchgate-serve", "--listen", "127.0.0.1:0", "--data", self.data.name]
        for setting in ("log=warn", "rate_per_s=100000", "rate_burst=100000") + settings:
            command += ["--set", setting]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.address = self.process.stdout.readline().split("http://")[1].split("/")[0]

    def ask(self, method, path, body=b"", kind="application/json"):
        connection = http.client.HTTPConnection(self.address, timeout=120)
        connection.request(method, path, body, {"Content-Type": kind})
        answer = connection.getresponse()
        text = answer.read()
        connection.close()
        return answer.status, answer.headers, text

    def upload(self):
        parts = [("file", SIGNAL), ("card", CARD)]
        body = b"".join(
            b'--p\r\nContent-Disposition: form-data; name="%s"; filename="%s"\r\n\r\n%s\r\n'
            % (role.encode(), path.name.encode(), path.read_bytes()) for role, path in parts) + b"--p--\r\n"
        status, _, text = self.ask("POST", "/v1/recordings", body, "multipart/form-data; boundary=p")
        assert status in (200, 201), text
        return json.loads(text)["id"]

    def end(self):
        self.process.terminate()
        self.process.wait()
        self.data.cleanup()


def question(recording, number, **request):
    torque = f"lever.preload_torque_nm={2 + number * 1e-4:.4f}"
    return json.dumps({"recording": recording, "request": request, "set": [torque]})


def check(what, value, most, unit):
    print(f"{what}: {value:.4g} {unit} (at most {most:g})")
    if value > most:
        failed.append(what)


def of_a_verdict(count=60):
    began = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as out:
        for number in range(count):
            subprocess.run([PROGRAMS / "latchgate", "replay", SIGNAL, "--threads", "1", "--set",
                            f"lever.preload_torque_nm={2 + number * 1e-4:.4f}", "--out", f"{out}/{number}"],
                           stdout=subprocess.DEVNULL)
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    alone = (ended.ru_utime + ended.ru_stime - began.ru_utime - began.ru_stime) / count
    service = Service()
    recording = service.upload()
    service.ask("POST", "/v1/verdicts?wait=60", question(recording, 9999))
    began = cpu_of(service.process.pid)
    for number in range(count):
        status, _, text = service.ask("POST", "/v1/verdicts?wait=60", question(recording, number))
        assert status == 200, text
    served = (cpu_of(service.process.pid) - began) / count
    service.end()
    print(f"processor time of a verdict with its report: {1e3 * served:.1f} ms served, {1e3 * alone:.1f} ms by the command line")
    check("ratio of the two", served / alone, 1.25, "")


def of_a_first_answer(count=12):
    service = Service()
    recording = service.upload()
    service.ask("POST", "/v1/verdicts?wait=60", question(recording, 9999))
    answers, ends = [], []
    for number in range(count):
        began = time.monotonic()
        status, headers, _ = service.ask("POST", "/v1/verdicts?wait=0", question(recording, 7000 + number))
        assert status == 202, status
        connection = http.client.HTTPConnection(service.address, timeout=120)
        connection.request("GET", headers["Location"] + "/events")
        known = None
        for line in connection.getresponse():
            if known is None and b'"first_answer":{' in line:
                known = time.monotonic() - began
            if line.startswith(b"event: done"):
                break
        connection.close()
        answers.append(known)
        ends.append(time.monotonic() - began)
    service.end()
    print(f"a verdict: its answer after {1e3 * statistics.median(answers):.0f} ms, advice and report after "
          f"{1e3 * statistics.median(ends):.0f} ms (medians of {count})")


def of_a_gate(count=300):
    designs = "".join(f'[[designs]]\nname = "d{number:03}"\nset = {{ "lever.preload_torque_nm" = {2 + number * 1e-3:.3f} }}\n'
                      for number in range(count))
    text = f'[[recordings]]\nfiles = "burst.csv"\n{designs}'
    with tempfile.TemporaryDirectory() as place:
        place = pathlib.Path(place)
        for path in (SIGNAL, CARD):
            (place / path.name).write_bytes(path.read_bytes())
        (place / "gate.toml").write_text(text)
        began = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([PROGRAMS / "latchgate", "gate", "gate.toml", "--no-store", "--reports", "none", "--out", "out"],
                       cwd=place, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    alone = (ended.ru_utime + ended.ru_stime - began.ru_utime - began.ru_stime) / count
    service = Service()
    service.upload()
    began, clock = cpu_of(service.process.pid), time.monotonic()
    entry = json.loads(service.ask("POST", "/v1/gates", text)[2])
    # Until its end: the full reports of the worst come after that.
    service.ask("GET", f"/v1/gates/{entry['id']}/events")
    served, took = (cpu_of(service.process.pid) - began) / count, time.monotonic() - clock
    service.end()
    print(f"processor time of a pair of a gate: {1e3 * served:.1f} ms served, {1e3 * alone:.1f} ms by the command line; "
          f"{count} pairs after {took:.1f} s")


def of_a_what_if(count=300, per_s=10):
    service = Service()
    recording = service.upload()
    service.ask("POST", "/v1/what-if", question(recording, 0))
    times, threads, began = [], [], time.monotonic()

    def one(number):
        at = began + number / per_s
        time.sleep(max(0.0, at - time.monotonic()))
        status, _, text = service.ask("POST", "/v1/what-if", question(recording, number))
        assert status == 200, text
        # From when it was due, not from when it was sent.
        times.append(time.monotonic() - at)

    for number in range(count):
        threads.append(threading.Thread(target=one, args=(number,)))
        threads[-1].start()
    for thread in threads:
        thread.join()
    service.end()
    times.sort()
    print(f"what-if, {per_s} a second: median {1e3 * times[count // 2]:.1f} ms")
    check("what-if at the 95th percentile", 1e3 * times[int(count * 0.95)], 100, "ms")


def of_overload(seconds=15):
    service = Service("queue=40", "own_queue=40")
    recording = service.upload()
    began, done = time.monotonic(), 0
    while time.monotonic() - began < 5:
        status, _, _ = service.ask("POST", "/v1/verdicts?wait=60", question(recording, 50_000 + done, members=0))
        assert status == 200
        done += 1
    per_s = 4 * done / 5 * (os.cpu_count() or 1)
    counts, accepted, threads, late = {}, [], [], []
    began = time.monotonic()

    def one(number):
        at = began + number / per_s
        time.sleep(max(0.0, at - time.monotonic()))
        status, headers, text = service.ask("POST", "/v1/verdicts?wait=0", question(recording, number, members=0))
        counts[status] = counts.get(status, 0) + 1
        late.append(time.monotonic() - at)
        if status in (200, 202):
            accepted.append(headers["Location"])
        else:
            assert status in (429, 503) and headers["Retry-After"], text

    for number in range(int(per_s * seconds)):
        threads.append(threading.Thread(target=one, args=(number,)))
        threads[-1].start()
        time.sleep(max(0.0, began + number / per_s - time.monotonic()))
    for thread in threads:
        thread.join()
    for place in accepted:
        while place.startswith("/v1/jobs"):
            standing = json.loads(service.ask("GET", place)[2])
            assert standing["state"] != "refused", standing
            place = standing["verdict"] or place
            time.sleep(0 if standing["verdict"] else 0.05)
    memory = memory_of(service.process.pid)
    service.end()
    late.sort()
    print(f"four times overload, {per_s:.0f} a second for {seconds} s: {counts}; all {len(accepted)} accepted were answered; "
          f"answers at the 95th percentile after {1e3 * late[int(len(late) * 0.95)]:.0f} ms")
    check("memory of the service and its children", memory, 512, "MiB")


of_a_verdict()
of_a_first_answer()
of_a_gate()
of_a_what_if()
of_overload()
print("beyond what is stated: " + ", ".join(failed) if failed else "all as stated")
sys.exit(1 if failed else 0)
