"""Times verdicts on recordings of growing length, made by formula, and draws the times. Started by ./cost."""

import csv
import json
import math
import pathlib
import resource
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot

RATE_HZ = 10_000
# A pulse every 0.2 s: the lever opens by some 0.03 rad, falls back and bounces until it rests.
EVERY = 2000
CHANNEL = "tests/data/recordings/nhtsa_v07292.148"
# Beyond the defaults, so that no length is refused and no ensemble cut.
LIMITS = ["--limit", "lines=11000000", "--limit", "samples=11000000", "--limit", "work=20000000000"]
BLUE, ORANGE = "#0b57d0", "#c2410c"


def pulses(path, samples, count, least_g=2.0):
    """Writes a recording of `samples` with up to `count` pulses, each pushed back so that no velocity stays."""
    half = [math.sin(math.pi * k / 200) for k in range(200)]
    noise = [0.01 * math.sin(0.91 * k) + 0.01 * math.sin(2.3 * k + 1.0) for k in range(4001)]
    with open(path, "w") as file:
        file.write("time_s,acc_y_g\n")
        for k in range(samples):
            pulse, place = divmod(k - 400, EVERY)
            a = noise[k % 4001]
            if 0 <= pulse < count and samples - k >= 600 - place:
                height = least_g + 0.2 * math.modf(0.618 * pulse)[0]
                if place < 200:
                    a -= height * half[place]
                elif place < 600:
                    a += 0.5 * height * half[(place - 200) // 2]
            file.write(f"{(k - 200) / RATE_HZ:.4f},{a:.5f}\n")


def timed(program, path, *options):
    """Least processor time [s] of a verdict, and its document."""
    least, spent = math.inf, 0.0
    while spent < 1.0:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([program, "replay", path, *options, *LIMITS, "--no-report", "--format", "json"],
                              capture_output=True, text=True)
        if done.returncode not in (0, 1, 3):
            sys.exit(f"{path}: exit code {done.returncode}: {done.stderr}")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
        least, spent = min(least, seconds), spent + seconds
    return least, json.loads(done.stdout)


def impacts_of(document):
    return max(model["impacts"] for model in document["models"].values())


def row(rows, panel, series, x, seconds, document):
    ensembles = document.get("ensembles") or [document["ensemble"]]
    members = sum(ensemble["members"] for ensemble in ensembles if ensemble)
    rows.append({"panel": panel, "series": series, "x": members if panel == "members" else x,
                 "time_s": f"{seconds:.4g}", "impacts": impacts_of(document), "members": members,
                 "verdict": document["verdict"]})
    print(*rows[-1].values(), file=sys.stderr)


def measure(program, folder):
    rows = []
    nominal, scattered = ("nominal levers", ["--members", "0"]), ("with ensembles", [])
    for exponent in (3, 3.5, 4, 4.5, 5, 5.5, 6, 6.5, 7):
        samples = round(10**exponent)
        path = folder / "samples.csv"
        pulses(path, samples, samples)
        for series, options in (nominal, scattered):
            row(rows, "samples", series, samples, *timed(program, path, "--opens-when", "negative", *options))
    path = folder / "impacts.csv"
    # A pulse of 1.1 g hardly lifts the lever off its stop.
    for count, least_g in ((1, 1.1), (1, 2.0), (4, 2.0), (10, 2.0), (30, 2.0), (100, 2.0), (250, 2.0), (500, 2.0)):
        pulses(path, 1_000_000, count, least_g)
        for series, options in (nominal, scattered):
            seconds, document = timed(program, path, "--opens-when", "negative", *options)
            row(rows, "impacts", series, impacts_of(document), seconds, document)
    for members in (0, 128, 512, 2048, 10_000):
        row(rows, "members", "with ensembles", members, *timed(program, CHANNEL, "--members", str(members)))
    return rows


def draw(rows, path):
    matplotlib.rcParams.update({"svg.hashsalt": "latchgate", "svg.fonttype": "none", "font.size": 11})
    figure, panels = pyplot.subplots(1, 3, figsize=(13, 5.2), width_ratios=[1.3, 1, 1])
    figure.subplots_adjust(left=0.055, right=0.985, top=0.83, bottom=0.12, wspace=0.2)
    titles = {"samples": ("samples", "a pulse every 0.2 s at 10 kHz"),
              "impacts": ("impacts", "a million samples"),
              "members": ("members run, all ensembles together", "a crash channel, 4126 samples")}
    for axes, (panel, (label, title)) in zip(panels, titles.items()):
        for series, colour in (("nominal levers", BLUE), ("with ensembles", ORANGE)):
            own = [row for row in rows if row["panel"] == panel and row["series"] == series]
            axes.plot([float(row["x"]) for row in own], [float(row["time_s"]) for row in own], "o-", color=colour,
                      label=series)
        if panel == "samples":
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.yaxis.set_major_formatter("{x:g}")
            last = [float(row["time_s"]) for row in rows if row["panel"] == panel][-1]
            axes.plot([1e3, 1e7], [2.5 * last * 1e-4, 2.5 * last], ":", color="#374151", label="in proportion")
        else:
            axes.locator_params(axis="x", nbins=5)
        axes.set_ylim(bottom=None if panel == "samples" else 0.0)
        axes.grid(True, color="#e5e7eb")
        axes.set_title(title, loc="left", fontsize=11)
        axes.set_xlabel(label)
    panels[0].set_ylabel("processor time of a verdict [s]")
    panels[0].legend(loc="upper left", frameon=False)
    figure.suptitle("Time of a verdict against samples, impacts and members", x=0.055, ha="left", fontweight="bold",
                    fontsize=14)
    figure.savefig(path, metadata={"Date": None, "Creator": None})


def main():
    program, out = sys.argv[1], pathlib.Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as folder:
        rows = measure(program, pathlib.Path(folder))
    out.mkdir(parents=True, exist_ok=True)
    with open(out / "cost.csv", "w", newline="") as file:
        table = csv.DictWriter(file, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    draw(rows, out / "cost.svg")


main()
