"""Shares of a gate on a real Slurm, on Dask, and by a manifest of Kubernetes.

Whatever is killed meanwhile, the collected table is that of one undisturbed process, byte for byte. The
faults of the storm: LATCHGATE_STORM of them (40 unless it is set; of 200 each requeue costs two minutes, which Slurm waits), from
LATCHGATE_SEED, which is printed. With LATCHGATE_LONG=1 and a release build what docs/scale.md states is measured, too.
Run by tests/slurm/run.
"""

import atexit
import json
import math
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request
from pathlib import Path

import yaml

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
LATCHGATE = os.environ.get("LATCHGATE", str(ROOT / "target/debug/latchgate"))
STORM = int(os.environ.get("LATCHGATE_STORM", "40"))
SEED = int(os.environ.get("LATCHGATE_SEED", "7"))
# An ordinary device that can be full; made by tests/slurm/run.
SMALL_DISK = os.environ.get("LATCHGATE_SMALL_DISK")


def shown(language):
    """The one block of that language in docs/scale.md."""
    blocks = (ROOT / "docs/scale.md").read_text().split(f"```{language}\n")[1:]
    assert len(blocks) == 1, f"{len(blocks)} blocks of {language}"
    return blocks[0].split("```")[0]


BEGUN = []


def begin(words, log, **options):
    """Begins a process that ends with this one at the latest."""
    process = subprocess.Popen([str(word) for word in words], stdin=subprocess.DEVNULL, stdout=log, stderr=log, **options)
    BEGUN.append(process)
    return process


def scratch(prefix):
    """A folder that goes with this process at the latest."""
    folder = Path(tempfile.mkdtemp(prefix=prefix))
    atexit.register(shutil.rmtree, folder, True)
    return folder


@atexit.register
def end_all():
    for process in BEGUN:
        if process.poll() is None:
            process.kill()
            process.wait()


def interrupted(*_):
    # The one exception that a test lets through; what was begun ends behind it.
    raise KeyboardInterrupt


def call(*words, cwd=None, timeout=600, environment=None):
    return subprocess.run(
        [str(word) for word in words], cwd=cwd, timeout=timeout, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL,
        env={**os.environ, **(environment or {})},
    )


def fill(folder, recordings, designs, members, rate_hz=10_000):
    """Writes a gate of pulses that grow and preloads that grow."""
    (folder / "recordings").mkdir(parents=True)
    for number in range(recordings):
        write_recording(folder, number, 4 + 30 * number / recordings, rate_hz)
    text = f'[[recordings]]\nfiles = "recordings/*.csv"\nopens_when = "negative"\nmembers = {members}\n'
    for number in range(designs):
        preload = 0.6 + 6 * number / designs
        text += f'[[designs]]\nname = "d{number:03}"\nset = {{ "lever.preload_torque_nm" = {preload:.4f} }}\n'
    (folder / "gate.toml").write_text(text)


def write_recording(folder, number, peak_g, rate_hz):
    lines = ["time_s,acc_y_g"]
    for index in range(-rate_hz // 50, 3 * rate_hz // 50):
        time_s = index / rate_hz
        pulse = -peak_g * math.sin(math.pi * time_s / 0.03) if 0 <= time_s < 0.03 else 0.0
        lines.append(f"{time_s:.4f},{pulse + 0.01 * math.sin(time_s * 9100):.6f}")
    (folder / f"recordings/r{number:04}.csv").write_text("\n".join(lines) + "\n")
    # Nothing is drawn of the noise of a formula: many pairs are judged in a moment.
    (folder / f"recordings/r{number:04}.csv.toml").write_text("synthetic = true\n")


class Sweep(unittest.TestCase):
    """A folder of its own for each test."""

    def setUp(self):
        self.folder = scratch("latchgate-sweep-")
        self.addCleanup(shutil.rmtree, self.folder, True)

    def gate(self, *words, **options):
        return call(LATCHGATE, "gate", "gate.toml", "--reports", "none", *words, cwd=self.folder, **options)

    def with_latchgate(self):
        """An environment in which a command named latchgate is the one under test."""
        tools = self.folder / "tools"
        tools.mkdir(exist_ok=True)
        link = tools / "latchgate"
        if not link.exists():
            link.symlink_to(Path(LATCHGATE).resolve())
        return {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"}

    def undisturbed(self):
        """What one process makes of the gate."""
        part = self.gate("--store", "alone", "--part", "1/1", timeout=1800)
        self.assertEqual(part.returncode, 0, part.stderr)
        collected = self.gate("--store", "alone", "--collect", "--out", "alone-out")
        return collected.returncode, self.table("alone-out")

    def collected(self):
        done = self.gate("--store", "store", "--collect", "--out", "out")
        return done.returncode, self.table("out")

    def table(self, out):
        """The answers of all pairs."""
        return (self.folder / out / "summary.csv").read_bytes()


class Cluster:
    """The cluster of tests/slurm/cluster."""

    def __init__(self):
        self.folder = scratch("latchgate-slurm-")
        atexit.register(self.end)
        self.tool("start", self.folder, check=True)
        os.environ["SLURM_CONF"] = str(self.folder / "slurm.conf")

    def tool(self, what, *words, check=False):
        # Its daemons must not hold a pipe of ours open.
        with open(self.folder / "tool.log", "a") as log:
            subprocess.run([str(HERE / "cluster"), what, *map(str, words)], check=check, stdin=subprocess.DEVNULL,
                           stdout=log, stderr=log)

    def pid(self, name):
        return int((self.folder / f"run/{name}.id").read_text())

    def kill(self, name):
        try:
            os.kill(self.pid(name), signal.SIGKILL)
        except ProcessLookupError:
            pass

    def begin(self, name):
        self.tool("daemon", self.folder, name)

    def scripts(self):
        """Processes of tasks: those that watch a share, and those that collect."""
        found = []
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                words = (folder / "cmdline").read_bytes().split(b"\0")
                environment = (folder / "environ").read_bytes()
            except OSError:
                continue
            own = f"SLURM_CONF={self.folder}".encode() in environment and b"SLURM_JOB_ID=" in environment
            if own and b"gate" in words and b"--worker" not in words:
                found.append(int(folder.name))
        return found

    def end(self):
        if self.folder.exists():
            self.tool("stop", self.folder)
            shutil.rmtree(self.folder, True)


class OnSlurm(Sweep):
    @classmethod
    def setUpClass(cls):
        cls.cluster = Cluster()
        cls.addClassCleanup(cls.cluster.end)

    def test_shares_are_submitted_collected_and_waited_for(self):
        fill(self.folder, 12, 6, 0)
        code, alone = self.undisturbed()
        # More shares than an array holds.
        done = self.gate("--store", "store", "--out", "out", "--submit", "slurm", "--parts", "25", "--wait", "--",
                         "--partition=main")
        self.assertEqual(done.returncode, code, done.stderr + self.printed())
        self.assertEqual(self.table("out"), alone)
        jobs = json.loads((self.folder / "store/engine/gate.toml.jobs.json").read_text())
        self.assertEqual([offset for _, offset in jobs["arrays"]], [0, 20])
        status = self.gate("--store", "store", "--status", "--format", "json")
        standing = json.loads(status.stdout)
        self.assertEqual((standing["done"], standing["missing"]), (72, 0))
        # The job that collects may be ending still.
        self.assertIsInstance(standing["engine"].pop("collecting"), bool)
        self.assertEqual(standing["engine"], {"name": "slurm", "running": 0, "waiting": 0, "stuck": 0})
        again = self.gate("--store", "store", "--resubmit")
        self.assertIn("nothing is missing", again.stderr)

    def serve(self):
        """Starts a service that hands every gate of several pairs over; returns it and its address."""
        serve = Path(LATCHGATE).with_name("latchgate-serve")
        settings = ["engine_from_pairs=1", "engine_share_pairs=6", "engine_options=--partition=main"]
        words = [serve, "--data", self.folder / "data", "--listen", "127.0.0.1:0", "--engine", "slurm"]
        words += [word for setting in settings for word in ("--set", setting)]
        with open(self.folder / "served", "a") as log:
            service = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=log, text=True)
        BEGUN.append(service)
        with service.stdout:
            return service, service.stdout.readline().split()[2].rstrip("/,")

    def test_the_service_hands_a_large_gate_over_and_finds_it_again(self):
        fill(self.folder, 8, 3, 50)
        # An upload is one file.
        for card in (self.folder / "recordings").glob("*.toml"):
            card.unlink()
        service, address = self.serve()

        def ask(path, body=None, kind="text/csv"):
            request = urllib.request.Request(address + path, body, {"Content-Type": kind} if body else {})
            with urllib.request.urlopen(request, timeout=60) as answer:
                return json.load(answer)

        for path in sorted((self.folder / "recordings").iterdir()):
            ask(f"/v1/recordings?name={path.name}", path.read_bytes())
        text = (self.folder / "gate.toml").read_text().replace("recordings/", "")
        gate = ask("/v1/gates?name=large", text.encode(), "application/toml")
        place = "/v1/gates/" + gate["id"]
        seen = [ask(place)]
        while seen[-1]["state"] == "running":
            self.assertEqual(seen[-1]["engine"], "slurm")
            if len(seen) == 3:
                service.kill()
                service.wait()
                service, address = self.serve()
            time.sleep(0.5)
            seen.append(ask(place))
        last = seen[-1]
        self.assertEqual((last["state"], last["decided"]), ("done", 24), last)
        self.assertGreater(len(seen), 3, "it was done before the service was killed")
        alone = self.gate("--no-store", "--out", "alone-out")
        self.assertEqual(last["exit_code"], alone.returncode, alone.stderr)
        here = json.loads((self.folder / "alone-out/summary.json").read_text())
        rows = [pair["row"] for pair in ask(place + "/summary.json")["pairs"]]
        self.assertEqual(rows, [pair["row"] for pair in here["pairs"]])
        service.terminate()
        service.wait()

    def test_a_recording_that_aborts_is_named_and_the_others_are_judged(self):
        fill(self.folder, 4, 3, 0)
        rows = "".join(f"{k / 1e5 - 0.02:.5f},{k % 7}\n" for k in range(400_000))
        (self.folder / "recordings/r0001.csv").write_text("time_s,acc_y_g\n" + rows)
        # The tasks run under the submitting shell's limits.
        done = call("sh", "-c", f'ulimit -c 0; ulimit -v 60000; exec "{LATCHGATE}" gate gate.toml --reports none '
                    "--store store --out out --submit slurm --parts 2 --wait", cwd=self.folder)
        self.assertEqual(done.returncode, 4, done.stderr + self.printed())
        printed = self.printed()
        self.assertIn("SIGABRT", printed)
        self.assertIn("recordings/r0001.csv: begun twice and never finished", printed)
        status = json.loads(self.gate("--store", "store", "--status", "--format", "json").stdout)
        self.assertEqual((status["done"], status["missing"]), (9, 3))
        self.assertEqual(status["never_ended"], ["recordings/r0001.csv"])
        self.assertFalse((self.folder / "out").exists())

    def test_what_never_comes_is_submitted_three_times_and_listed(self):
        fill(self.folder, 4, 2, 0)
        write = self.folder / "recordings/r0002.csv"
        submitted = self.gate("--store", "store", "--submit", "slurm", "--parts", "4", "--", "--begin=now+3")
        self.assertEqual(submitted.returncode, 0, submitted.stderr)
        write.write_text(write.read_text().replace("0.0000,", "0.0000,-9", 1))
        jobs = self.folder / "store/engine/gate.toml.jobs.json"
        said, deadline = {}, time.monotonic() + 180
        while not said and time.monotonic() < deadline:
            time.sleep(0.5)
            left = json.loads(jobs.read_text())
            answer = jobs.with_name(f"gate.toml.answer-{left['answer']}.json")
            if left["resubmits"] == 0 and answer.exists():
                said = json.loads(answer.read_text())
        self.assertEqual(said.get("exit_code"), 4, self.printed())
        printed = self.printed()
        self.assertIn("its hash changed since it was submitted", printed)
        self.assertIn("recordings/r0002.csv: 2 pairs", printed)
        self.assertEqual(printed.count("submitted again"), 3)
        self.assertFalse((self.folder / "out").exists())

    def printed(self):
        return "\n".join(path.read_text() for path in sorted((self.folder / "store/engine").glob("*.out")))

    def test_storm(self):
        """Scripts, nodes, controllers and disks fail; the answer is that of a quiet day."""
        print(f"storm: {STORM} faults, seed {SEED}", file=sys.stderr)
        fill(self.folder, 200, 50, int(os.environ.get("LATCHGATE_MEMBERS", "128")))
        code, alone = self.undisturbed()
        if SMALL_DISK:
            (self.folder / "store").symlink_to(tempfile.mkdtemp(dir=SMALL_DISK))
        began = time.monotonic()
        with open(self.folder / "wait.log", "w") as log:
            sweep = begin(
                [LATCHGATE, "gate", "gate.toml", "-vv", "--reports", "none", "--store", "store", "--out", "out",
                 "--submit", "slurm", "--parts", "20", "--wait"], log, cwd=self.folder)
        faults = Faults(self.cluster, self.folder, random.Random(SEED))
        while sweep.poll() is None:
            if faults.count < STORM:
                faults.next()
            faults.mend()
            time.sleep(faults.random.uniform(0.1, 0.6))
            self.assertLess(time.monotonic() - began, 300 + 30 * STORM, faults.told)
        faults.end()
        took = time.monotonic() - began
        judged = self.printed().count("judged recording")
        print(f"storm: {sum(faults.told.values())} faults, {faults.told}; {took:.0f} s; {judged} pairs judged for 10000; "
              f"wait ended with {sweep.returncode}", file=sys.stderr)
        rounds = 0
        while json.loads(self.gate("--store", "store", "--status", "--format", "json").stdout)["missing"]:
            # More was lost than three rounds mend: one more, as a person would.
            rounds += 1
            self.assertLess(rounds, 20)
            again = self.gate("--store", "store", "--resubmit")
            self.assertEqual(again.returncode, 0, again.stderr)
            while call("squeue", "-h", "-t", "R,PD,CG").stdout.strip():
                faults.mend()
                time.sleep(0.5)
        after, found = self.collected()
        self.assertEqual(after, code)
        self.assertEqual(found, alone, "the tables differ")
        if rounds == 0:
            self.assertEqual(sweep.returncode, code)
        self.assertLessEqual(self.printed().count("judged recording"), 10_500)


class Faults:
    """Faults of a cluster, one after the other."""

    KINDS = ["script"] * 5 + ["requeue"] * 2 + ["node", "controller", "drain", "disk"]

    def __init__(self, cluster, folder, chance):
        self.cluster, self.folder, self.random = cluster, folder, chance
        self.count, self.told, self.down = 0, {}, {}

    def next(self):
        kind = self.random.choice(self.KINDS)
        if getattr(self, kind)():
            self.count += 1
            self.told[kind] = self.told.get(kind, 0) + 1

    def script(self):
        scripts = self.cluster.scripts()
        if scripts:
            try:
                os.kill(self.random.choice(scripts), signal.SIGKILL)
            except ProcessLookupError:
                return False
        return bool(scripts)

    def requeue(self):
        tasks = call("squeue", "-h", "-t", "R", "-o", "%A").stdout.split()
        return bool(tasks) and call("scontrol", "requeue", self.random.choice(tasks)).returncode == 0

    def node(self):
        name = self.random.choice(["n1", "n2"])
        if name in self.down:
            return False
        self.cluster.kill(name)
        self.down[name] = time.monotonic() + self.random.uniform(0, 10)
        return True

    def controller(self):
        if "ctld" in self.down:
            return False
        self.cluster.kill("ctld")
        self.down["ctld"] = time.monotonic() + self.random.uniform(0, 3)
        return True

    def drain(self):
        name = self.random.choice(["n1", "n2"])
        return call("scontrol", "update", f"nodename={name}", "state=drain", "reason=storm").returncode == 0

    def disk(self):
        if not SMALL_DISK:
            return False
        ballast = Path(SMALL_DISK) / "ballast"
        with open(ballast, "wb") as file:
            try:
                while True:
                    file.write(bytes(1 << 20))
                    file.flush()
            except OSError:
                pass
        time.sleep(0.5)
        ballast.unlink()
        return True

    def mend(self, everything=False):
        """What an administrator does: starts what is down, lets drained nodes work again."""
        for name, until in list(self.down.items()):
            if everything or time.monotonic() > until:
                self.cluster.begin(name)
                del self.down[name]
        try:
            nodes = call("sinfo", "-h", "-N", "-o", "%N %t", timeout=5).stdout.splitlines()
        except subprocess.TimeoutExpired:
            return
        for line in nodes:
            name, state = line.split()
            if "drain" in state or state.startswith("drng"):
                call("scontrol", "update", f"nodename={name}", "state=resume")

    def end(self):
        self.mend(everything=True)


class OnDask(Sweep):
    """The script of docs/scale.md on a real scheduler and two workers."""

    def setUp(self):
        super().setUp()
        self.processes = {}
        # Below the ports that the kernel gives to connections.
        self.port = 20_000 + os.getpid() % 10_000
        self.addCleanup(self.end)

    def begin(self, name):
        tool = [Path(sys.executable).parent / "dask"]
        words = ["scheduler", "--host", "127.0.0.1", "--port", self.port, "--no-dashboard"]
        if name != "scheduler":
            words = ["worker", f"tcp://127.0.0.1:{self.port}", "--host", "127.0.0.1", "--nthreads", 1, "--nworkers", 1,
                     "--no-nanny", "--no-dashboard", "--death-timeout", 120]
        with open(self.folder / f"{name}.log", "a") as log:
            self.processes[name] = begin(tool + words, log, cwd=self.folder, env=self.with_latchgate())
        if name == "scheduler":
            # On a busy machine it takes long; workers that find nobody end.
            self.until(self.listens)

    def listens(self):
        try:
            socket.create_connection(("127.0.0.1", self.port), timeout=1).close()
            return True
        except OSError:
            return False

    def kill(self, name):
        process = self.processes.pop(name)
        process.kill()
        process.wait()

    def end(self):
        for name in list(self.processes):
            self.kill(name)

    def test_a_worker_and_a_scheduler_are_killed(self):
        fill(self.folder, 24, 20, 512)
        code, alone = self.undisturbed()
        (self.folder / "shares.py").write_text(shown("python"))
        for name in ["scheduler", "one", "two"]:
            self.begin(name)
        with open(self.folder / "example.log", "w") as log:
            example = begin([sys.executable, "shares.py", f"tcp://127.0.0.1:{self.port}"], log, cwd=self.folder,
                            env=self.with_latchgate())
        self.addCleanup(example.kill)
        rows = lambda: len(list((self.folder / "store").glob("*.jsonl")))
        self.until(lambda: rows() >= 1)
        self.kill("one")
        self.until(lambda: rows() >= 2)
        self.kill("scheduler")
        self.assertIsNone(example.poll())
        time.sleep(1)
        for name in ["scheduler", "three", "four"]:
            self.begin(name)
        ended = example.wait(timeout=240)
        told = (self.folder / "example.log").read_text()
        self.assertEqual(ended, code, told)
        self.assertEqual(self.collected(), (code, alone))

    def until(self, holds):
        deadline = time.monotonic() + 180
        while time.monotonic() < deadline:
            if holds():
                return
            time.sleep(0.05)
        told = [f"{path.name}:\n{path.read_text()}" for path in sorted(self.folder.glob("*.log"))]
        self.fail("it did not come to that:\n" + "\n".join(told))


class Interrupted(Sweep):
    """Whoever ends the tests has nothing of a cluster left."""

    def test_nothing_lives_on(self):
        # Else munged ends.
        self.folder.chmod(0o755)
        for number in [signal.SIGTERM, signal.SIGHUP]:
            mark = f"LATCHGATE_MARK={os.getpid()}-{number}"
            with open(self.folder / "interrupted.log", "w") as log:
                tests = begin([sys.executable, "-B", __file__, "OnSlurm.test_storm"], log, cwd=self.folder,
                              env={**os.environ, **dict([mark.split("=")]), "TMPDIR": str(self.folder), "LATCHGATE_MEMBERS": "0",
                                   "LATCHGATE_STORM": "0"})
            deadline = time.monotonic() + 120
            # Not before shares are judged.
            while not {"slurmctld", "slurmd", "munged", "a share"} <= self.marked(mark):
                self.assertIsNone(tests.poll(), (self.folder / "interrupted.log").read_text())
                self.assertLess(time.monotonic(), deadline, self.marked(mark))
                time.sleep(0.1)
            tests.send_signal(number)
            tests.wait(timeout=60)
            # What a task began ends with whoever watches it.
            while self.marked(mark) and time.monotonic() < deadline:
                time.sleep(0.1)
            self.assertEqual(self.marked(mark), set(), signal.Signals(number).name)
            self.assertEqual([path.name for path in self.folder.glob("latchgate-*")], [])

    def marked(self, mark):
        """Names of processes of that mark."""
        found = set()
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                if mark.encode() in (folder / "environ").read_bytes():
                    words = (folder / "cmdline").read_bytes().split(b"\0")
                    own = b"--part" in words and b"--submission" in words
                    found.add("a share" if own else (folder / "comm").read_text().strip())
            except OSError:
                continue
        return found


class Figures(Sweep):
    """What shares cost."""

    def cost(self, what, *words):
        """Processor time [s] and largest memory [MiB] of a gate, whatever it answers."""
        with open(self.folder / "figures.log", "a") as log:
            gate = begin([LATCHGATE, "gate", "gate.toml", "--reports", "none", *words], log, cwd=self.folder)
            memory, ended = 0, False
            while not ended:
                time.sleep(0.02)
                # What wait4 says of memory may be that of the process which forked.
                text = Path(f"/proc/{gate.pid}/status").read_text()
                for line in text.splitlines():
                    if line.startswith("VmHWM:"):
                        memory = int(line.split()[1]) / 1024
                ended, status, used = os.wait4(gate.pid, os.WNOHANG)
            gate.returncode = os.waitstatus_to_exitcode(status)
        cost = used.ru_utime + used.ru_stime, memory
        print(f"{what}: {cost[0]:.1f} s of a processor, {cost[1]:.0f} MiB", file=sys.stderr)
        return cost

    def test_nominal_pairs(self):
        fill(self.folder, 1000, 100, 0)
        gate, _ = self.cost("1000 x 100 nominal pairs, a gate", "--threads", "1", "--no-store", "--out", "a")
        share, _ = self.cost("the same as one share", "--threads", "1", "--store", "s", "--part", "1/1")
        self.cost("collected", "--store", "s", "--collect", "--out", "b")
        self.assertLessEqual(share, 1.1 * gate)
        for name in ["summary.json", "summary.csv", "summary.md"]:
            self.assertEqual((self.folder / "a" / name).read_bytes(), (self.folder / "b" / name).read_bytes())


if not os.environ.get("LATCHGATE_LONG"):
    del Figures


class OnKubernetes(Sweep):
    """The manifest of docs/scale.md: held against the API's schema, and its command run for every index; no cluster
    is at hand."""

    def test_the_manifest_is_valid_and_a_misspelt_one_is_not(self):
        manifest = shown("yaml")
        self.assertEqual(self.validated(manifest), 0)
        for key in ["completionMode", "backoffLimitPerIndex", "podFailurePolicy", "onPodConditions", "claimName"]:
            self.assertIn(key, manifest)
            self.assertNotEqual(self.validated(manifest.replace(key, key[:-1])), 0, key)

    def test_every_index_judges_its_share(self):
        fill(self.folder, 24, 4, 0)
        undisturbed = self.undisturbed()
        job = yaml.safe_load(shown("yaml"))["spec"]
        command = job["template"]["spec"]["containers"][0]["command"]
        for index in range(job["completions"]):
            done = call(*command, cwd=self.folder, environment={**self.with_latchgate(), "JOB_COMPLETION_INDEX": str(index)})
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.collected(), undisturbed)

    def validated(self, text):
        path = self.folder / "job.yaml"
        path.write_text(text)
        tool = Path(sys.executable).parent / "kubernetes-validate"
        return call(tool, "--strict", path).returncode


if __name__ == "__main__":
    for number in [signal.SIGTERM, signal.SIGHUP, signal.SIGINT]:
        signal.signal(number, interrupted)
    unittest.main(verbosity=2)
