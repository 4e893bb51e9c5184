"""Shares of a gate on a real Slurm, on Dask, and by a manifest of Kubernetes, each as docs/scale.md has it.

Whatever is killed meanwhile, the collected table is that of one undisturbed process, byte for byte. With
LATCHGATE_LONG=1 and a release build what docs/scale.md states is measured, too. Run by tests/slurm/run.
"""

import atexit
import json
import math
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import yaml

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
LATCHGATE = os.environ.get("LATCHGATE", str(ROOT / "target/debug/latchgate"))


def shown(language):
    """The one block of that language in docs/scale.md."""
    blocks = (ROOT / "docs/scale.md").read_text().split(f"```{language}\n")[1:]
    assert len(blocks) == 1, f"{len(blocks)} blocks of {language}"
    return blocks[0].split("```")[0]


BEGUN = []


def begin(words, log, **options):
    """Begins a process that ends, with what it began, with this one at the latest."""
    process = subprocess.Popen([str(word) for word in words], stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                               start_new_session=True, **options)
    BEGUN.append(process)
    return process


def scratch(prefix):
    """A folder that goes with this process at the latest."""
    folder = Path(tempfile.mkdtemp(prefix=prefix))
    atexit.register(removed, folder)
    return folder


@atexit.register
def end_all():
    for process in BEGUN:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
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


def removed(folder):
    """Removes a folder; a task that ends just now may still write into it."""
    deadline = time.monotonic() + 30
    while folder.exists() and time.monotonic() < deadline:
        shutil.rmtree(folder, True)
        time.sleep(0.1)


class Sweep(unittest.TestCase):
    """A folder of its own for each test."""

    def setUp(self):
        self.folder = scratch("latchgate-sweep-")
        self.addCleanup(removed, self.folder)

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

    def shares(self):
        """Processes of tasks, by the number of their share: those that watch one."""
        found = {}
        for folder in Path("/proc").glob("[0-9]*"):
            try:
                words = (folder / "cmdline").read_bytes().split(b"\0")
                environment = (folder / "environ").read_bytes()
            except OSError:
                continue
            is_task = f"SLURM_CONF={self.folder}".encode() in environment and b"SLURM_JOB_ID=" in environment
            if is_task and b"--part" in words and b"--worker" not in words:
                found[words[words.index(b"--part") + 1].decode()] = int(folder.name)
        return found

    def end(self):
        if self.folder.exists():
            self.tool("stop", self.folder)
            removed(self.folder)


class OnSlurm(Sweep):
    @classmethod
    def setUpClass(cls):
        cls.cluster = Cluster()
        cls.addClassCleanup(cls.cluster.end)

    def begin(self, shares, limits=""):
        """Begins the script of docs/scale.md with so many shares; tasks run under the limits of who submits them."""
        script = shown("bash")
        self.assertIn("shares=200\n", script)
        (self.folder / "sweep.sh").write_text(script.replace("shares=200\n", f"shares={shares}\n"))
        with open(self.folder / "sweep.log", "w") as log:
            return begin(["bash", "-c", f"{limits} exec bash sweep.sh"], log, cwd=self.folder, env=self.with_latchgate())

    def printed(self):
        """What script and tasks printed."""
        return "\n".join(path.read_text() for path in [self.folder / "sweep.log", *sorted(self.folder.glob("share-*.out"))])

    def share(self, sweep, other_than=None):
        """Waits for a share that is judged; returns its number and its process."""
        deadline = time.monotonic() + 120
        while time.monotonic() < deadline and sweep.poll() is None:
            for number, process in self.cluster.shares().items():
                if number != other_than:
                    return number, process
            time.sleep(0.02)
        self.fail("no share is judged:\n" + self.printed())

    def test_a_killed_and_a_requeued_task(self):
        fill(self.folder, 24, 20, 512)
        code, alone = self.undisturbed()
        sweep = self.begin(6)
        killed, process = self.share(sweep)
        os.kill(process, signal.SIGKILL)
        requeued, _ = self.share(sweep, other_than=killed)
        tasks = call("squeue", "-h", "-r", "-t", "R", "-o", "%i %K").stdout.split()
        tasks = dict(zip(tasks[1::2], tasks[::2]))
        done = call("scontrol", "requeue", tasks[requeued.split("/")[0]])
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sweep.wait(timeout=400), code, self.printed())
        submitted = (self.folder / "sweep.log").read_text().count("Submitted batch job")
        self.assertEqual(submitted, 2, self.printed())
        self.assertEqual(self.collected(), (code, alone))

    def test_a_recording_that_aborts_is_named_and_the_others_are_judged(self):
        fill(self.folder, 4, 3, 0)
        rows = "".join(f"{k / 1e5 - 0.02:.5f},{k % 7}\n" for k in range(400_000))
        (self.folder / "recordings/r0001.csv").write_text("time_s,acc_y_g\n" + rows)
        sweep = self.begin(2, "ulimit -c 0; ulimit -v 60000;")
        self.assertEqual(sweep.wait(timeout=400), 4, self.printed())
        printed = self.printed()
        self.assertIn("SIGABRT", printed)
        self.assertIn("recordings/r0001.csv: begun twice and never finished", printed)
        status = json.loads(self.gate("--store", "store", "--status", "--format", "json").stdout)
        self.assertEqual((status["done"], status["missing"]), (9, 3))
        self.assertEqual(status["never_ended"], ["recordings/r0001.csv"])
        self.assertFalse((self.folder / "reports").exists())


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
                tests = begin([sys.executable, "-B", __file__, "OnSlurm.test_a_killed_and_a_requeued_task"], log,
                              cwd=self.folder, env={**os.environ, **dict([mark.split("=")]), "TMPDIR": str(self.folder)})
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
                environment = (folder / "environ").read_bytes()
                if mark.encode() in environment:
                    words = (folder / "cmdline").read_bytes().split(b"\0")
                    is_share = b"--part" in words and b"SLURM_JOB_ID=" in environment
                    found.add("a share" if is_share else (folder / "comm").read_text().strip())
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
        self.cost("again, from the store", "--threads", "1", "--store", "s", "--out", "c")
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
