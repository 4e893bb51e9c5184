"""What the tests share: the project's folder, its recordings, and the program beside which they hold."""

import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).parents[3]
SIGNALS = ROOT / "signals"


@pytest.fixture(scope="session")
def latchgate():
    """Runs the command line and returns what it prints on stdout."""
    program = os.environ["LATCHGATE"]

    def run(*words, codes=(0, 1, 3, 4), cwd=ROOT):
        done = subprocess.run([program, *map(str, words)], cwd=cwd, capture_output=True, check=False)
        assert done.returncode in codes, done.stderr.decode()
        return done.stdout

    return run


def but_run(document):
    """A document up to its last block, which alone may differ between two runs."""
    head, mark, _ = document.partition(b'"run": {')
    assert mark
    return head
