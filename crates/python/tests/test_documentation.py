"""The examples of the documentation run."""

import os
import pathlib
import re

import latchgate as lg
import nbformat
import numpy as np
import pytest
from asammdf import MDF, Signal
from conftest import ROOT
from nbclient import NotebookClient
from nptdms import ChannelObject, TdmsWriter


def test_the_notebook_runs(monkeypatch):
    monkeypatch.delenv("MPLBACKEND", raising=False)
    path = ROOT / "examples/first_verdict.ipynb"
    notebook = nbformat.read(path, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "the notebook is kept without outputs"
    NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(path.parent)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    shown = " ".join(str(output) for output in outputs)
    # Card and plot, the values, the picture, the terminal's text, the sweep, the refusal.
    parts = ["text/html", "('fail', 0.0144", "image/png", "recording    arrays.csv", "('60 N·m', 'pass')", "no channel `z`"]
    for part in parts:
        assert part in shown, part


def recordings(folder):
    """Writes the recordings that the page speaks of."""
    t = np.arange(-0.02, 0.15, 1e-4)
    a = np.where((t > 0) & (t < 0.011), -30 * np.sin(np.pi * t / 0.011), 0.0)
    properties = {"unit_string": "g", "wf_increment": 1e-4, "wf_start_offset": -0.02}
    with TdmsWriter(folder / "crash.tdms") as file:
        file.write_segment([ChannelObject("Vehicle", "sill acc y", a, properties=properties)])
    mdf = MDF()
    mdf.append(Signal(a, t, unit="g", name="sill acc y"))
    mdf.save(folder / "crash.mf4")
    table = np.column_stack([t, a, 0.9 * a])
    head = "time [s],sill acc y [g],b-pillar acc y [g]"
    np.savetxt(folder / "two_channels.csv", table, delimiter=",", header=head, comments="")


def test_the_pages_examples_run(tmp_path, monkeypatch, capsys):
    text = (ROOT / "docs/python.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) == text.count("```python") >= 7
    recordings(tmp_path)
    os.symlink(ROOT / "signals", tmp_path / "signals")
    monkeypatch.chdir(tmp_path)
    names, results = {}, {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
        results[block] = names["result"]
    assert {result.verdict for result in results.values()} == {"fail"}
    assert names["not_passed"] == ["signals/burst.csv"] * 3
    printed = capsys.readouterr().out
    assert "'sill acc y [g]', 'b-pillar acc y [g]'" in printed
    tables = re.findall(r"```text\n(.*?)```", text, re.DOTALL)
    assert tables and all(table in printed for table in tables)
    # Of one signal there is one answer, whoever reads the file.
    read_here = lg.replay("crash.tdms", opens_when="negative").peak
    for reader in ("TdmsFile", "MDF"):
        (result,) = [result for block, result in results.items() if reader in block]
        assert result.peak == pytest.approx(read_here, rel=1e-9), reader
