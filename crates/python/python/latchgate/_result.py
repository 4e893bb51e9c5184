"""What is answered."""

from __future__ import annotations

import functools
import html
import json
import math
import os
import pathlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, cast

from . import _native
from ._errors import NotJudged
from ._question import Path

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import pandas as pd

Verdict = Literal["pass", "fail", "undecided", "unusable"]

#: How the curves and marks of the event's plot look, by their class in the report.
_CURVES: dict[str, dict[str, Any]] = {
    "raw": {"color": "0.6", "linewidth": 0.8},
    "used": {"color": "black"},
    "velocity": {"color": "#23856d"},
    "run-soft": {"color": "#b45309"},
    "run-rigid": {"color": "#1f5fa8", "linestyle": "--"},
}
_MARKS = {"crossing": "#b3261e", "bad": "#b3261e", "peak": "#b45309", "contact": "0.5"}


@dataclass(frozen=True)
class Reason:
    """A reason for the verdict."""

    code: str
    text: str


@dataclass(frozen=True)
class Finding:
    """Something odd in the data, from ``at_s`` [s] on if that is stated."""

    code: str
    severity: Literal["blocking", "warning", "info"]
    text: str
    at_s: float | None
    #: A pass needs a person's word on it.
    needs_word: bool = False


@dataclass(frozen=True)
class Opening:
    """When the lever opens [s]: first the nominal one, then one in twenty, half and all but one in twenty of the
    varied ones that open; None where none does or none was asked."""

    first_s: float | None
    p05_s: float | None
    p50_s: float | None
    p95_s: float | None
    #: Stop and sign of the acceleration with which it opens.
    model: Literal["soft", "rigid"]
    opens_when: Literal["negative", "positive"]
    #: How many varied levers were asked, and how many of them open.
    members: int
    exceeded: int
    #: What differs between them.
    varied: str | None = None


class Result:
    """The answer for one recording and one lever.

    ``print(result)`` shows what the terminal shows. A result is never true or false: there are four
    answers, so compare ``result.verdict``.
    """

    def __init__(self, native: _native.Judged, files: list[Path]) -> None:
        self._native = native
        self._files = files
        self._folder: pathlib.Path | None = None
        #: The command line's JSON document, byte for byte but for its block ``run``.
        self.document: bytes = native.document()

    @functools.cached_property
    def data(self) -> dict[str, Any]:
        """The document as a dict: every number with all its digits, in SI units."""
        data: dict[str, Any] = json.loads(self.document)
        return data

    @property
    def verdict(self) -> Verdict:
        """``"pass"``, ``"fail"``, ``"undecided"`` or ``"unusable"``."""
        return cast(Verdict, self.data["verdict"])

    @property
    def why(self) -> list[Reason]:
        """The reasons, the weightiest first."""
        return [Reason(**_spelt(reason)) for reason in self.data["why"]]

    @property
    def findings(self) -> list[Finding]:
        """What is odd in the data, the gravest first."""
        return [Finding(**_spelt(finding)) for finding in self.data["findings"]]

    @property
    def opens(self) -> Opening | None:
        """When the lever opens; None where none does. Of an unusable recording nobody knows: that raises
        :class:`NotJudged`."""
        if self.verdict == "unusable":
            raise NotJudged(f"whether the lever opens is not known, the recording is unusable: {self._headline()}")
        opens = self.data["opens"]
        return None if opens is None else Opening(**opens)

    @property
    def peak(self) -> float | None:
        """Largest angle of the nominal lever [rad]; None where nothing can be said of it, as beyond 90°, where
        only :attr:`opens` counts."""
        nominal = self.data["nominal"]
        if self.verdict == "unusable" or nominal is None or nominal["peak_angle_rad"] > math.pi / 2:
            return None
        return float(nominal["peak_angle_rad"])

    @functools.cached_property
    def series(self) -> dict[str, npt.NDArray[np.float64]]:
        """Arrays by column, sample by sample: ``time_s`` [s], ``acceleration_recorded_m_s2`` and
        ``acceleration_used_m_s2`` [m/s²], ``velocity_m_s`` [m/s], and of each run
        ``angle_MODEL_SIGN_rad`` [rad] and ``angular_velocity_MODEL_SIGN_rad_s`` [rad/s]."""
        return self._native.series()

    def to_pandas(self) -> pd.DataFrame:
        """Returns :attr:`series` as a table over the time [s]; needs pandas."""
        import pandas as pd

        return pd.DataFrame(self.series).set_index("time_s")

    def plot(self, ax: Any = None) -> Any:
        """Draws acceleration, velocity and angle over the event, with the limit angle and the marks of the
        report, and returns the three axes; on ``ax`` the angle alone. Needs matplotlib."""
        event_json = self._native.event()
        if event_json is None:
            raise NotJudged("the recording holds nothing that could be drawn")
        import matplotlib.pyplot as plt

        event = json.loads(event_json)
        columns = list(self.series.values())
        scale = event["scale"]
        panels = event["panels"]
        if ax is None:
            heights = {"height_ratios": [panel["bottom"] - panel["top"] for panel in panels]}
            figure, drawn = plt.subplots(
                len(panels), sharex=True, figsize=(9, 7), gridspec_kw=heights, layout="constrained"
            )
            axes = list(drawn)
            figure.suptitle(f"{self.verdict.upper()}: {self._headline()}", wrap=True, fontsize="medium")
        else:
            drawn, axes, panels = ax, [ax], panels[-1:]
        for axis, panel in zip(axes, panels):
            for curve in panel["curves"]:
                values = columns[curve["column"]] * panel["factor"]
                look = _CURVES.get(curve["class"], {})
                axis.plot(columns[0] * scale, values, label=curve["name"], **look)
            for mark in event["marks"]:
                start, end, color = mark["start"] * scale, mark["end"] * scale, _MARKS.get(mark["class"], "0.5")
                label = mark["text"] if axis is axes[-1] else None
                if end > start:
                    axis.axvspan(start, end, color=color, alpha=0.25, label=label)
                else:
                    axis.axvline(start, color=color, linewidth=1, label=label)
            axis.set_ylim(*panel["range"])
            axis.set_ylabel(panel["title"])
        last = axes[-1]
        if bar := event["bar"]:
            at = bar["at_s"] * scale
            last.vlines(at, bar["low"], bar["high"], color="black", label="largest angle with its error")
        last.axhline(event["limit"], color="black", linestyle=":", label=f"limit angle {event['limit']:g} rad")
        last.set_xlim(*(edge * scale for edge in event["view"]))
        last.set_xlabel(f"time [{event['unit']}]")
        for axis in axes:
            axis.legend(fontsize="small", loc="best")
        return drawn

    def report(self, folder: Path, *, pdf: bool = False) -> pathlib.Path:
        """Writes the report into a folder and returns its page. With ``pdf`` a Chromium or Chrome that is
        installed prints it, too."""
        inside = pathlib.Path(folder)
        for file in self._files:
            beside = inside / pathlib.Path(file).name
            if beside.exists() and os.path.exists(file) and os.path.samefile(beside, file):
                raise ValueError(f"{beside}: the folder holds a file that was read; name another place")
        self._native.report(inside, pdf)
        self._folder = inside
        return inside / "report.html"

    def verify(self, *, threads: int | None = None) -> dict[str, Any]:
        """Makes the run again and compares every number, with the files of the report if one was written.
        ``["same"]`` of what is returned tells."""
        return Record(json.loads(self._native.verify(self._folder, threads)))

    def margin(self, *, counterweight_radius: float | None = None, threads: int | None = None) -> dict[str, Any]:
        """Returns how far the verdict is from changing, as :func:`latchgate.margin` does.
        ``counterweight_radius`` is its distance from the pivot [m]."""
        margin: dict[str, Any] = json.loads(self._native.margin(counterweight_radius, threads))
        return margin

    def save_csv(self, folder: Path = ".") -> pathlib.Path:
        """Writes the arrays that were judged into a folder, as the table of two columns of which
        :attr:`document` speaks, and returns its path. A file that is there is not replaced: FileExistsError."""
        table = self._native.bytes()
        if table is None:
            raise ValueError("the result is that of a file, not of arrays: the file is there")
        path = pathlib.Path(folder) / self._native.name
        with path.open("xb") as file:
            file.write(table)
        return path

    def _headline(self) -> str:
        """The sentence that says what the verdict means; where a setting decides, that comes first."""
        decides = [reason.text + " " for reason in self.why[:1] if reason.code == "setting-decides"]
        return "".join(decides) + self._native.headline()

    def __eq__(self, other: object) -> bool:
        if isinstance(other, str):
            raise TypeError("a result is not a word: compare .verdict")
        return self is other

    __hash__ = object.__hash__

    def __bool__(self) -> bool:
        raise TypeError("a result is not true or false: there are four answers, compare .verdict")

    def __str__(self) -> str:
        return self._native.text()

    def __repr__(self) -> str:
        return f"<latchgate.Result {self.verdict}: {self._headline()}>"

    def _repr_html_(self) -> str:
        page = html.escape(self._native.page())
        # As high as its page where a notebook lets it ask, else with a bar to scroll.
        fit = "this.style.height=this.contentDocument.documentElement.scrollHeight+'px'"
        return f'<iframe srcdoc="{page}" onload="{fit}" style="width:100%;height:900px;border:0"></iframe>'


def _spelt(entry: dict[str, Any]) -> dict[str, Any]:
    """Returns an entry of the document with Python's keywords in its text."""
    return {**entry, "text": _native.keywords(entry["text"])}


class Record(dict[str, Any]):
    """A dict that is neither true nor false, so that nobody takes one for a pass."""

    def __bool__(self) -> bool:
        key = next(key for key in ("same", "standing", "verdict") if key in self)
        raise TypeError(f'what holds an answer is not true or false: compare its ["{key}"]')


class _Table:
    """Rows as dicts."""

    def __init__(self, rows: list[dict[str, Any]]) -> None:
        #: One dict a pair of recording and design, recordings first.
        self.rows = [Record(row) for row in rows]

    def to_pandas(self) -> pd.DataFrame:
        """Returns the rows as a table; needs pandas."""
        import pandas as pd

        return pd.json_normalize(self.rows)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __bool__(self) -> bool:
        raise TypeError("a table of verdicts is not true or false: compare each row's verdict")


class Sweep(_Table):
    """The decisions of recordings × designs.

    A row has ``recording``, ``design``, ``verdict``, ``reason`` (``code``, ``text``), ``report_id``, and in
    radians ``threshold_rad``, ``peak_angle_rad``, ``uncertainty_rad``, ``coast_peak_angle_rad``; ``members``
    is the largest number of varied levers, 0 where the nominal lever alone was judged, and ``share`` bounds the part
    of them that open. A recording that cannot be read has rows that say ``unusable`` with the code ``input-refused``.
    Printed and in a notebook it is a table; beyond 90° that has no angle, as everywhere.
    """

    #: Rows of the table that is shown.
    _SHOWN = 60

    def _cells(self) -> list[list[str]]:
        cells = [["recording", "design", "verdict", "largest angle", "reason"]]
        for row in self.rows[: self._SHOWN]:
            peak = row["peak_angle_rad"]
            if peak is None:
                angle = ""
            else:
                angle = _native.peak_text(peak, row["uncertainty_rad"], row["threshold_rad"], row["verdict"] == "fail")
            cells.append([row["recording"], row["design"], row["verdict"], angle, row["reason"]["code"]])
        return cells

    def _more(self) -> str:
        more = len(self) - self._SHOWN
        return f"{more} more rows: to_pandas() has all" if more > 0 else ""

    def __repr__(self) -> str:
        cells = self._cells()
        widths = [max(map(len, column)) for column in zip(*cells)]
        lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in cells]
        return "\n".join([*lines, self._more()]).rstrip()

    def _repr_html_(self) -> str:
        head, *rows = [[html.escape(cell) for cell in row] for row in self._cells()]
        lines = [f"<tr><td>{'</td><td>'.join(row)}</td></tr>" for row in rows]
        return f"<table><tr><th>{'</th><th>'.join(head)}</th></tr>{''.join(lines)}</table>{self._more()}"


class GateResult(_Table):
    """What became of a gate; its rows are the pairs of the summary."""

    def __init__(self, document: bytes) -> None:
        #: The gate's summary.json.
        self.document = document
        #: The same as a dict.
        self.data: dict[str, Any] = json.loads(document)
        super().__init__(self.data["pairs"])

    @property
    def exit_code(self) -> int:
        """0: every pair is as required; else the worst of 4 (not judged), 1 and 3, as on the command line."""
        code: int = self.data["exit_code"]
        return code

    @property
    def counts(self) -> dict[str, int]:
        """How many pairs there are, by what became of them."""
        counts: dict[str, int] = self.data["counts"]
        return counts

    @property
    def problems(self) -> list[dict[str, str]]:
        """What is wrong beside the pairs: ``code`` and ``text``."""
        problems: list[dict[str, str]] = self.data["problems"]
        return problems

    @property
    def statics(self) -> list[dict[str, Any]]:
        """The static load that each design bears, where the gate requires one: ``design``, ``opens_at_g``,
        ``required_g``, ``holds``."""
        statics: list[dict[str, Any]] = self.data.get("statics", [])
        return statics

    def __repr__(self) -> str:
        shown = f"exit_code={self.exit_code} {self.counts}"
        for name, more in (("problems", self.problems), ("statics", self.statics)):
            if more:
                shown += f" {name}={more}"
        return f"<latchgate.GateResult {shown}>"


class Spectrum:
    """Latch response spectra: what any latch must have to survive recordings.

    Arrays have a row for each curve, in the order of :attr:`names`, and a column for each stroke; NaN where no window
    of lift-off opens, and of a zone where it reaches below the lowest window.
    """

    def __init__(self, data: dict[str, Any]) -> None:
        #: The document, as the command line writes it.
        self.data = data

    @property
    def names(self) -> list[str]:
        """The curves: recording, channel and the sign that opens."""
        return [curve["name"] for curve in self.data["recordings"]]

    @property
    def stroke(self) -> npt.NDArray[np.float64]:
        """Strokes [m]."""
        return _numbers(self.data["stroke_m"])

    @property
    def spectrum(self) -> npt.NDArray[np.float64]:
        """The spectrum of each curve at each stroke [m/s²]."""
        return _numbers(self.data["spectrum_m_s2"])

    @property
    def zone_from(self) -> npt.NDArray[np.float64]:
        """The lower end of its zone [m/s²]."""
        return _numbers(self.data["zone_from_m_s2"])

    @property
    def envelope(self) -> npt.NDArray[np.float64]:
        """The highest of the curves at each stroke [m/s²]."""
        return _numbers(self.data["envelope_m_s2"])

    @property
    def designs(self) -> list[dict[str, Any]]:
        """Designs with ``place`` ("above", "zone", "below"), ``reserve_load`` and ``reserve_preload``."""
        designs: list[dict[str, Any]] = self.data["designs"]
        return designs

    def to_pandas(self) -> pd.DataFrame:
        """Returns the spectra [m/s²] as a table, a stroke [m] a row and a curve a column; needs pandas."""
        import pandas as pd

        index = pd.Index(self.stroke, name="stroke_m")
        return pd.DataFrame(self.spectrum.T, index=index, columns=self.names)

    def __repr__(self) -> str:
        return f"<latchgate.Spectrum of {len(self.names)} curves>"


def _numbers(values: list[Any]) -> npt.NDArray[np.float64]:
    import numpy as np

    return np.array(values, dtype=np.float64)
