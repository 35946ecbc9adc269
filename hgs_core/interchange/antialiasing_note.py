"""The note by which files say whether their splats are drawn antialiased, where their format has no place for that."""

from __future__ import annotations

from collections.abc import Iterable

from hgs_core.interchange.changes import Action, Change

__all__ = ["NOTE", "UNTOLD", "note_of", "noted", "noted_for_us"]

NOTE = "hgs_antialiased"
"""The name of the note; its value is "1" or "0" in texts, a boolean in JSON."""

UNTOLD = Change.whole(
    Action.ASSUMED,
    "drawing without antialiasing",
    "the file does not say; if its splats were trained antialiased (hgs does so, Mip-Splatting, and gsplat and "
    "Nerfstudio when told to), import it with --antialiased; --no-antialiased says that they were not",
)


def note_of(antialiased: bool) -> str:
    """Return the note as a line of text."""
    return f"{NOTE} {int(antialiased)}"


def noted(lines: Iterable[str]) -> bool | None:
    """Return the statement of the note among some lines, None if there is none."""
    found = None
    for line in lines:
        match line.split():
            case [name, "0" | "1" as value] if name == NOTE:
                found = value == "1"
    return found


def noted_for_us(antialiased: bool) -> Change | None:
    """Return the remark on a file with a note that only `hgs import` reads."""
    if not antialiased:
        return None
    reason = "by a note that hgs import reads: other programs draw thin splats too strong"
    return Change.whole(Action.REPLACED, "antialiasing", reason)
