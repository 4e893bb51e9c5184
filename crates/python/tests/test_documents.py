"""The same questions give the same documents as the command line."""

import itertools
import json
import shutil

import latchgate as lg
import numpy as np
import pandas as pd
import pytest
from conftest import SIGNALS, but_run
from latchgate._native import keywords

RECORDINGS = ["burst.csv", "surviving.csv", "half_sine_30g_11ms.csv", "burst_imu.mcap", "ugly.csv", "pulse:half-sine,peak=30g,duration=11ms"]
QUESTIONS = [
    {},
    {"members": 0, "opens_when": "both", "model": "rigid"},
    {"filter": "cfc180", "bias": "none", "set": {"lever.preload_torque_nm": 2.82}},
    {"window": (-0.01, 0.06), "members": 200, "seed": 7, "opens_when": "negative"},
    {"resample": 8000.0, "between": "linear", "model": "soft", "members": 128},
    {"members": 0, "transfer": "0.8..1.25", "accept": ["axis"]},
    {"members": 0, "transfer": 1},
    {"unit": "m/s2", "velocity_change": 4.5, "accept": ["clock"], "phi0": 0.01, "omega0": -0.5},
]


def options(question):
    """The same question as options of the command line."""
    for key, value in question.items():
        if key == "set":
            for name, number in value.items():
                yield from ("--set", f"{name}={number}")
            continue
        if isinstance(value, tuple):
            value = f"{value[0]}..{value[1]}"
        if isinstance(value, list):
            value = ",".join(value)
        # One word, so that a value may begin with a minus.
        yield f"--{key.replace('_', '-')}={value}"


@pytest.mark.parametrize("recording, question", list(itertools.product(RECORDINGS, QUESTIONS)))
def test_a_document_is_that_of_the_command_line(latchgate, recording, question):
    path = recording if recording.startswith("pulse:") else SIGNALS / recording
    printed = latchgate("replay", path, "--no-report", "--format", "json", *options(question))
    try:
        result = lg.replay(path, **question)
    except lg.NotJudged as error:
        # Such as a unit that contradicts the file's: the command line has no answer either.
        why = json.loads(printed)["why"]
        assert [why[0]["code"], keywords(why[0]["text"])] == ["input-refused", str(error)]
        return
    assert but_run(result.document) == but_run(printed)
    assert result.data["run"]["elapsed_s"] > 0
    assert result.verdict == result.data["verdict"]


def test_listing_and_margin_are_those_of_the_command_line(latchgate):
    path = SIGNALS / "surviving.csv"
    printed = json.loads(latchgate("inspect", path, "--format", "json"))
    assert lg.inspect(path) == printed
    words = ["margin", path, "--no-report", "--format", "json", "--members", "0"]
    printed = json.loads(latchgate(*words, "--counterweight-radius", "0.04"))
    margins = [
        lg.margin(path, members=0, counterweight_radius=0.04),
        lg.replay(path, members=0).margin(counterweight_radius=0.04),
    ]
    for margin in margins:
        assert {**margin, "run": None} == {**printed, "run": None}


def arrays():
    series = lg.replay(SIGNALS / "surviving.csv", members=0).series
    return series["time_s"], series["acceleration_recorded_m_s2"] / 9.80665


def test_arrays_are_judged_as_the_table_that_is_saved(latchgate, tmp_path):
    t, a = arrays()
    result = lg.judge(t, a, unit="g", opens_when="negative", members=200)
    path = result.save_csv(tmp_path)
    words = ["--opens-when", "negative", "--members", "200", "--no-report", "--format", "json"]
    assert but_run(result.document) == but_run(latchgate("replay", path, *words))
    assert but_run(result.document) == but_run(lg.replay(path, opens_when="negative", members=200).document)
    with pytest.raises(FileExistsError):
        lg.judge(t, 0.5 * a, unit="g", members=0).save_csv(tmp_path)
    saved = np.loadtxt(path, delimiter=",", skiprows=1)
    assert np.array_equal(saved, np.column_stack([t, a]))
    assert result.verify()["same"]
    assert result.data["recording"]["unit"] == "g"


def test_arrays_of_any_kind_are_the_same_samples():
    t, a = arrays()
    strided = np.column_stack([t, a])
    series = pd.Series(a, index=t)
    expected = but_run(lg.judge(t, a, unit="g", members=0).document)
    for time, values in [(strided[:, 0], strided[:, 1]), (list(t), list(a)), (series, None), (t, series)]:
        assert but_run(lg.judge(time, values, unit="g", members=0).document) == expected
    single = a.astype(np.float32)
    whole = lg.judge(t, single.astype(np.float64), unit="g", members=0)
    assert but_run(lg.judge(t, single, unit="g", members=0).document) == but_run(whole.document)
    counts = np.round(a * 100).astype(np.int16)
    volts = lg.judge(t, counts, sensitivity="0.01 g/count", members=0, opens_when="negative")
    assert volts.verdict == lg.judge(t, counts / 100, unit="g", members=0, opens_when="negative").verdict


def test_contiguous_doubles_are_not_copied():
    from latchgate._question import columns

    t, a = arrays()
    for given, taken in zip((t, a), columns(t, a)):
        assert np.shares_memory(given, taken)


def test_every_unit_is_the_one_that_was_meant():
    t, a = arrays()
    peak = np.abs(a).max()
    for unit, factor in [("g", 1), ("mg", 1e-3), ("m/s^2", 1 / 9.80665), ("ft/s2", 0.3048 / 9.80665)]:
        recording = lg.judge(t, a / factor, unit=unit, members=0).data["recording"]
        assert recording["peak_g"] == pytest.approx(peak, rel=1e-9), unit


def test_designs_are_files_tables_and_changes(tmp_path):
    path = SIGNALS / "burst.csv"
    table = {"name": "stiff", "base": "paper", "lever": {"preload_torque_nm": 3.5}, "tolerance": {"restitution": 0.01}}
    file = tmp_path / "stiff.toml"
    file.write_text('name = "stiff"\nbase = "paper"\n[lever]\npreload_torque_nm = 3.5\n[tolerance]\nrestitution = 0.01\n')
    of_table, of_file = (lg.replay(path, design=design, members=200) for design in (table, file))
    assert but_run(of_table.document) == but_run(of_file.document)
    assert of_file.data["design"]["name"] == "stiff"
    changed = lg.replay(path, set={"lever.preload_torque_nm": np.float64(3.5)}, members=0)
    assert changed.data["design"]["modified"] == ["lever.preload_torque_nm"]
    assert changed.data["design"]["lever"]["preload_torque_nm"] == 3.5


def test_a_sweep_has_the_answers_of_its_pairs_in_order():
    designs = [None, {"name": "stiff", "base": "paper", "lever": {"preload_torque_nm": 5}}]
    recordings = [SIGNALS / "surviving.csv", "absent.csv", SIGNALS / "burst.csv"]
    sweep = lg.sweep(recordings, designs, members=200, threads=2)
    assert lg.sweep(recordings, designs, members=200, threads=1).rows == sweep.rows
    pairs = [(row["recording"], row["design"]) for row in sweep]
    assert pairs == [(str(path), name) for path in recordings for name in ("paper", "stiff")]
    for row, (path, design) in zip(sweep, itertools.product(recordings, designs)):
        if path == "absent.csv":
            assert (row["verdict"], row["reason"]["code"]) == ("unusable", "input-refused")
            continue
        result = lg.replay(path, design=design, members=200)
        keys = ["verdict", "report_id", "threshold_rad"]
        assert row["members"] == result.data["request"]["members"]
        assert [row[key] for key in keys] == [result.data[key] for key in keys]
        assert row["peak_angle_rad"] == result.data["nominal"]["peak_angle_rad"]
    assert list(sweep.to_pandas()["verdict"]) == [row["verdict"] for row in sweep]


def test_a_gate_is_that_of_the_command_line(latchgate, tmp_path):
    for name in ("burst.csv", "surviving.csv"):
        shutil.copy(SIGNALS / name, tmp_path)
        shutil.copy(SIGNALS / f"{name}.toml", tmp_path)
    gate = tmp_path / "gate.toml"
    gate.write_text('[[recordings]]\nfiles = ["*.csv"]\nmembers = 0\n[[designs]]\nname = "paper"\n')
    printed = latchgate("gate", gate, "--no-store", "--out", tmp_path / "a", "--format", "json")
    result = lg.Gate(gate).run(out=tmp_path / "b", store=tmp_path / "store")
    times = {"times": None}
    assert {**result.data, **times} == {**json.loads(printed), **times}
    assert (tmp_path / "b/index.html").read_bytes() == (tmp_path / "a/index.html").read_bytes()
    assert (result.exit_code, len(result)) == (1, 2)
    assert lg.Gate(gate).run(store=tmp_path / "store").rows == result.rows
    gate.write_text('[[recordings]]\nfiles = ["*.cvs"]\n[[designs]]\nnmae = "paper"\n')
    with pytest.raises(lg.NotJudged, match="nmae"):
        lg.Gate(gate).run()
