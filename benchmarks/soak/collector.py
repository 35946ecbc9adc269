"""A collector of chunks that never rests and spares no young ones: `python -m benchmarks.soak.collector`."""

from __future__ import annotations

import sys
import time

from jobs.artifacts.artifact_store import open_store
from jobs.artifacts.chunk_collection import collect_chunks
from jobs.home.home import Home

__all__ = ["collect_for_ever"]

PAUSE = 3.0  # seconds


def collect_for_ever(home: Home, pause: float = PAUSE) -> None:
    """Remove the chunks that no manifest names, again and again; faults of the store are told and passed over."""
    store = open_store(home)
    while True:
        try:
            print("removed", collect_chunks(store, delete=True, youngest=0.0), flush=True)
        except Exception as error:  # any exception of the store
            print(f"{type(error).__name__}: {error}", file=sys.stderr, flush=True)
        time.sleep(pause)


if __name__ == "__main__":
    collect_for_ever(Home.from_environment())
