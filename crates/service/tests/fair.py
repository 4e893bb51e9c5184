#!/usr/bin/env python3
"""What one owner's work costs another: upload, verdict and what-if alone, and beside two sliders and a large gate;
a question alone, and beside silent clients.

    cargo build --release -p latchgate-service
    crates/service/tests/fair.py [FOLDER OF THE PROGRAM]

On a machine with other work start it with `nice -n -10`. Prints figures; ends with 1 where one of them is beyond what
docs/service.md states."""

import http.client, json, os, pathlib, socket, statistics, subprocess, sys, tempfile, threading, time

ROOT = pathlib.Path(__file__).resolve().parents[3]
PROGRAM = (pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "target/release") / "latchgate-serve"
SIGNAL, CARD = ROOT / "signals/burst.csv", ROOT / "signals/burst.csv.toml"
REPEATS = 12
failed, numbers = [], iter(range(1, 1 << 30))


def check(what, value, most, unit):
    print(f"{what}: {value:.3g} {unit} (at most {most:g})", flush=True)
    if value > most:
        failed.append(what)


class Service:
    def __init__(self):
        self.data = tempfile.TemporaryDirectory()
        # A place for each of two cores.
        command = [PROGRAM, "--listen", "127.0.0.1:0", "--data", self.data.name, "--set", "places=2", "--set", "log=warn"]
        self.tokens = {name: self.token(name) for name in ("lab", "much")}
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        self.address = self.process.stdout.readline().split("http://")[1].split("/")[0]

    def token(self, name):
        command = [PROGRAM, "token", "create", name, "--scopes", "read,submit", "--data", self.data.name]
        return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.strip()

    def ask(self, owner, method, path, body=b"", kind="application/json"):
        connection = http.client.HTTPConnection(self.address, timeout=120)
        headers = {"Authorization": f"Bearer {self.tokens[owner]}", "Content-Type": kind}
        connection.request(method, path, body, headers)
        answer = connection.getresponse()
        text = answer.read()
        connection.close()
        return answer.status, text

    def upload(self, owner):
        parts = [("file", f"burst{next(numbers)}.csv", SIGNAL), ("card", CARD.name, CARD)]
        body = b"".join(
            b'--p\r\nContent-Disposition: form-data; name="%s"; filename="%s"\r\n\r\n%s\r\n'
            % (role.encode(), name.encode(), path.read_bytes()) for role, name, path in parts) + b"--p--\r\n"
        status, text = self.ask(owner, "POST", "/v1/recordings", body, "multipart/form-data; boundary=p")
        assert status == 201, text
        return json.loads(text)["id"]

    def question(self, owner, path, recording):
        # Each is another one: what is known costs nothing.
        torque = f"lever.preload_torque_nm={2.5 + next(numbers) * 1e-5:.5f}"
        status, text = self.ask(owner, "POST", path, json.dumps({"recording": recording, "set": [torque]}))
        assert status == 200, (status, text)

    def end(self):
        self.process.terminate()
        self.process.wait()
        self.data.cleanup()


def medians(service):
    times = {"upload": [], "verdict": [], "what-if": []}

    def timed(what, work):
        began = time.monotonic()
        result = work()
        times[what].append(time.monotonic() - began)
        return result

    for _ in range(REPEATS):
        recording = timed("upload", lambda: service.upload("lab"))
        timed("verdict", lambda: service.question("lab", "/v1/verdicts?wait=60", recording))
        timed("what-if", lambda: service.question("lab", "/v1/what-if", recording))
    return {what: statistics.median(taken) for what, taken in times.items()}


def beside_much_work():
    service = Service()
    alone = medians(service)
    recordings = [service.upload("much") for _ in range(20)]
    designs = "".join(f'[[designs]]\nname = "d{number}"\nset = ["lever.preload_torque_nm={2 + number * 0.01:.2f}"]\n'
                      for number in range(50))
    gate = f'[[recordings]]\nfiles = ["burst*.csv"]\n{designs}'
    status, text = service.ask("much", "POST", "/v1/gates?name=many", gate, "application/toml")
    assert status == 202, text
    entry, ends, answers = json.loads(text), threading.Event(), []

    def slide(number):
        while not ends.is_set():
            service.question("much", "/v1/what-if", recordings[number])
            answers.append(number)

    sliders = [threading.Thread(target=slide, args=(number,)) for number in range(2)]
    for slider in sliders:
        slider.start()
    began = time.monotonic()
    beside = medians(service)
    took = time.monotonic() - began
    ends.set()
    for slider in sliders:
        slider.join()
    decided = json.loads(service.ask("much", "GET", f"/v1/gates/{entry['id']}")[1])["decided"]
    service.end()
    print(f"meanwhile {decided} of {entry['pairs']} pairs decided, {len(answers) / took:.0f} answers a second to two sliders")
    assert decided < entry["pairs"] or took < 1, "the gate ended first"
    for what, time_s in alone.items():
        print(f"{what}: {1e3 * time_s:.0f} ms alone, {1e3 * beside[what]:.0f} ms beside")
        check(f"{what}, beside to alone", beside[what] / time_s, 2, "")


def beside_silent_clients(count=100):
    service = Service()

    def slowest():
        times = []
        for _ in range(30):
            began = time.monotonic()
            status, _ = service.ask("lab", "POST", "/v1/verdicts", json.dumps({"recording": "none"}))
            assert status == 404
            times.append(time.monotonic() - began)
        return 1e3 * max(times)

    alone, silent = slowest(), []
    host, port = service.address.split(":")
    for _ in range(count):
        silent.append(socket.create_connection((host, int(port))))
        silent[-1].sendall(b"POST /v1/verdicts HTTP/1.1\r\nHost: latch\r\nAuthorization: Bearer %s\r\n"
                           b"Content-Length: 1048576\r\n\r\n" % service.tokens["lab"].encode())
    time.sleep(0.3)
    print(f"the slowest of 30 questions alone: {alone:.1f} ms")
    check(f"beside {count} silent clients", slowest(), 100, "ms")
    for connection in silent:
        connection.close()
    service.end()


beside_silent_clients()
beside_much_work()
print("beyond what is stated: " + ", ".join(failed) if failed else "all as stated")
sys.exit(1 if failed else 0)
