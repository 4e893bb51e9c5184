"""Judges the shares of a gate on a Dask cluster, round after round until nothing is missing.

    dask scheduler --host 127.0.0.1 --port 8786
    dask worker tcp://127.0.0.1:8786 --nthreads 1 --no-nanny --death-timeout 60     (on each machine)
    python examples/sweep_dask.py tcp://127.0.0.1:8786 /shared/gate.toml /shared/store 100 [options of --collect]

Gate, recordings and store lie where every worker sees them under the same path. A worker that is lost
costs a block, a scheduler that is lost a round: what a share has done stands in the store.
"""

import json
import os
import subprocess
import sys
import time

from distributed import Client

LATCHGATE = os.environ.get("LATCHGATE", "latchgate")
ROUNDS = 20


def gate(*words):
    return subprocess.run([LATCHGATE, "gate", *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True)


def share(path, store, part):
    """Judges one share, on a worker; returns what it has to say if it could not."""
    done = gate(path, "--store", store, "--threads", "1", "--part", part)
    return "" if done.returncode == 0 else f"share {part}: {done.stderr.strip()}"


def missing(path, store):
    done = gate(path, "--store", store, "--status", "--format", "json")
    done.check_returncode()
    return json.loads(done.stdout)["missing"]


def main(address, path, store, shares, *collecting):
    parts = [f"{number}/{shares}" for number in range(1, int(shares) + 1)]
    for _ in range(ROUNDS):
        try:
            with Client(address, timeout=60) as client:
                # Not pure: a share that was judged before is asked for again.
                futures = [client.submit(share, path, store, part, pure=False) for part in parts]
                print(*filter(None, client.gather(futures, errors="skip")), sep="\n", file=sys.stderr)
        except Exception as error:  # The cluster's own; what counts is what is missing.
            print(f"the round ended early: {error!r}", file=sys.stderr)
        if missing(path, store) == 0:
            break
        time.sleep(1)
    done = gate(path, "--store", store, "--collect", *collecting)
    print(done.stdout, done.stderr, sep="\n")
    return done.returncode


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
