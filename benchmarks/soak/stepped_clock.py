"""Clocks of single processes that can be stepped while they run (Linux, with a C compiler)."""

from __future__ import annotations

import shutil
import struct
import subprocess
from collections.abc import Mapping
from pathlib import Path

__all__ = ["SteppedClock", "build_clock", "compiler"]

_SOURCE = Path(__file__).with_suffix(".c")


def compiler() -> str:
    """Return the path of a C compiler; "" if there is none."""
    return shutil.which("cc") or ""


def build_clock(folder: Path) -> Path:
    """Compile the library that processes preload into a folder, and return its path.

    Raises:
        subprocess.CalledProcessError: the compiler refuses.
    """
    library = folder / "stepped_clock.so"
    subprocess.run([compiler(), "-shared", "-fPIC", "-O2", "-o", library, _SOURCE, "-ldl"], check=True)
    return library


class SteppedClock:
    """The clock of one process and its children."""

    def __init__(self, library: Path, file: Path) -> None:
        """Begin without an offset, which `file` holds."""
        self._library, self._file = library, file
        file.write_bytes(struct.pack("d", 0.0))

    @property
    def environment(self) -> Mapping[str, str]:
        """The variables of a process with this clock."""
        return {"LD_PRELOAD": str(self._library), "HGS_SOAK_CLOCK": str(self._file)}

    def step_to(self, seconds: float) -> None:
        """Set the offset."""
        with self._file.open("r+b") as file:  # the same file, which is mapped into memory
            file.write(struct.pack("d", seconds))
