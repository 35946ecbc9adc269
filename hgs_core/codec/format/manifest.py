"""The manifest of a scene: typed, strictly validated, and written as JSON (docs/format.md, "Manifest")."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hgs_core.codec.format.audio import AudioEntry
from hgs_core.codec.format.captured_space import CapturedSpace
from hgs_core.codec.format.chunk import VERSIONS, Box
from hgs_core.codec.format.start_views import StartViews
from hgs_core.scene.camera import Camera

__all__ = ["FORMAT", "ChunkEntry", "Manifest", "SegmentEntry", "SliceEntry", "Totals"]

FORMAT = "hgs-scene"
Triple = tuple[float, float, float]


@dataclass(frozen=True)
class ChunkEntry:
    """A chunk as the manifest lists it."""

    id: str  # SHA-256 of its bytes, lower-case hex; the name of its file
    bytes: int
    splats: int
    box: Box  # holds the centre of every splat whenever it can be seen, world units

    def to_json(self) -> dict[str, Any]:
        """Return the plain form."""
        return {"id": self.id, "bytes": self.bytes, "splats": self.splats, "box": [list(c) for c in self.box]}


@dataclass(frozen=True)
class SegmentEntry:
    """A stretch of time with its own dynamic splats; seconds."""

    start: float
    end: float


@dataclass(frozen=True)
class SliceEntry:
    """A part of a segment: every splat alive at a moment of it is in `chunks` or `needs`."""

    segment: int  # index
    start: float  # seconds
    end: float  # seconds
    chunks: tuple[ChunkEntry, ...]  # splats that first live in this slice
    needs: tuple[str, ...]  # ids of chunks of earlier slices with splats that still live


@dataclass(frozen=True)
class Totals:
    """Sums over the lists of chunks."""

    splats_static: int
    splats_dynamic: int
    bytes_static: int
    bytes_dynamic: int


@dataclass(frozen=True)
class Manifest:
    """Everything about a scene but its splats."""

    title: str
    start: float  # seconds of the capture's clock
    end: float  # seconds
    frame_rate: float  # frames per second, above 0
    background: Triple  # sRGB in [0, 1]
    up: Triple  # unit vector, world
    center: Triple  # pivot of an orbit camera, world units
    extent: float  # typical distance of the cameras from `center`, above 0
    cameras: tuple[Camera, ...]
    segments: tuple[SegmentEntry, ...]
    static: tuple[ChunkEntry, ...]  # most visible first: any prefix draws
    slices: tuple[SliceEntry, ...]  # sorted by time
    thumbnail: bool  # thumbnail.jpg lies beside the manifest
    training: Mapping[str, Any]  # free form
    antialiased: bool = False  # the splats were trained to be drawn so
    start_views: StartViews | None = None  # first views of viewers; None: the first camera
    photographed: bool = False  # `cameras` took the pictures that made the splats, at these sizes
    captured_space: CapturedSpace | None = None  # viewpoints that can be trusted; None: unknown
    metres_per_unit: float | None = None  # length of a world unit, above 0; None: not known
    audio: AudioEntry | None = None  # sound; None: none
    version: int = VERSIONS[0]  # format version, the latest of any chunk
    live: int | None = None  # the scene grows, and this is its manifest's number, from 1; None: it is complete

    @property
    def chunks(self) -> tuple[ChunkEntry, ...]:
        """All chunks: the static ones, then those of the slices in order."""
        return self.static + tuple(chunk for piece in self.slices for chunk in piece.chunks)

    @property
    def rig(self) -> tuple[Camera, ...]:
        """The cameras of the pictures that made the splats, none if the cameras were made up."""
        return self.cameras if self.photographed else ()

    @property
    def bytes_audio(self) -> int:
        """The bytes of the sound, 0 without any."""
        return 0 if self.audio is None else sum(self.audio.sizes.values())

    @property
    def totals(self) -> Totals:
        """Sums over the lists of chunks."""
        dynamic = self.chunks[len(self.static) :]
        return Totals(
            sum(chunk.splats for chunk in self.static),
            sum(chunk.splats for chunk in dynamic),
            sum(chunk.bytes for chunk in self.static),
            sum(chunk.bytes for chunk in dynamic),
        )

    def to_json(self) -> dict[str, Any]:
        """Return the plain form that manifest.json holds."""
        document: dict[str, Any] = {
            "format": FORMAT,
            "version": self.version,
            "title": self.title,
            "start": self.start,
            "end": self.end,
            "frame_rate": self.frame_rate,
            "background": list(self.background),
            "up": list(self.up),
            "center": list(self.center),
            "extent": self.extent,
            "cameras": [camera.to_json() for camera in self.cameras],
            "segments": [vars(segment).copy() for segment in self.segments],
            "static": [chunk.to_json() for chunk in self.static],
            "slices": [
                {
                    "segment": piece.segment,
                    "start": piece.start,
                    "end": piece.end,
                    "chunks": [chunk.to_json() for chunk in piece.chunks],
                    "needs": list(piece.needs),
                }
                for piece in self.slices
            ],
            "totals": vars(self.totals).copy(),
            "thumbnail": self.thumbnail,
            "training": dict(self.training),
            "antialiased": self.antialiased,
        }
        if self.photographed != (self.captured_space is not None):
            document["photographed"] = self.photographed
        if self.captured_space is not None:
            document["captured_space"] = self.captured_space.to_json()
        if self.start_views is not None:
            document["start_views"] = self.start_views.to_json()
        if self.metres_per_unit is not None:
            document["metres_per_unit"] = self.metres_per_unit
        if self.live is not None:
            document["live"] = self.live
        if self.audio is not None:
            document["audio"] = self.audio.to_json()
        return document
