"""The findings of a check, and their plain form on disk."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.corrected_poses import CorrectedCamera

__all__ = ["CameraResult", "CaptureCheck", "Finding", "ShownMatch", "ShownPair"]


@dataclass(frozen=True)
class Finding:
    """Something to look at."""

    stops: bool  # whether training would be in vain
    cameras: tuple[str, ...]  # it is about; none: the capture as a whole
    problem: str
    cure: str
    of_pictures: bool = False  # a stop that does not concern a training without these cameras' pictures
    corrected: tuple[CorrectedCamera, ...] = ()  # poses without the fault, not saved; empty: nothing undoes it exactly

    def sentence(self) -> str:
        """Return it as one line that names the cameras."""
        return f"{self.named()}; {self.cure}"

    def named(self) -> str:
        """Return the problem with the names of the cameras."""
        names = ", ".join(self.cameras)
        return f"{names}: {self.problem}" if names else self.problem


@dataclass(frozen=True)
class CameraResult:
    """The measurements of one camera."""

    name: str
    partners: int  # cameras that share a view with it
    matches: int  # matches with all partners
    error: float | None  # median distance from the epipolar lines, pixels; None without partners
    ahead: float | None  # frames, of most cameras; None where too little moves to tell
    outline: float | None = None  # median distance of epipolar tangents from silhouettes, pixels; None: not measured


@dataclass(frozen=True)
class ShownMatch:
    """A point in one picture and its match in another."""

    first: tuple[float, float]  # pixels
    second: tuple[float, float]
    line: tuple[float, float, float]  # a x + b y + c = 0 in the second picture, where the poses say that it lies


@dataclass(frozen=True)
class ShownPair:
    """Two pictures for people to look at."""

    cameras: tuple[str, str]
    frame: int
    sizes: tuple[tuple[int, int], tuple[int, int]]  # width and height that the pixels are of
    error: float  # pixels
    matches: tuple[ShownMatch, ...]


@dataclass(frozen=True)
class CaptureCheck:
    """The result of a check."""

    cameras: tuple[CameraResult, ...]
    findings: tuple[Finding, ...]
    shown: tuple[ShownPair, ...]
    frames: tuple[int, ...]  # checked frames
    width: int  # pixels of the largest picture that was looked at
    given: tuple[str, ...] = ()  # sentences on given depth maps and meshes

    @property
    def stops(self) -> tuple[Finding, ...]:
        """Return the findings that make training useless."""
        return tuple(finding for finding in self.findings if finding.stops)

    def to_json(self) -> dict[str, Any]:
        """Return the plain form of check.json and `hgs check --json`."""
        plain = dataclasses.asdict(self)
        for finding in plain["findings"]:
            del finding["corrected"]
        return plain | {"stops": bool(self.stops)}

    def save(self, path: Path) -> None:
        """Write the file, all at once."""
        write_bytes(path, json.dumps(self.to_json(), indent=1, allow_nan=False).encode())

    @classmethod
    def load(cls, path: Path) -> CaptureCheck:
        """Read a file that `save` wrote.

        Raises:
            InputError: the file is unreadable.
        """
        try:
            return cls._from_json(json.loads(path.read_text()))
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise InputError(path, f"unreadable ({error!r})", "delete it: the capture is checked again") from error

    @classmethod
    def _from_json(cls, value: dict[str, Any]) -> CaptureCheck:
        return cls(
            tuple(CameraResult(**one) for one in value["cameras"]),
            tuple(Finding(**one | {"cameras": tuple(one["cameras"])}) for one in value["findings"]),
            tuple(_pair(one) for one in value["shown"]),
            tuple(value["frames"]),
            value["width"],
            tuple(value.get("given", ())),
        )

    def table(self) -> str:
        """Return the table for people, one camera a line, with the findings below."""
        head: tuple[str, ...] = ("camera", "partners", "matches", "px", "ahead", "outline")
        known = len(head) - all(one.outline is None for one in self.cameras)
        rows = [row[:known] for row in (head, *(_cells(one) for one in self.cameras))]
        head = rows[0]
        widths = [max(len(row[column]) for row in rows) for column in range(len(head))]
        marked = {name: "stop" if any(f.stops for f in about) else "look" for name, about in self._by_camera().items()}
        lines = [
            "  ".join([row[0].ljust(widths[0]), *(cell.rjust(w) for cell, w in zip(row[1:], widths[1:], strict=True))])
            + (f"  {marked[row[0]]}" if row is not head and row[0] in marked else "")
            for row in rows
        ]
        lines += self.given
        lines += [("stop: " if finding.stops else "look: ") + finding.sentence() for finding in self.findings]
        return "\n".join(lines if self.findings else [*lines, "nothing stands out"])

    def _by_camera(self) -> dict[str, Sequence[Finding]]:
        names = {name for finding in self.findings for name in finding.cameras}
        return {name: [finding for finding in self.findings if name in finding.cameras] for name in names}


def _cells(one: CameraResult) -> tuple[str, ...]:
    error = "-" if one.error is None else f"{one.error:.2f}"
    ahead = "-" if one.ahead is None else f"{round(one.ahead, 1) + 0.0:+.1f}"
    outline = "-" if one.outline is None else f"{one.outline:.1f}"
    return (one.name, str(one.partners), str(one.matches), error, ahead, outline)


def _pair(value: dict[str, Any]) -> ShownPair:
    first, second = value["cameras"]
    one, other = (tuple(size) for size in value["sizes"])
    matches = tuple(
        ShownMatch(tuple(match["first"]), tuple(match["second"]), tuple(match["line"])) for match in value["matches"]
    )
    return ShownPair((first, second), value["frame"], (one, other), value["error"], matches)
