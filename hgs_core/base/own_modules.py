"""Processes that run our own modules, regardless of the working directory's files.

`python -m` and `python -c` look for every import in the working directory first. A `numpy.py`, or the `jobs.py` and the
`server/` of somebody's own project, would run there in the place of ours, with a worker's secrets.
"""

from __future__ import annotations

import os
import sys
from collections.abc import MutableMapping

__all__ = ["guard_imports", "module_command"]

_SAFE_PATH = "PYTHONSAFEPATH"
_PATH = "PYTHONPATH"


def module_command(module: str, *arguments: str) -> list[str]:
    """Return the command line that runs a module of an installed package under this Python."""
    return [sys.executable, "-P", "-m", module, *arguments]


def guard_imports(environment: MutableMapping[str, str] = os.environ) -> None:
    """Keep the working directory out of the imports of every Python that inherits this environment.

    Children of `multiprocessing` and of libraries are such. An empty part of `PYTHONPATH`, as `$PYTHONPATH:/opt/lib`
    leaves it where nothing was set, would stand for the working directory, too; what names a folder stays.
    """
    environment[_SAFE_PATH] = "1"
    if _PATH in environment:
        environment[_PATH] = os.pathsep.join(part for part in environment[_PATH].split(os.pathsep) if part)
