"""Which folders of the server's disk the API may read captures from."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from hgs_core.base.errors import InputError
from server.problems import ProblemError

__all__ = ["CaptureFolders"]

SETTING = "HGS_CAPTURES"


@dataclass(frozen=True)
class CaptureFolders:
    """The folders, absolute and with symbolic links resolved, in the order in which relative paths are looked up."""

    folders: tuple[Path, ...]

    @classmethod
    def configured(cls, home: Path, given: str = "", environment: Mapping[str, str] = os.environ) -> Self:
        """Return the folders `given` as a path list, else those of `HGS_CAPTURES`, else the defaults.

        The defaults are captures/ in the service's home, and samples/ of the repository when run from a checkout.
        """
        listed = [Path(part) for part in (given or environment.get(SETTING, "")).split(os.pathsep) if part]
        if not listed:
            samples = Path(__file__).resolve().parent.parent / "samples"
            listed = [home / "captures"] + ([samples] if samples.is_dir() else [])
        return cls(tuple(folder.expanduser().resolve() for folder in listed))

    def locate(self, capture: str) -> Path:
        """Return the absolute path of a capture named by a client.

        Raises:
            ProblemError: 403, the path lies outside the folders, by `..` or a symbolic link too.
            InputError: there is nothing at the path.
        """
        try:
            candidates = [(folder / capture).resolve() for folder in self.folders]
            inside = [path for path in candidates if any(path.is_relative_to(folder) for folder in self.folders)]
            found = next((path for path in inside if path.is_dir()), None)
        except (OSError, RuntimeError, ValueError) as error:  # too long, a loop of links, no text of the file system
            raise InputError("capture", f"{capture[:80]!r} is not a path") from error
        if not inside:
            raise ProblemError(
                403,
                "capture-outside",
                f"capture {capture!r}: lies outside the folders the server may read; add its folder to {SETTING}",
                field="capture",
            )
        if found is None:
            raise InputError("capture", f"{capture!r} is not a folder", "give the folder of a capture")
        return found
