"""What a result offers, what is refused and how, and that a question can be left."""

import copy
import datetime
import math
import multiprocessing
import pickle
import signal
import subprocess
import sys
import textwrap
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import latchgate as lg
import numpy as np
import pandas as pd
import pytest
from conftest import SIGNALS, but_run

BURST = SIGNALS / "burst.csv"


def run(code, **options):
    """Runs a program of its own."""
    words = [sys.executable, "-c", textwrap.dedent(code)]
    return subprocess.run(words, capture_output=True, text=True, check=True, **options).stdout


@pytest.fixture(scope="module")
def fail():
    return lg.replay(BURST, opens_when="negative", members=200)


def test_a_result_says_what_its_document_says(fail):
    assert fail.verdict == "fail"
    assert fail.opens.first_s == pytest.approx(0.0144, abs=5e-5)
    assert vars(fail.opens) == fail.data["opens"]
    assert [vars(reason) for reason in fail.why] == fail.data["why"]
    for finding, entry in zip(fail.findings, fail.data["findings"], strict=True):
        assert vars(finding) == {"needs_word": False, **entry}
    assert str(fail).startswith("✗ FAIL  The lever opens at 14.4 ms")
    assert repr(fail) == "<latchgate.Result fail: The lever opens at 14.4 ms (soft stop, negative acceleration).>"
    stays = lg.replay(SIGNALS / "surviving.csv", members=0)
    assert stays.opens is None and stays.peak == stays.data["nominal"]["peak_angle_rad"]


def test_beyond_90_degrees_there_is_no_peak(fail):
    assert fail.data["nominal"]["peak_angle_rad"] > math.pi / 2
    assert fail.peak is None and fail.opens is not None
    limited = lg.replay(BURST, opens_when="negative", members=0, set={"lever.preload_torque_nm": 5})
    assert limited.opens is not None and limited.peak == limited.data["nominal"]["peak_angle_rad"]


COPIES = [copy.copy, copy.deepcopy, lambda answer: pickle.loads(pickle.dumps(answer))]


@pytest.mark.parametrize("copied", COPIES)
def test_answers_are_copied_and_pickled(copied, fail, tmp_path):
    arrays = lg.judge(T, np.sin(300 * T), unit="g", members=0, opens_when="both", name="sine.csv")
    pulse = lg.replay(SLED, members=0, design={"name": "stiff", "base": "paper", "lever": {"preload_torque_nm": 5}})
    question = {"bias": "none", "window": (-0.01, 0.06), "transfer": "0.8..1.25", "accept": ["axis"], "limit": {"work": 10**9}}
    stated = lg.replay(BURST, set={"lever.mass_kg": 0.12}, members=0, **question)
    for result in (fail, arrays, pulse, stated):
        again = copied(result)
        assert (again.document, str(again), repr(again)) == (result.document, str(result), repr(result))
        assert again.verify()["same"]
        for name, values in result.series.items():
            assert np.array_equal(copied(again).series[name], values), name
    assert copied(arrays).save_csv(tmp_path).name == "sine.csv"
    margins = [{**answer.margin(counterweight_radius=0.04), "run": None} for answer in (pulse, copied(pulse))]
    assert margins[0] == margins[1]
    gate = lg.Gate(SIGNALS.parent / "docs/gate/gate.toml")
    for answer in (lg.sweep([BURST], members=0), gate, gate.run(), lg.spectrum(SLED)):
        assert repr(copied(answer)) == repr(answer)


def test_a_pickled_result_stands_without_its_file(tmp_path):
    file = tmp_path / "burst.csv"
    file.write_bytes(BURST.read_bytes())
    result = lg.replay(file, members=0)
    kept = pickle.dumps(result)
    file.unlink()
    again = pickle.loads(kept)
    assert (again.verdict, str(again)) == (result.verdict, str(result))
    with pytest.raises(lg.NotJudged, match="burst.csv"):
        again.series


def judged(path):
    return lg.replay(path, members=0)


def test_other_processes_hand_results_over():
    paths = [BURST, SIGNALS / "surviving.csv"]
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        results = list(pool.map(judged, paths))
    for path, result in zip(paths, results, strict=True):
        assert but_run(result.document) == but_run(judged(path).document)


def test_print_shows_what_the_terminal_shows_with_pythons_remedies(latchgate, tmp_path):
    undeclared = tmp_path / "undeclared.csv"
    a = np.where((T > 0) & (T < 0.011), -30 * np.sin(np.pi * T / 0.011), 0.0)
    table = np.column_stack([T, a])
    np.savetxt(undeclared, table, delimiter=",", header="time,acceleration [g]", comments="")
    for path in (BURST, undeclared):
        result = lg.replay(path, members=0)
        shown = " ".join(str(result).split())
        assert "result.margin() searches" in shown and "result.findings has them" in shown
        assert "latchgate" not in shown and "--" not in shown
        shown = shown.replace("result.margin() searches", "latchgate margin searches")
        shown = shown.replace("result.findings has them", "-v tells them")
        shown = shown.replace('opens_when="negative"|"positive"|"both", transfer="LO..HI"', "TOGETHER")
        shown = shown.replace("the setting `opens_when`", "--opens-when")
        printed = latchgate("replay", path, "--members", "0", "--no-report", "--no-advice").decode()
        options = "--opens-when negative|positive|both --transfer LO..HI"
        assert shown == " ".join(printed.split()).replace(options, "TOGETHER")
    assert 'State together: opens_when="negative"|"positive"|"both", transfer="LO..HI"' in result.why[1].text
    assert "the setting `opens_when` = negative" in result.data["why"][1]["text"]


KEYWORDS = [
    ("the setting `filter` = none.", 'filter="none".'),
    ("the setting `window` = -0.01..0.06. If", "window=(-0.01, 0.06). If"),
    ("the setting `bias` = START..END, or", "bias=(START, END), or"),
    ("the setting `rate_hz` = HZ; the setting `members` = 0)", "rate_hz=HZ; members=0)"),
    ("state the setting `time_unit` = s|ms, or", 'state time_unit="s"|"ms", or'),
    ("the setting `sensitivity` = '20 g/V')", 'sensitivity="20 g/V")'),
    ("the setting `decimal` = . or the setting `decimal` = , ; the", 'decimal="." or decimal="," ; the'),
    ("the setting `accept` = clock,noise.", 'accept=["clock", "noise"].'),
    ("the setting `accepted_remarks` = 'it'\\''s \"so\"', or", 'accepted_remarks=["it\'s \\"so\\""], or'),
    ('the setting `accepted_remarks` = "as is", or', 'accepted_remarks=["as is"], or'),
    ("the setting `radial_channel` = sill acc x [g].", 'radial_channel="sill acc x [g]".'),
    ("the setting `limit` = work=1000. Or", 'limit={"work": 1000}. Or'),
    (
        "the setting `set` = tolerance.mass_kg=VALUE, the setting `set` = lever.mass_kg=0.1",
        'set={"tolerance.mass_kg": VALUE, "lever.mass_kg": 0.1}',
    ),
    ("the setting `unit`, or the setting `rate_hz` = 9.", "the setting `unit`, or rate_hz=9."),
    ("the setting `unit", "the setting `unit"),
]


@pytest.mark.parametrize("text, expected", KEYWORDS)
def test_settings_are_spelt_as_keywords(text, expected):
    from latchgate._native import keywords

    assert keywords(text) == expected


@pytest.mark.parametrize("times, question", [(1e3, {}), (1, {"window": (0, 60)})])
def test_times_in_milliseconds_are_suspected_aloud(times, question, tmp_path):
    table = np.column_stack([times * T, np.sin(300 * T)])
    file = tmp_path / "times.csv"
    np.savetxt(file, table, delimiter=",", header="time,sill acc y [g]", comments="")
    asked = [lambda: lg.replay(file, members=0, **question), lambda: lg.judge(*table.T, unit="g", members=0, **question)]
    for ask in asked:
        with pytest.warns(UserWarning, match=r'time_unit="s"\|"ms"|window=\(0, 0.06\)') as told:
            ask()
        assert told[0].filename == __file__


def test_arrays_have_the_unit_of_time_that_is_stated(recwarn, tmp_path):
    a = np.where((T > 0) & (T < 0.011), -30 * np.sin(np.pi * T / 0.011), 0.0)
    seconds = lg.judge(T, a, unit="g", members=0, opens_when="negative")
    for times, unit in ((1e3, "ms"), (1e5, "10 us")):
        result = lg.judge(times * T, a, unit="g", time_unit=unit, members=0, opens_when="negative", name=f"{times}.csv")
        assert result.opens.first_s == pytest.approx(seconds.opens.first_s, rel=1e-9)
        assert [finding.code for finding in result.findings] == [finding.code for finding in seconds.findings]
        saved = lg.replay(result.save_csv(tmp_path), members=0, opens_when="negative")
        assert but_run(saved.document) == but_run(result.document)
    assert not recwarn.list
    with pytest.raises(ValueError, match="the time unit `fortnight` is not known"):
        lg.judge(T, a, unit="g", time_unit="fortnight")
    with pytest.raises(lg.NotJudged, match="0.01 Hz"):
        lg.judge(1e6 * T, a, unit="g")


def test_a_missing_file_is_named_with_its_path(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    absent = tmp_path / "absent.csv"
    asked = [
        lambda: lg.replay(absent),
        lambda: lg.inspect(absent),
        lambda: lg.margin(absent),
        lambda: lg.spectrum([BURST, absent]),
        lambda: lg.replay(BURST, design=absent),
        lambda: lg.Gate(absent).run(),
    ]
    for ask in asked:
        with pytest.raises(FileNotFoundError) as raised:
            ask()
        error = raised.value
        assert isinstance(error, lg.NotJudged) and error.filename == str(absent)
        assert str(error) == f"{absent}: there is no such file"
        again = pickle.loads(pickle.dumps(error))
        assert (str(again), again.filename, again.errno) == (str(error), error.filename, error.errno)
    with pytest.raises(FileNotFoundError, match=f"^absent.csv: there is no such file in {tmp_path}$"):
        lg.replay("absent.csv")


def test_a_sweep_is_shown_as_a_table():
    stiff = {"name": "<stiff>", "base": "paper", "lever": {"preload_torque_nm": 5}}
    sweep = lg.sweep([BURST, "absent.csv"], [None, stiff], members=0)
    lines = [line.split(maxsplit=3) for line in str(sweep).splitlines()]
    assert str(sweep).splitlines()[0].split() == ["recording", "design", "verdict", "largest", "angle", "reason"]
    assert [line[:3] for line in lines[1:]] == [
        [str(BURST), "paper", "fail"],
        [str(BURST), "<stiff>", "fail"],
        ["absent.csv", "paper", "unusable"],
        ["absent.csv", "<stiff>", "unusable"],
    ]
    assert lines[1][3].split("  ")[0] == "> 90°" and "input-refused" in lines[3][3]
    shown = sweep._repr_html_()
    assert shown.count("<tr>") == 5 and "&lt;stiff&gt;" in shown and "&gt; 90°" in shown
    many = lg.sweep(["absent.csv"] * 70, members=0)
    assert len(str(many).splitlines()) == 62 and "10 more rows" in str(many) and "10 more rows" in many._repr_html_()


def test_nothing_is_true_or_false(fail, tmp_path):
    gate = lg.Gate(SIGNALS.parent / "docs/gate/gate.toml")
    sweep, run = lg.sweep([BURST], members=0), gate.run()
    for answer in (fail, fail.verify(), sweep, sweep.rows[0], gate, run, run.rows[0]):
        with pytest.raises(TypeError, match="compare"):
            bool(answer)


def test_a_result_is_compared_by_its_verdict(fail):
    for compare in (lambda: fail == "fail", lambda: fail != "fail", lambda: "pass" == fail, lambda: fail in ["pass"]):
        with pytest.raises(TypeError, match="compare .verdict"):
            compare()
    assert fail == fail and fail != lg.replay(BURST, members=0) and fail in {fail}


def test_where_a_setting_decides_the_first_line_says_so():
    question = {"set": {"criterion.threshold_rad": 0.02}, "window": (0.1, 0.2), "members": 0}
    result = lg.replay(SIGNALS / "surviving.csv", **question)
    assert result.why[0].code == "setting-decides"
    assert repr(result).startswith("<latchgate.Result pass: By the setting `window` the answer is pass, by the defaults it is fail.")


def test_an_unusable_recording_is_an_answer_without_a_peak():
    t = np.arange(-0.02, 0.2, 1e-4)
    result = lg.judge(t, np.where(t < 0, 0.0, -50.0), unit="g", members=0)
    assert (result.verdict, result.peak) == ("unusable", None)
    with pytest.raises(lg.NotJudged, match="unusable"):
        result.opens
    assert any(finding.severity == "blocking" for finding in result.findings)


def test_series_are_the_files_columns(fail, latchgate, tmp_path):
    file = tmp_path / "series.csv"
    words = ["--opens-when", "negative", "--members", "200", "--no-report", "--series", file]
    latchgate("replay", BURST, *words)
    table = np.genfromtxt(file, delimiter=",", names=True)
    assert list(fail.series) == list(table.dtype.names)
    for name, values in fail.series.items():
        assert np.array_equal(values, table[name]), name
    frame = fail.to_pandas()
    assert frame.index.name == "time_s" and len(frame) == len(table)


def test_the_plot_has_the_marks_of_the_report(fail):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    axes = fail.plot()
    assert [axis.get_ylabel() for axis in axes] == ["a [g]", "v [m/s]", "angle φ [rad]"]
    assert "as recorded, negative opens" in axes[0].get_legend_handles_labels()[1]
    labels = axes[-1].get_legend_handles_labels()[1]
    assert {"soft stop", "rigid stop", "t = 0", "limit angle 0.1 rad"} <= set(labels)
    assert any(label.startswith("opens 14.4") for label in labels)
    _, single = plt.subplots()
    assert fail.plot(single) is single
    limit = [line for line in single.get_lines() if line.get_label().startswith("limit")]
    assert limit[0].get_ydata()[0] == 0.1
    plt.close("all")


def test_a_notebook_shows_card_and_plot(fail):
    shown = fail._repr_html_().replace("\xa0", " ")
    for part in ("iframe", "FAIL", "The lever opens at 14.4 ms", "&lt;svg"):
        assert part in shown
    assert "&lt;script src" not in shown


def test_a_report_is_that_of_the_command_line_and_verified(fail, latchgate, tmp_path):
    words = ["--opens-when", "negative", "--members", "200", "--out", tmp_path / "theirs"]
    latchgate("replay", BURST, *words)
    page = fail.report(tmp_path / "ours", pdf=True)
    ours = {file.name: file.read_bytes() for file in page.parent.iterdir()}
    assert ours.pop("report.pdf").startswith(b"%PDF")
    theirs = {file.name: file.read_bytes() for file in (tmp_path / "theirs").iterdir()}
    assert but_run(ours.pop("verdict.json")) == but_run(theirs.pop("verdict.json"))
    assert ours == theirs
    verification = fail.verify()
    assert verification["same"] and "report.html" in verification["report"]["same"]
    page.write_text("changed")
    assert not fail.verify()["same"]


def test_a_report_never_replaces_what_was_read(tmp_path):
    file = tmp_path / "series.csv"
    file.write_bytes(BURST.read_bytes())
    result = lg.replay(file, members=0)
    with pytest.raises(ValueError, match="name another place"):
        result.report(tmp_path)
    assert file.read_bytes() == BURST.read_bytes()


def test_a_recording_that_changed_is_not_drawn(tmp_path):
    file = tmp_path / "burst.csv"
    file.write_bytes(BURST.read_bytes())
    result = lg.replay(file, members=0)
    file.write_bytes(BURST.read_bytes() + b"0.25005,0\n")
    with pytest.raises(lg.NotJudged, match="changed after it was judged"):
        result.series


WRONG = [
    (TypeError, {"chanel": "y"}, "unknown setting `chanel`; did you mean `channel`?"),
    (ValueError, {"filter": "cfc100"}, "did you mean cfc180?"),
    (ValueError, {"opens_when": "down"}, "negative, positive or both"),
    (ValueError, {"members": -1}, "members"),
    (ValueError, {"window": (0.1,)}, "window: expected (start, end)"),
    (ValueError, {"bias": {0.05, 0.1}}, "bias: expected (start, end)"),
    (ValueError, {"opens_when": (0, 1)}, "opens_when"),
    (ValueError, {"rate_hz": float("nan")}, ""),
    (ValueError, {"window": (0.1, 0.05)}, "START must lie before END"),
    (ValueError, {"set": {"lever.mas_kg": 1}}, "did you mean `lever.mass_kg`?"),
    (ValueError, {"set": {"lever.mass_kg": -1}}, "mass"),
    (ValueError, {"design": {"levers": {}}}, "did you mean `lever`?"),
    (lg.NotJudged, {"design": SIGNALS}, "cannot read the design file"),
    (lg.NotJudged, {"channel": "nine"}, "no channel `nine`; the recording holds"),
]


@pytest.mark.parametrize("kind, question, text", WRONG)
def test_what_is_wrong_is_named(kind, question, text):
    with pytest.raises(kind) as raised:
        lg.replay(BURST, **question)
    assert raised.type is kind and text in str(raised.value)


def test_several_channels_are_offered(tmp_path):
    t = np.arange(-0.02, 0.2, 1e-4)
    table = np.column_stack([t, np.sin(300 * t), np.cos(300 * t)])
    file = tmp_path / "two.csv"
    np.savetxt(file, table, delimiter=",", header="time [s],sill acc y [g],b-pillar acc y [g]", comments="")
    with pytest.raises(lg.NotJudged) as raised:
        lg.replay(file)
    error = raised.value
    assert error.candidates == ["sill acc y [g]", "b-pillar acc y [g]"]
    assert "several channels" in error.message == str(error)
    again = pickle.loads(pickle.dumps(error))
    assert (again.message, again.candidates) == (error.message, error.candidates)
    assert lg.replay(file, channel=error.candidates[1], members=0).data["recording"]["channel"].startswith("b-pillar")
    assert isinstance(error, ValueError)


T = np.arange(-0.02, 0.1, 1e-4)
REFUSED = [
    (T, np.where(T > 0.05, np.nan, T), "a[701] is nan"),
    (T, np.where(T > 0.05, np.inf, T), "is inf"),
    (T, T[1:], "expected one length, found 1200 and 1199"),
    (T, np.column_stack([T, T]), "one dimension, found 2"),
    (T, T > 0, "found bool"),
    (T, T + 0j, "found complex128"),
    (T, T.astype(np.longdouble), "real numbers"),
    (T, [str(value) for value in T], "real numbers"),
    (pd.Series(T, index=T), pd.Series(T, index=T + 1), "their indexes differ"),
    (pd.Series(T), None, "a row number, not a time"),
    (pd.Series(T)[T > 0], None, "a row number, not a time"),
    (T, pd.array([1, None] * 600, dtype="Int64"), "masked"),
    (pd.date_range("2026-01-01", periods=1200, freq="100us"), T, "a time to seconds"),
    (T, np.ma.masked_greater(T, 0.05), "masked"),
    (np.zeros(1200), T, "time must increase"),
    ([], [], ""),
]


@pytest.mark.parametrize("t, a, text", REFUSED)
def test_arrays_that_are_no_recording_are_not_judged(t, a, text):
    with pytest.raises(lg.NotJudged) as raised:
        lg.judge(t, a, unit="g", members=0)
    assert text in str(raised.value)


def test_no_unit_is_guessed():
    with pytest.raises(TypeError, match="unit="):
        lg.judge(T, T)
    with pytest.raises(ValueError, match="known: g, mg"):
        lg.judge(T, T, unit="furlong")


@pytest.mark.parametrize("name", ["", ".", "..", "../a.csv", "/a.csv", "folder/a.csv", "..\\a.csv", "C:a.csv"])
def test_arrays_have_the_name_of_a_file_alone(name):
    with pytest.raises(ValueError, match="without a folder"):
        lg.judge(T, T, unit="g", name=name)


def test_a_pair_of_any_kind_is_a_window():
    pairs = [(-0.01, 0.06), [-0.01, 0.06], np.array([-0.01, 0.06]), "-0.01..0.06"]
    documents = {but_run(lg.replay(BURST, window=pair, members=0).document) for pair in pairs}
    assert len(documents) == 1


def test_a_sweep_of_nothing_or_of_one_name_twice_is_refused():
    for recordings, designs in (([], [None]), (iter(()), [None]), ([BURST], [])):
        with pytest.raises(ValueError, match="empty"):
            lg.sweep(recordings, designs, members=0)
    with pytest.raises(ValueError, match="the name paper"):
        lg.sweep([BURST], [None, {"name": "stiff", "base": "paper"}, None], members=0)


GATE = """
require = "pass"
require_static_g = 30
[[recordings]]
files = "cut.csv"
members = 0
[[designs]]
name = "paper"
[[allow]]
recordings = "cut.csv"
designs = "paper"
reason = "repeat test ordered"
until = 2026-03-31
"""


def test_an_exception_of_a_gate_is_held_to_a_day(tmp_path):
    (tmp_path / "cut.csv").write_bytes((SIGNALS / "surviving.csv").read_bytes())
    gate = lg.Gate(tmp_path / "gate.toml")
    gate.path.write_text(GATE)
    for wrong in ("", "0", "2026-3-1", "2026-02-30", "2026-03-01T00:00:00", datetime.datetime(2026, 3, 1)):
        with pytest.raises(ValueError, match="date"):
            gate.run(date=wrong)
    early, late = gate.run(date=datetime.date(2026, 3, 31)), gate.run(date="2026-04-01")
    assert gate.run(date="2026-03-31").problems == early.problems
    codes = [[problem["code"] for problem in run.problems] for run in (early, late)]
    assert codes[0] != codes[1] and any("expired" in code for code in codes[1])
    assert late.statics == late.data["statics"] and "statics=[" in repr(late) and codes[1][0] in repr(late)
    assert late.statics[0]["design"] == "paper"


def test_import_takes_neither_pandas_nor_matplotlib():
    code = "import sys, latchgate; print({'pandas', 'matplotlib'} & set(sys.modules))"
    assert run(code).strip() == "set()"


def test_settings_are_those_of_the_engine():
    from latchgate import _native

    assert sorted(lg.Settings.__annotations__) == sorted(_native.SETTINGS)
    assert set(lg.MarginSettings.__annotations__) - set(lg.Settings.__annotations__) == {"counterweight_radius"}


def test_types_hold():
    for words in (["mypy", "--strict", "-p", "latchgate"], ["mypy.stubtest", "latchgate._native"]):
        done = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout


def test_threads_ask_at_once_and_get_the_same():
    expected = but_run(lg.replay(BURST, members=200).document)
    with ThreadPoolExecutor(8) as pool:
        results = [pool.submit(lg.replay, BURST, members=200, threads=1) for _ in range(24)]
        assert {but_run(result.result().document) for result in results} == {expected}
    shared = lg.replay(BURST, members=0)
    with ThreadPoolExecutor(8) as pool:
        pages = [pool.submit(shared._repr_html_) for _ in range(8)]
        assert len({page.result() for page in pages}) == 1


def test_other_threads_run_while_one_is_judged():
    ticks, done = [], threading.Event()

    def tick():
        while not done.wait(0.001):
            ticks.append(time.perf_counter())

    other = threading.Thread(target=tick)
    other.start()
    began = time.perf_counter()
    lg.margin(SIGNALS / "surviving.csv", members=0)
    ended = time.perf_counter()
    done.set()
    other.join()
    # A thread that never got the interpreter would not have counted at all.
    during = [at for at in ticks if began < at < ended]
    assert len(during) > 20


@pytest.mark.parametrize("question", ["lg.margin(path)", "lg.sweep([path] * 10_000)"])
def test_ctrl_c_ends_a_question(question):
    code = f"import latchgate as lg\npath = {str(SIGNALS / 'surviving.csv')!r}\nprint('begun', flush=True)\n{question}"
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "begun\n"
    time.sleep(0.3)
    assert child.poll() is None, "the question ended before it could be left"
    child.send_signal(signal.SIGINT)
    _, said = child.communicate(timeout=20)
    assert child.returncode in (130, -signal.SIGINT) and "KeyboardInterrupt" in said


def test_memory_stays_flat_over_ten_thousand_judgements():
    code = """
        import latchgate as lg, numpy as np
        t = np.arange(-0.01, 0.07, 5e-4)
        a = np.where((t > 0) & (t < 0.01), -20 * np.sin(np.pi * t / 0.01), 0.0)

        def resident_kib():
            return int(next(line for line in open("/proc/self/status") if line.startswith("VmRSS")).split()[1])

        def judge(count):
            for _ in range(count):
                lg.judge(t, a, unit="g", members=0, threads=1, opens_when="negative").verdict

        judge(1000)
        before = resident_kib()
        judge(10_000)
        print(resident_kib() - before)
    """
    assert int(run(code)) < 4096


SLED = "pulse:half-sine,peak=30g,duration=30ms,opens-when=positive"


def test_spectra_are_arrays_and_a_table():
    strong = {"name": "strong", "base": "paper", "lever": {"preload_torque_nm": 4.0}}
    strong["tolerance"] = {"preload_torque_nm": "2 %", "mass_kg": "1 %"}
    spectra = lg.spectrum([SLED, BURST], [strong])
    curves = len(spectra.names)
    assert spectra.stroke.shape == (24,) and spectra.stroke[0] == pytest.approx(1e-3)
    assert spectra.spectrum.shape == spectra.zone_from.shape == (curves, 24)
    # The pulse stands beside the recording, and no latch that it does not open is asked for more.
    recorded = [not name.startswith("pulse:") for name in spectra.names]
    highest = np.nanmax(spectra.spectrum[recorded], axis=0)
    np.testing.assert_array_equal(spectra.envelope, highest)
    table = spectra.to_pandas()
    assert list(table.columns) == spectra.names and table.index.name == "stroke_m"
    assert table.iloc[0, 0] == spectra.spectrum[0, 0] > 25 * 9.80665
    assert spectra.designs[0]["name"] == "strong" and spectra.designs[0]["place"] in ("above", "zone", "below")
    assert repr(spectra) == f"<latchgate.Spectrum of {curves} curves>"


def test_what_is_no_question_for_a_spectrum_is_refused(tmp_path):
    with pytest.raises(ValueError, match="empty"):
        lg.spectrum([])
    with pytest.raises(TypeError, match="list of designs"):
        lg.spectrum(SLED, "design.toml")
    with pytest.raises(ValueError, match="restitution"):
        lg.spectrum(SLED, restitution=(0.5, 1.2))
    empty = tmp_path / "empty.csv"
    empty.write_text("")
    with pytest.raises(lg.NotJudged, match="empty"):
        lg.spectrum([SLED, empty])
    left = lg.spectrum([SLED, empty], leave_out_unusable=True)
    assert left.data["left_out"][0]["file"] == "empty.csv"
