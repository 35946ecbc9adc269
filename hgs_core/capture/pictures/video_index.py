"""The facts in the packets of videos, read once: a long video has many packets, and few of its facts are in the header.

They are kept in memory for this process, and in a folder beside a run for others. A video of another size or time of
change is read anew.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import json
import threading
from collections import OrderedDict
from fractions import Fraction
from pathlib import Path
from typing import Any

from hgs_core.base.atomic import write_bytes
from hgs_core.base.version import software_version
from hgs_core.capture.pictures.frame_display import FrameDisplay
from hgs_core.capture.pictures.video_packets import VideoPackets

__all__ = ["indexed_packets"]

_MOST_KEPT = 256  # videos in memory
_FRACTIONS = ("rate", "tick", "aspect")

_kept: OrderedDict[str, tuple[str, VideoPackets]] = OrderedDict()  # path -> state of the file, packets
_lock = threading.Lock()


def indexed_packets(path: Path, folder: Path | None = None) -> VideoPackets:
    """Return the facts in the packets and the first frame of a video.

    With a folder they are read from there, or else written there if that can be done.

    Raises:
        InputError: as `VideoPackets.of`.
    """
    if not path.is_file():
        return VideoPackets.of(path)  # the error is its own
    name, state = str(path.absolute()), _state(path)
    file = None if folder is None else folder / f"{hashlib.sha256(name.encode()).hexdigest()[:32]}.json"
    with _lock:
        known, packets = _kept.get(name, ("", None))
    if packets is None or known != state:
        packets = None if file is None else _read(file, state)
    found = VideoPackets.of(path) if packets is None else packets
    with _lock:
        _kept[name] = state, found
        _kept.move_to_end(name)
        if len(_kept) > _MOST_KEPT:
            _kept.popitem(last=False)
    if file is not None and not (packets is not None and file.exists()):
        with contextlib.suppress(OSError):  # a run that cannot be written can still be read
            write_bytes(file, _written(found, state))
    return found


def _state(path: Path) -> str:
    """Return the size and the time of change of a file, and the version of the software."""
    found = path.stat()
    return f"{found.st_size} {found.st_mtime_ns} {software_version()}"


def _written(packets: VideoPackets, state: str) -> bytes:
    plain = dataclasses.asdict(packets)
    plain |= {name: str(plain[name]) for name in _FRACTIONS}
    return json.dumps({"state": state, "packets": plain}, separators=(",", ":")).encode()


def _read(file: Path, state: str) -> VideoPackets | None:
    """Return the packets of a file that `_written` made; None: it is missing, damaged or of another state."""
    try:
        document: dict[str, Any] = json.loads(file.read_bytes())
        if document["state"] != state:
            return None
        plain = document["packets"]
        plain |= {name: Fraction(plain[name]) for name in _FRACTIONS}
        return VideoPackets(
            **plain | {"size": tuple(plain["size"]), "display": FrameDisplay.from_plain(plain["display"])}
        )
    except (OSError, ValueError, KeyError, TypeError, ZeroDivisionError):
        return None
