import builtins
import os
from typing import Any, final

import numpy as np
import numpy.typing as npt

__all__ = [
    "SETTINGS",
    "Judged",
    "Lever",
    "__version__",
    "inspect",
    "keywords",
    "margin",
    "peak_text",
    "restored",
    "rows",
    "run_gate",
    "spectrum",
    "table",
]

__version__: str
SETTINGS: list[str]

@final
class Lever:
    name: str
    def __new__(cls, file: str | os.PathLike[str] | None, text: str | None, changes: list[str]) -> Lever: ...

@final
class Judged:
    name: str
    def __new__(
        cls,
        path: str | os.PathLike[str],
        bytes: builtins.bytes | None,
        settings: str,
        lever: Lever,
        threads: int | None,
    ) -> Judged: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def bytes(self) -> builtins.bytes | None: ...
    def document(self) -> builtins.bytes: ...
    def text(self) -> str: ...
    def headline(self) -> str: ...
    def series(self) -> dict[str, npt.NDArray[np.float64]]: ...
    def event(self) -> str | None: ...
    def page(self) -> str: ...
    def report(self, folder: str | os.PathLike[str], with_pdf: bool) -> None: ...
    def verify(self, folder: str | os.PathLike[str] | None, threads: int | None) -> str: ...
    def margin(self, counterweight_radius: float | None, threads: int | None) -> str: ...

def inspect(path: str | os.PathLike[str], settings: str, threads: int | None) -> str: ...
def keywords(text: str) -> str: ...
def margin(path: str | os.PathLike[str], settings: str, lever: Lever, threads: int | None) -> str: ...
def peak_text(peak: float, uncertainty: float | None, threshold: float, opens: bool) -> str: ...
def restored(
    path: str | os.PathLike[str],
    bytes: bytes | None,
    settings_design: tuple[str, str],
    document: bytes,
) -> Judged: ...
def rows(
    recordings: list[str | os.PathLike[str]], settings: str, levers: list[Lever], threads: int | None
) -> tuple[int, str]: ...
def run_gate(
    path: str | os.PathLike[str],
    store: str | os.PathLike[str] | None,
    out: str | os.PathLike[str] | None,
    date: str | None,
    threads: int | None,
) -> str: ...
def spectrum(
    recordings: list[str | os.PathLike[str]],
    settings: str,
    levers_share: tuple[float, float, float, float | None],
    leave_out_unusable: bool,
    levers: list[Lever],
    threads: int | None,
) -> str: ...
def table(
    time: npt.NDArray[np.float64],
    values: npt.NDArray[np.float64],
    unit: str | None,
    time_unit: str | None,
) -> bytes: ...
