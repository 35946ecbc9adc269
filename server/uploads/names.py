"""Names of uploaded files: paths that mean the same file on every system, and none that leads out of its folder."""

from __future__ import annotations

import re
import unicodedata

from server.http.problems import ProblemError

__all__ = ["FolderNames", "capture_name", "normal_path"]

LONGEST_PATH = 1024  # bytes of UTF-8
LONGEST_NAME = 200  # bytes of UTF-8 of one part; file systems end at 255
DEEPEST = 8  # parts

# Devices on Windows, with any ending; a capture may be copied there.
_RESERVED = re.compile(r"(con|prn|aux|nul|com[0-9¹²³]|lpt[0-9¹²³])( *\..*)?", re.IGNORECASE)
# Controls, marks that are not seen (also those that turn text around), halves of pairs, private and unassigned ones.
_UNSEEN = frozenset(("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"))


def normal_path(path: str) -> str:
    """Return a path below an upload's folder in the form in which it is stored: parts joined by `/`, in Unicode's NFC.

    Raises:
        ProblemError: 422, the path is empty, absolute, too long or too deep, or has a part such as `..`, `.hidden`,
            `con.txt` or one with a backslash, a control character, or a space or dot at its end.
    """
    normal = unicodedata.normalize("NFC", path) if len(path) <= LONGEST_PATH else path
    parts = normal.split("/")
    if not path:
        raise _refusal(path, "is empty", "give a path such as cam00.mp4 or images/cam00/0000.png")
    if normal.startswith("/"):
        raise _refusal(path, "is absolute", "give it relative to the capture's folder")
    if len(normal.encode(errors="replace")) > LONGEST_PATH:
        raise _refusal(path, f"is longer than {LONGEST_PATH} bytes", "shorten it")
    if len(parts) > DEEPEST:
        raise _refusal(path, f"has {len(parts)} parts", f"at most {DEEPEST} are taken; put the file higher up")
    for part in parts:
        _check_part(path, part)
    return normal


def capture_name(name: str) -> str:
    """Return the name for a capture's folder that is nearest to the given one; "capture" where nothing is left of it.

    Unlike paths, which calibration files may refer to, the name is for people alone, and so it is mended, not refused.
    """
    normal = unicodedata.normalize("NFC", name[:LONGEST_PATH])
    seen = "".join(" " if unicodedata.category(one) in _UNSEEN or one in '/\\:*?"<>|' else one for one in normal)
    words = " ".join(seen.split()).strip(". ")
    short = words.encode()[: LONGEST_NAME // 2].decode(errors="ignore").strip(". ")
    return short if short and not _RESERVED.fullmatch(short) else f"{short} capture".strip()


class FolderNames:
    """The files and folders of one upload: none may be another's name in capitals or look-alike characters."""

    def __init__(self) -> None:
        self._files: dict[str, str] = {}  # the path as it is stored, by what it is compared by
        self._folders: dict[str, str] = {}

    def add(self, path: str) -> None:
        """Add a file by its normal path; adding it again changes nothing.

        Raises:
            ProblemError: 409, it would be the same as another file or folder where capitals do not count.
        """
        parts = path.split("/")
        folders = ["/".join(parts[:count]) for count in range(1, len(parts))]
        for folder in folders:
            key = _compared(folder)
            other = self._files.get(key) or self._folders.get(key, folder)
            if other != folder or key in self._files:
                raise _taken(path, folder, other)
        key = _compared(path)
        other = self._folders.get(key) or self._files.get(key, path)
        if other != path or key in self._folders:
            raise _taken(path, path, other)
        self._files[key] = path
        self._folders.update((_compared(folder), folder) for folder in folders)


def _check_part(path: str, part: str) -> None:
    if part in ("", ".", ".."):
        raise _refusal(path, f"has the part {part!r}", "give plain names between single slashes")
    if part.startswith("."):
        raise _refusal(path, f"has the hidden part {part!r}", "leave it out, or rename it")
    if "\\" in part:
        raise _refusal(path, "holds a backslash", "join parts with /")
    unseen = next((one for one in part if unicodedata.category(one) in _UNSEEN), None)
    if unseen is not None:
        raise _refusal(path, f"holds the character U+{ord(unseen):04X}, which cannot be seen", "rename the file")
    if part != part.strip() or part.endswith("."):
        raise _refusal(
            path, f"has the part {part!r}, which begins or ends with a space or ends with a dot", "rename it"
        )
    if _RESERVED.fullmatch(part):
        raise _refusal(path, f"has the part {part!r}, which is a device on some systems", "rename it")
    if len(part.encode()) > LONGEST_NAME:
        raise _refusal(
            path, f"has a part of {len(part.encode())} bytes", f"at most {LONGEST_NAME} are taken; shorten it"
        )


def _compared(path: str) -> str:
    """Return what paths are compared by: alike for capitals, widths and ligatures."""
    folded = unicodedata.normalize("NFKC", path).casefold()
    return unicodedata.normalize("NFKC", folded).casefold()


def _refusal(path: str, problem: str, cure: str) -> ProblemError:
    return ProblemError(422, "name-invalid", f"the path {path[:80]!r} {problem}; {cure}", field="path")


def _taken(path: str, part: str, other: str) -> ProblemError:
    detail = (
        f"the path {path[:80]!r}: {part[:80]!r} and {other[:80]!r} would be one file or folder on systems where "
        "capital letters and look-alike characters do not count, or a file and a folder of one name; rename one of them"
    )
    return ProblemError(409, "name-taken", detail, field="path")
