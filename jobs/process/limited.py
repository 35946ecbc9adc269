"""A command in the sandbox and under the limits of a stage.

`python -m jobs.process.limited STAGE CAPTURE PROGRAM ARGUMENT...`: it may read CAPTURE and write nothing.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from jobs.home.home import Home
from jobs.process.file_limits import limit_files
from jobs.process.memory_limit import limit_memory
from jobs.process.process_tree import keep_orphans
from jobs.process.sandbox import enter_sandbox, with_links

__all__ = ["limit_stage"]


def limit_stage(home: Home, stage: str) -> None:
    """Limit this process and those that it starts to the memory and the files that a stage may have.

    Its processes are for whoever starts it to count (`jobs.process.process_tree`).
    """
    keep_orphans()
    limits = home.limits
    limit_memory(None if limits.memory is None else limits.memory.of(stage))
    limit_files(int(limits.files.of(stage)), limits.file_size.of(stage))


if __name__ == "__main__":
    limit_stage(Home.from_environment(), sys.argv[1])
    enter_sandbox(with_links(Path(sys.argv[2])))
    os.execv(sys.argv[3], sys.argv[3:])
