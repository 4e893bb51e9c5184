"""What is asked: settings, levers and arrays, as the native module takes them."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import TYPE_CHECKING, Any, TypedDict, Union

import numpy as np

from . import _native
from ._errors import NotJudged

if TYPE_CHECKING:
    import numpy.typing as npt

Path = Union[str, "os.PathLike[str]"]
#: A lever: a design file, or its tables as a dict; the paper's lever where none is stated.
Design = Union[Path, Mapping[str, Any]]


class Settings(TypedDict, total=False):
    """The keywords of every question, those of the command line with ``_`` for ``-``.

    What is left out is taken from the card beside the recording, from the file, or is the default.
    """

    input_format: str
    """Format of the file; detected if left out."""
    channel: str | int
    """Name or number (from 1) of the channel; the one lateral acceleration if left out."""
    radial_channel: str | int
    """Second in-plane channel, for a design with an axis."""
    time_column: str | int
    """Name or number of the column that holds the time."""
    time_unit: str
    """Unit of that column: "s", "ms", "us", "ns", "min", "h", "day", or "10us"."""
    time_source: str
    """Clock of a log's messages: "header", "log" or "publish"."""
    sheet: str
    """Name of the sheet of a workbook."""
    header_line: int
    """Line of a text table that names its columns, from 1."""
    unit_line: int
    """Line of a text table that holds the units, from 1."""
    last_line: int
    """Last line of a text table."""
    skip_lines: int
    """Lines at the start of a text table that are passed over."""
    decimal: str
    """Decimal mark: "." or ","."""
    rate_hz: float
    """Sample rate where the file holds no time [Hz]."""
    time_zero: float
    """Instant of first contact on the file's clock [s]."""
    unit: str
    """Unit of acceleration: "g", "mg", "m/s2", "cm/s2", "mm/s2", "mm/ms2", "ft/s2", "in/s2"."""
    sensitivity: str
    """What one of the samples means where they are another quantity: "20 g/V"."""
    accepted_remarks: list[str]
    """Remarks of the laboratory that a person has read and accepts, by their text."""
    velocity_change: float
    """Velocity change of the sensor's place, known from another source [m/s]."""
    accept: str | list[str]
    """What a person confirms of a recording: "clock", "axis", "noise", "processed", or a list of these."""
    transfer: float | str
    """Factor between the sensor's place and the latch, 1 or "0.8..1.5"; the worst answer counts."""
    siblings: bool
    """Judge every lateral channel of that side in the file; the worst answer counts."""
    sled206: bool
    """Check the recording as a sled pulse of 49 CFR 571.206 and UN R11."""
    opens_when: str
    """Sign of the recorded acceleration that opens: "negative", "positive" or "both"."""
    bias: str | Sequence[float]
    """Window whose mean is removed, (start, end) [s], or "none"."""
    filter: str
    """Channel frequency class: "none", "cfc60", "cfc180", "cfc600" or "cfc1000"."""
    filter_standard: str
    """Whose filter: "iso6487" or "saej211"."""
    between: str
    """How the acceleration runs between samples: "band-limited" or "linear"."""
    resample: float | str
    """Rate fed to the model [Hz], or "native"."""
    window: str | Sequence[float]
    """Judged window, (start, end) [s]; the whole record if left out."""
    model: str
    """Stop model: "auto", "rigid" or "soft"."""
    method: str
    """Integrator; all but "event-driven" are for comparison."""
    steps_per_period: int
    """Steps of the fixed-step methods per natural period of the lever."""
    tolerance: float
    """Error let pass in a step [rad]."""
    members: int
    """Largest number of varied levers; 0 for the nominal lever alone."""
    seed: int
    """Seed of the varied levers."""
    phi0: float
    """Initial angle [rad]; at rest on the stop if left out."""
    omega0: float
    """Initial angular velocity [rad/s]."""
    limit: dict[str, int]
    """Limits on input that are changed, by name."""


class MarginSettings(Settings, total=False):
    """The keywords of a margin."""

    counterweight_radius: float
    """Distance of the counterweight from the pivot, on its far side [m]."""


def settings_json(settings: Mapping[str, Any]) -> str:
    """Returns settings as JSON; of ``window`` and ``bias`` a pair of numbers is a window."""
    stated = {key: value for key, value in settings.items() if value is not None}
    for key in ("window", "bias"):
        if key in stated and not isinstance(stated[key], str):
            stated[key] = _window(key, stated[key])
    return json.dumps(stated, default=_plain, allow_nan=False)


def _window(name: str, pair: Any) -> str:
    if isinstance(pair, (Sequence, np.ndarray)) and len(pair) == 2:
        start, end = pair
        if isinstance(start, (Real, np.number)) and isinstance(end, (Real, np.number)):
            return f"{float(start)!r}..{float(end)!r}"
    raise ValueError(f"{name}: expected (start, end) in seconds or a text, found {pair!r}")


def lever(design: Design | None, changes: Mapping[str, float] | None) -> _native.Lever:
    """Reads a design and changes its keys."""
    assignments = [f"{key}={_number(value)}" for key, value in (changes or {}).items()]
    if isinstance(design, Mapping):
        text = "\n".join(f"{json.dumps(key)} = {_toml(value)}" for key, value in design.items())
        return _native.Lever(None, text, assignments)
    return _native.Lever(design, None, assignments)


def _toml(value: Any) -> str:
    """Returns a value as TOML writes it: a table in braces, but for the keys of the design itself."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{json.dumps(key)} = {_toml(entry)}' for key, entry in value.items())}}}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_toml(entry) for entry in value)}]"
    if isinstance(value, (np.generic, np.ndarray)):
        return _toml(value.tolist())
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _number(value: Any) -> str:
    return value if isinstance(value, str) else repr(float(value))


def _plain(value: Any) -> Any:
    """Returns what JSON has for a NumPy scalar, an array or a path."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    return os.fspath(value)


def file_name(name: str) -> str:
    """Returns a name if it is that of a file alone, on any system."""
    if not name or name == ".." or pathlib.PureWindowsPath(name).name != name:
        raise ValueError(f"name: expected a file name without a folder, found {name!r}")
    return name


def columns(t: Any, a: Any) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Returns time and acceleration as columns of one length; of a pandas.Series alone its index is the time."""
    if a is None:
        if not hasattr(t, "to_numpy"):
            raise TypeError("judge takes t [s] and a, or a pandas.Series whose index is the time [s]")
        t, a = t.index, t
    elif hasattr(t, "to_numpy") and hasattr(a, "to_numpy") and hasattr(t, "index") and hasattr(a, "index"):
        if not t.index.equals(a.index):
            raise NotJudged("t and a: their indexes differ, so their rows do not belong together; align them")
    # Of pandas an index alone has this; what numbers rows is no time.
    if hasattr(t, "get_indexer") and t.dtype.kind in "iu":
        raise NotJudged("t: expected a time [s], found whole numbers in an index: a row number, not a time; state t")
    time, values = _column("t", t), _column("a", a)
    if len(time) != len(values):
        raise NotJudged(f"t and a: expected one length, found {len(time)} and {len(values)}; cut the longer one")
    return time, values


def _column(name: str, values: Any) -> npt.NDArray[np.float64]:
    """Returns an array as it lies, where it holds doubles; other real numbers are converted."""
    if np.ma.is_masked(values):
        raise NotJudged(f"{name}: some values are masked; cut the recording before them")
    array = np.asarray(values)
    if array.ndim != 1:
        raise NotJudged(f"{name}: expected one dimension, found {array.ndim}; choose one channel")
    if array.dtype == np.bool_ or not np.can_cast(array.dtype, np.float64, "safe"):
        raise NotJudged(f"{name}: expected real numbers, found {array.dtype}; convert them, a time to seconds")
    array = array.astype(np.float64, copy=False)
    odd = np.flatnonzero(~np.isfinite(array))
    if odd.size:
        first = odd[0]
        raise NotJudged(f"{name}[{first}] is {array[first]}: every value must be finite; cut the recording before it")
    return array
