"""Times every entrant in turns, writes the table and draws it. Started by ./chart."""

import csv
import math
import pathlib
import subprocess
import sys
import time

import heyoka
import matplotlib
import scipy

import peers

matplotlib.use("svg")
from matplotlib import pyplot

ROUNDS = 12
# A short run is repeated for so long in each round [s]; the least time counts.
TURN_S = 0.02
# A run this long [s] is not repeated: nothing short disturbs it.
LONG_S = 0.5
LIMIT_RAD = 0.1
# How latchgate reads the samples, and what stands beside its points.
READINGS = {"linear": "straight lines", "linear-4": "lines, 4 × refined", "linear-16": "lines, 16 × refined",
            "band-limited": "latchgate: the samples' band"}

# Name, label, colour, dashed where it steps across the kinks at samples.
BLUE, ORANGE, GREEN, PURPLE, BROWN, GREY = "#0b57d0", "#c2410c", "#15803d", "#7e22ce", "#92400e", "#6b7280"
CURVES = {
    "latchgate": ("latchgate", BLUE, "-"),
    "paper": ("Runge-Kutta, events on the grid (the paper's)", "#b91c1c", "--"),
    "rk4-located": ("Runge-Kutta, events located", GREY, "--"),
    "dopri5": ("Dormand-Prince", "#111827", "--"),
    "dopri5-samples": ("Dormand-Prince, at samples", "#111827", "-"),
    "diffsol": ("diffsol 0.18", ORANGE, "--"),
    "diffsol-samples": ("diffsol, at samples", ORANGE, "-"),
    "heyoka": (f"heyoka {heyoka.__version__}, at samples, from Python", GREEN, "-"),
    "cvode": ("CVODE 6, Adams, from C", PURPLE, "--"),
    "cvode-samples": ("CVODE, at samples", PURPLE, "-"),
    "scipy": (f"scipy {scipy.__version__}, DOP853, from Python", BROWN, "--"),
    "scipy-samples": ("scipy, at samples", BROWN, "-"),
    "scipy-spline": ("scipy, cubic spline", BROWN, ":"),
}
MARKERS = {"latchgate": "D", "paper": "s", "heyoka": "^"}


class Worker:
    """Entrants of another process, which times its own runs."""

    def __init__(self, command, scene=""):
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.process.stdin.write(scene)
        self.process.stdin.flush()
        self.names = list(iter(lambda: self.process.stdout.readline().rstrip("\n"), ""))

    def entrants(self):
        for index, name in enumerate(self.names):
            yield name, lambda index=index: self.run(index)

    def run(self, index):
        self.process.stdin.write(f"{index}\n")
        self.process.stdin.flush()
        rigid, soft, _, seconds = map(float, self.process.stdout.readline().split())
        return [rigid, soft], seconds


def timed(run):
    def timed_run():
        started = time.perf_counter()
        peaks = run()
        return [float(peak) for peak in peaks], time.perf_counter() - started

    return timed_run


def race(entrants, truth):
    """Runs all in turns, each round in the reverse order of the one before; keeps the least time of each."""
    rows = {}
    for turn in range(ROUNDS):
        for name, run in entrants if turn % 2 == 0 else reversed(entrants):
            before = rows.get(name)
            if before and before["time_s"] > LONG_S:
                continue
            least, began = math.inf, time.perf_counter()
            while True:
                peaks, seconds = run()
                least = min(least, seconds)
                if time.perf_counter() - began > TURN_S:
                    break
            errors = [abs(peak - true) for peak, true in zip(peaks, truth)]
            error = max(errors) if all(map(math.isfinite, errors)) else math.inf
            method, setting = name.split("\t")
            rows[name] = {"method": method, "setting": setting,
                          "time_s": min(least, before["time_s"] if before else math.inf),
                          "error_rad": error,
                          "peak_rigid_rad": peaks[0], "peak_soft_rad": peaks[1]}
        print(f"round {turn + 1} of {ROUNDS}", file=sys.stderr)
    return [rows[name] for name, _ in entrants]


def draw(rows, floor, path):
    matplotlib.rcParams.update({"svg.hashsalt": "latchgate", "svg.fonttype": "none", "font.size": 11,
                                "font.family": "sans-serif"})
    figure, axes = pyplot.subplots(figsize=(11.5, 8.6))
    figure.subplots_adjust(left=0.075, right=0.985, top=0.865, bottom=0.22)
    axes.set_xscale("log")
    axes.set_yscale("log")
    # Runs without an answer stand on the upper edge.
    top = 8.0
    for method, (label, colour, style) in CURVES.items():
        own = [row for row in rows if row["method"] == method]
        x = [1e3 * row["time_s"] for row in own]
        y = [min(row["error_rad"], top) if math.isfinite(row["error_rad"]) else top for row in own]
        main = method == "latchgate"
        axes.plot(x, y, linestyle="none" if main else style, color=colour, marker=MARKERS.get(method, "o"),
                  markersize=11 if main else 5.5, linewidth=1.6, label=label, zorder=5 if main else 3)
        if main:
            for row, at in zip(own, zip(x, y)):
                bold = {"fontweight": "bold"} if row["setting"] == "band-limited" else {}
                axes.annotate(READINGS[row["setting"]], at, (10, -16), textcoords="offset points", color=colour, **bold)
    low = min(1e-10, floor / 10)
    axes.axhspan(low, floor, color="#e5e7eb", zorder=0)
    axes.set_ylim(low, top)
    right = axes.get_xlim()[1]
    axes.annotate("below: how well the truth is known", (right, floor), (-8, -16),
                  textcoords="offset points", ha="right", color="#374151")
    axes.axhline(LIMIT_RAD, color="#111827", linewidth=1.0, linestyle=":")
    axes.annotate("the limit of the angle, 0.1 rad", (right, LIMIT_RAD), (-8, 5),
                  textcoords="offset points", ha="right", color="#111827")
    paper = next(row for row in rows if row["method"] == "paper" and row["setting"] == "N = 10000")
    axes.plot([1e3 * paper["time_s"]], [paper["error_rad"]], "o", markersize=16, markerfacecolor="none",
              markeredgecolor="#b91c1c", markeredgewidth=1.6, zorder=6)
    axes.annotate("the paper's step", (1e3 * paper["time_s"], paper["error_rad"]), (14, 4),
                  textcoords="offset points", color="#b91c1c")
    axes.grid(True, color="#e5e7eb", linewidth=0.8)
    axes.set_axisbelow(True)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("time of two replays, of the rigid and of the soft stop together [ms]")
    axes.set_ylabel("error of the peak angle, the larger of the two stops [rad]")
    axes.legend(loc="upper left", bbox_to_anchor=(-0.01, -0.11), fontsize=10, frameon=False, ncols=3,
                handlelength=3.2)
    figure.suptitle("Error against time of two replays, what lies between the samples included", x=0.075, ha="left",
                    fontweight="bold", fontsize=14)
    lines = {row["method"] for row in rows} - {"latchgate", "paper", "scipy-spline"}
    figure.text(0.075, 0.885, "Tones under a bell curve, 3001 samples at 10 kHz; the truth is the formula. Left is faster, "
                f"down is more exact.\n{len(lines)} solvers lie on one line: they join the samples by straight lines, which no "
                "tolerance mends. Solid: a step ends at each sample;\ndashed: steps go across. The scene is smooth, the best "
                "case: corners between samples cost 1e-2 of the peak in the median.", fontsize=10.5)
    figure.savefig(path, metadata={"Date": None, "Creator": None})


def main():
    worker, cvode, out = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
    text = subprocess.run([worker, "scene"], check=True, capture_output=True, text=True).stdout
    scene, spline = peers.Scene(text.splitlines()), peers.Spline(text.splitlines())
    truth = [scene.rigid_truth, scene.soft_truth]
    entrants = [*Worker([worker, "methods"]).entrants(), *Worker([cvode], text).entrants(),
                *((name, timed(run)) for name, run in peers.entrants(scene, spline))]
    rows = race(entrants, truth)
    out.mkdir(parents=True, exist_ok=True)
    with open(out / "error-against-time.csv", "w", newline="") as file:
        table = csv.DictWriter(file, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows({key: f"{value:.6g}" if key in ("time_s", "error_rad") else value
                         for key, value in row.items()} for row in rows)
    draw(rows, scene.floor, out / "error-against-time.svg")
    for row in rows:
        print(f"{row['method']:16} {row['setting']:12} {1e3 * row['time_s']:10.3f} ms {row['error_rad']:9.1e} rad")


main()
