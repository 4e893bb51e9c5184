"""Times `latchgate.sweep` beside `latchgate gate` on the same recordings and designs, nominal levers alone.

    crates/python/tests/run -k nothing                                     # installs the package
    target/python-tests/bin/python benches/sweep.py 1000 100 [THREADS]
"""

import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

import latchgate as lg
import numpy as np

PROGRAM = pathlib.Path(sys.executable).parents[2] / "release/latchgate"


def fill(folder, recordings):
    """Writes pulses with ringing and noise, 3000 samples each, of which some open the weaker levers."""
    t = np.arange(3000) / 10_000 - 0.05
    noise = np.random.default_rng(1)
    for number in range(recordings):
        peak_g = 4 + 30 * number / recordings
        pulse = np.where((t >= 0) & (t < 0.03), -peak_g * np.sin(np.pi * t / 0.03), 0)
        ringing = np.where(t > 0, 0.4 * peak_g * np.exp(-t / 0.02) * np.sin(1600 * t), 0)
        a = pulse + ringing + noise.uniform(-0.05, 0.05, len(t))
        path = folder / f"r{number:05}.csv"
        np.savetxt(path, np.column_stack([t, a]), fmt=["%.4f", "%.3f"], delimiter=",", header="time_s,acc_y_g", comments="")


def timed(work):
    """Returns what work returns, the clock's and the processor's time of it and of its children [s]."""
    def processor_s():
        usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        return sum(usage.ru_utime + usage.ru_stime for usage in usages)

    clock, processor = time.perf_counter(), processor_s()
    answer = work()
    return answer, time.perf_counter() - clock, processor_s() - processor


def main(recordings, designs, threads):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        fill(folder, recordings)
        preloads = {f"d{number:03}": round(0.6 + 6 * number / designs, 4) for number in range(designs)}
        gate = '[[recordings]]\nfiles = "*.csv"\nopens_when = "negative"\nmembers = 0\n'
        for design, preload in preloads.items():
            gate += f'[[designs]]\nname = "{design}"\nset = {{ "lever.preload_torque_nm" = {preload} }}\n'
        (folder / "gate.toml").write_text(gate)
        words = [PROGRAM, "gate", folder / "gate.toml", "--no-store", "--reports", "none", "--out", folder / "out"]
        words += ["--threads", str(threads)]
        _, *of_gate = timed(lambda: subprocess.run(words, stdout=subprocess.DEVNULL, check=False))
        levers = [{"name": name, "lever": {"preload_torque_nm": preload}} for name, preload in preloads.items()]
        files = sorted(folder.glob("*.csv"))
        sweep, *of_sweep = timed(
            lambda: lg.sweep(files, levers, members=0, opens_when="negative", threads=threads)
        )
        pairs = json.loads((folder / "out/summary.json").read_text())["pairs"]
        same = [pair["row"]["verdict"] for pair in pairs] == [row["verdict"] for row in sweep]
        print(f"{recordings} recordings, {designs} designs, {threads} threads; same verdicts: {same}")
        for label, (clock, processor) in (("latchgate gate", of_gate), ("latchgate.sweep", of_sweep)):
            print(f"{label:16} {clock:7.1f} s by the clock {processor:7.1f} s of processors {1e3 * processor / len(pairs):6.3f} ms a pair")


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:]]
    main(*(numbers + [1000, 100, os.cpu_count()][len(numbers) :]))
