"""What is raised where there is no answer."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterable


class NotJudged(ValueError):
    """There is no answer: the data cannot be read as asked for. The message says what to do.

    Where several channels could be meant, ``candidates`` lists what ``channel=`` takes for each.
    A keyword or a word that does not exist is a TypeError or a plain ValueError.
    """

    message: str
    candidates: list[str]

    def __init__(self, message: str, candidates: Iterable[str] = ()) -> None:
        self.message = message
        self.candidates = list(candidates)
        super().__init__(message, self.candidates)

    def __str__(self) -> str:
        return self.message


class MissingFile(NotJudged, FileNotFoundError):
    """There is no file of that name: a FileNotFoundError with its ``filename``."""

    def __init__(self, message: str, candidates: Iterable[str] = (), filename: str | None = None) -> None:
        super().__init__(message, candidates)
        self.errno, self.strerror, self.filename = errno.ENOENT, os.strerror(errno.ENOENT), filename
