"""Portable names of uploaded files, which never lead out of their folder."""

from __future__ import annotations

import re
import unicodedata

from server.http.problems import ProblemError

__all__ = ["FolderNames", "capture_name", "normal_path"]

LONGEST_PATH = 1024  # bytes of UTF-8
LONGEST_NAME = 200  # bytes of UTF-8 per part; most file systems allow 255
DEEPEST = 8  # parts

# Windows devices, with any extension; a capture may be copied there.
_RESERVED = re.compile(r"(con|prn|aux|nul|com[0-9¹²³]|lpt[0-9¹²³])( *\..*)?", re.IGNORECASE)
# Controls, invisible marks (also those that reverse text), surrogates, private and unassigned characters.
_UNSEEN = frozenset(("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"))


def normal_path(path: str) -> str:
    """Return a path below an upload's folder in stored form: parts joined by `/`, in Unicode's NFC.

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
        raise _refusal(path, f"has {len(parts)} parts", f"at most {DEEPEST} are allowed; use fewer folders")
    for part in parts:
        _check_part(path, part)
    return normal


def capture_name(name: str) -> str:
    """Return the closest valid name of a capture's folder; "capture" if nothing is left.

    Unlike paths, which calibration files may refer to, the name is for people alone, so it is corrected, not rejected.
    """
    normal = unicodedata.normalize("NFC", name[:LONGEST_PATH])
    seen = "".join(" " if unicodedata.category(one) in _UNSEEN or one in '/\\:*?"<>|' else one for one in normal)
    words = " ".join(seen.split()).strip(". ")
    short = words.encode()[: LONGEST_NAME // 2].decode(errors="ignore").strip(". ")
    return short if short and not _RESERVED.fullmatch(short) else f"{short} capture".strip()


class FolderNames:
    """Files and folders of one upload: no two names may differ only in case or look-alike characters."""

    def __init__(self) -> None:
        self._files: dict[str, str] = {}  # stored paths by their comparison keys
        self._folders: dict[str, str] = {}

    def add(self, path: str) -> None:
        """Add a file by its normal path; adding it again changes nothing.

        Raises:
            ProblemError: 409, it would equal another file or folder when case is ignored.
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
        raise _refusal(path, "contains a backslash", "join parts with /")
    unseen = next((one for one in part if unicodedata.category(one) in _UNSEEN), None)
    if unseen is not None:
        raise _refusal(path, f"contains the invisible character U+{ord(unseen):04X}", "rename the file")
    if part != part.strip() or part.endswith("."):
        raise _refusal(
            path, f"has the part {part!r}, which begins or ends with a space or ends with a dot", "rename it"
        )
    if _RESERVED.fullmatch(part):
        raise _refusal(path, f"has the part {part!r}, which is a device on some systems", "rename it")
    if len(part.encode()) > LONGEST_NAME:
        raise _refusal(
            path, f"has a part of {len(part.encode())} bytes", f"at most {LONGEST_NAME} are allowed; shorten it"
        )


def _compared(path: str) -> str:
    """Return the comparison key of a path: equal for different case, widths and ligatures."""
    folded = unicodedata.normalize("NFKC", path).casefold()
    return unicodedata.normalize("NFKC", folded).casefold()


def _refusal(path: str, problem: str, cure: str) -> ProblemError:
    return ProblemError(422, "name-invalid", f"the path {path[:80]!r} {problem}; {cure}", field="path")


def _taken(path: str, part: str, other: str) -> ProblemError:
    detail = (
        f"the path {path[:80]!r}: {part[:80]!r} and {other[:80]!r} would be one file or folder on systems that ignore "
        "case and look-alike characters, or a file and a folder of one name; rename one of them"
    )
    return ProblemError(409, "name-taken", detail, field="path")
