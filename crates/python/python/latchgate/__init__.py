"""latchgate replays a measured crash acceleration through a model of a door-latch lever and says, with
evidence, whether the door stays shut.

    >>> import latchgate as lg
    >>> result = lg.replay("burst.csv", opens_when="negative")
    >>> result.verdict
    'fail'

Angles are in rad, times in s, accelerations in m/s² unless a unit is stated. Keywords are those of the
command line with ``_`` for ``-``: see :class:`Settings`. What cannot be judged raises :class:`NotJudged`; a file
that is missing raises one that is a FileNotFoundError, too.
Any number of threads may ask at once; Ctrl-C ends a question.
"""

from __future__ import annotations

import datetime
import json
import os
import warnings
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from . import _native
from ._errors import NotJudged
from ._native import __version__
from ._question import Design, MarginSettings, Path, Settings, columns, file_name, lever, settings_json
from ._result import Finding, GateResult, Opening, Reason, Result, Spectrum, Sweep

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = [
    "Finding",
    "Gate",
    "GateResult",
    "MarginSettings",
    "NotJudged",
    "Opening",
    "Reason",
    "Result",
    "Settings",
    "Spectrum",
    "Sweep",
    "__version__",
    "inspect",
    "judge",
    "margin",
    "replay",
    "spectrum",
    "sweep",
]


def replay(
    path: Path,
    *,
    design: Design | None = None,
    set: Mapping[str, float] | None = None,
    threads: int | None = None,
    **settings: Unpack[Settings],
) -> Result:
    """Judges a recording, with the card beside it.

    :param path: CSV, a workbook, LVM, TDMS, EV5, ISO-MME or MCAP, or a pulse by its word:
        ``"pulse:half-sine,peak=30g,duration=11ms"``.
    :param design: a design file, or its tables as a dict; the paper's lever if left out.
    :param set: keys of the design that are changed: ``{"lever.preload_torque_nm": 2.82}``.
    :param threads: all cores if left out; the numbers do not depend on it.
    :param settings: see :class:`Settings`.
    """
    return _judge(path, None, design, set, threads, settings)


def judge(
    t: Any,
    a: Any = None,
    *,
    design: Design | None = None,
    set: Mapping[str, float] | None = None,
    threads: int | None = None,
    name: str = "arrays.csv",
    **settings: Unpack[Settings],
) -> Result:
    """Judges arrays, as the table of two columns that :meth:`Result.save_csv` writes: ``judge(t, a, unit="g")``.

    :param t: time [s] from first contact; or a pandas.Series whose index is that time. ``time_unit="ms"`` states
        another unit.
    :param a: acceleration in the unit that is stated; doubles are read where they lie.
    :param name: the file name that the document bears, without a folder.
    :param settings: see :class:`Settings`. ``unit`` is never guessed: state it, or for volts and counts
        ``sensitivity``. The other parameters are as for :func:`replay`.
    """
    time, values = columns(t, a)
    # The table's head states both, as that of a file would.
    unit, time_unit = settings.pop("unit", None), settings.pop("time_unit", None)
    if unit is None and "sensitivity" not in settings:
        raise TypeError('judge takes the unit of a: unit="g", or sensitivity="20 g/V"')
    table = _native.table(time, values, unit, time_unit)
    return _judge(file_name(name), table, design, set, threads, settings)


#: Findings of times that seem to be in another unit: nothing else that an answer says is of use then.
_SUSPECTED_TIMES = {"time-unit-implausible", "window-in-milliseconds"}


def _judge(
    path: Path,
    table: bytes | None,
    design: Design | None,
    changes: Mapping[str, float] | None,
    threads: int | None,
    settings: Mapping[str, Any],
) -> Result:
    native = _native.Judged(path, table, settings_json(settings), lever(design, changes), threads)
    files: list[Path] = [] if table is not None else [path, f"{path}.toml"]
    if design is not None and not isinstance(design, Mapping):
        files.append(design)
    result = Result(native, files)
    for finding in result.findings:
        if finding.code in _SUSPECTED_TIMES:
            warnings.warn(finding.text, stacklevel=3)
    return result


def inspect(path: Path, *, threads: int | None = None, **settings: Unpack[Settings]) -> dict[str, Any]:
    """Returns what a recording holds, channel by channel, and which channel :func:`replay` takes. Judges nothing."""
    listing: dict[str, Any] = json.loads(_native.inspect(path, settings_json(settings), threads))
    return listing


def margin(
    path: Path,
    *,
    design: Design | None = None,
    set: Mapping[str, float] | None = None,
    threads: int | None = None,
    **settings: Unpack[MarginSettings],
) -> dict[str, Any]:
    """Returns how far the verdict is from changing, and what design would pass, as ``latchgate margin`` does.

    The parameters are those of :func:`replay`. It takes seconds to minutes.
    """
    text = _native.margin(path, settings_json(settings), lever(design, set), threads)
    document: dict[str, Any] = json.loads(text)
    return document


def sweep(
    recordings: Iterable[Path],
    designs: Iterable[Design | None] = (None,),
    *,
    threads: int | None = None,
    **settings: Unpack[Settings],
) -> Sweep:
    """Judges every recording with every design; each recording is read once, recordings side by side.

    The order of the rows is that of recordings and designs, whatever the threads. Each design has a name of its own.
    """
    if isinstance(recordings, str) or isinstance(designs, (str, Mapping)):
        raise TypeError("sweep takes a list of recordings and a list of designs")
    paths, levers = list(recordings), [lever(design, None) for design in designs]
    if not paths or not levers:
        raise ValueError("sweep judges nothing: the list of recordings or of designs is empty")
    names = [design.name for design in levers]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"several designs have the name {', '.join(twice)}; give each its own, so that rows can be told apart")
    members, text = _native.rows(paths, settings_json(settings), levers, threads)
    decisions = json.loads(text)
    return Sweep(
        [
            {"recording": str(path), "design": design.name, "members": members, **row}
            for path, rows in zip(paths, decisions)
            for design, row in zip(levers, rows)
        ]
    )


def spectrum(
    recordings: Path | Iterable[Path],
    designs: Iterable[Design] = (),
    *,
    restitution: float | tuple[float, float] = 0.8,
    limit_angle: float = 0.1,
    share: float | None = None,
    leave_out_unusable: bool = False,
    threads: int | None = None,
    **settings: Unpack[Settings],
) -> Spectrum:
    """Returns what any latch must have to survive the recordings: a latch response spectrum each, and their envelope.

    It describes and passes nothing: a verdict comes from :func:`replay`.

    :param recordings: one path, or several.
    :param designs: levers to place beside the curves, with their reserves; these take longer than the curves.
    :param restitution: of the stop; a pair is drawn evenly between its two.
    :param limit_angle: for which a chart is read [rad].
    :param share: also the curve that covers this share of the curves.
    :param leave_out_unusable: go on without recordings that have no spectrum.
    :param settings: see :class:`Settings`; those of the decision have no effect.
    """
    if isinstance(designs, (str, Mapping)):
        raise TypeError("spectrum takes a list of designs")
    paths = [recordings] if isinstance(recordings, (str, os.PathLike)) else list(recordings)
    if not paths:
        raise ValueError("spectrum describes nothing: the list of recordings is empty")
    low, high = restitution if isinstance(restitution, tuple) else (restitution, restitution)
    text = _native.spectrum(
        paths,
        settings_json(settings),
        (float(low), float(high), float(limit_angle), share),
        leave_out_unusable,
        [lever(design, None) for design in designs],
        threads,
    )
    return Spectrum(json.loads(text))


class Gate:
    """A gate file: recordings, designs, and what is required of each pair."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def run(
        self,
        *,
        threads: int | None = None,
        store: Path | None = None,
        out: Path | None = None,
        date: str | datetime.date | None = None,
    ) -> GateResult:
        """Judges every pair.

        :param store: folder of decisions for the next run; without it nothing is kept.
        :param out: folder of summary and reports, which is replaced; without it none is written.
        :param date: day for exceptions that expire, a date or "YYYY-MM-DD"; today (UTC) if left out.
        """
        if isinstance(date, datetime.date):
            date = date.isoformat()
        summary = _native.run_gate(self.path, store, out, date, threads)
        return GateResult(summary.encode())

    def __bool__(self) -> bool:
        raise TypeError("a gate is not true or false: compare .run().exit_code")

    def __repr__(self) -> str:
        return f"latchgate.Gate({str(self.path)!r})"
