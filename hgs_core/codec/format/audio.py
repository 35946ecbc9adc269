"""The sound of a scene as the manifest lists it (docs/format.md, "Sound")."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from hgs_core.codec.format.chunk import MAX_CHUNK_BYTES
from hgs_core.codec.format.json_fields import Field

__all__ = ["AudioEntry", "AudioPiece", "CodedAudio"]

_MOST_CHANNELS = 255
_FASTEST = 1_000_000  # samples per second


@dataclass(frozen=True)
class AudioPiece:
    """A stretch of sound, a chunk of its own."""

    id: str  # SHA-256 of its bytes, lower-case hex; pieces of equal content have one
    bytes: int
    start: float  # seconds on the scene's clock
    end: float  # end of its last decoded sample, after `start`


@dataclass(frozen=True)
class AudioEntry:
    """The sound of a scene."""

    codec: str  # "opus" (in Ogg) or "aac" (in ADTS); readers play no other
    sample_rate: int
    channels: int
    pieces: tuple[AudioPiece, ...]  # sorted; they do not overlap, and need not touch

    @property
    def sizes(self) -> dict[str, int]:
        """The bytes of every distinct piece by its id, in order of time."""
        return {piece.id: piece.bytes for piece in self.pieces}

    def to_json(self) -> dict[str, Any]:
        """Return the plain form."""
        return vars(self) | {"pieces": [vars(piece).copy() for piece in self.pieces]}

    @classmethod
    def read(cls, field: Field) -> AudioEntry:
        """Read the plain form."""
        pieces = tuple(
            AudioPiece(
                one["id"].hash(),
                one["bytes"].whole(1, MAX_CHUNK_BYTES),
                one["start"].number(),
                one["end"].number(above=one["start"].number()),
            )
            for one in field["pieces"].items()
        )
        if not pieces:
            raise field["pieces"].error("is empty, expected at least one")
        for i in range(1, len(pieces)):
            if pieces[i].start <= pieces[i - 1].start:
                raise field["pieces"].items()[i]["start"].error(f"is {pieces[i].start}, not after the one before")
        sizes: dict[str, int] = {}
        for piece, one in zip(pieces, field["pieces"].items(), strict=True):
            if sizes.setdefault(piece.id, piece.bytes) != piece.bytes:
                raise one["bytes"].error(f"is {piece.bytes}, but {sizes[piece.id]} of an equal piece before")
        return cls(
            field["codec"].text(),
            field["sample_rate"].whole(1, _FASTEST),
            field["channels"].whole(1, _MOST_CHANNELS),
            pieces,
        )


@dataclass(frozen=True)
class CodedAudio:
    """The sound of a scene with the bytes of its pieces."""

    entry: AudioEntry
    chunks: Mapping[str, bytes]  # id -> bytes

    def moved(self, seconds: float, start: float, end: float) -> CodedAudio | None:
        """Return it `seconds` later, and of it the pieces that sound from `start` to `end`; None if none do."""
        later = (AudioPiece(p.id, p.bytes, p.start + seconds, p.end + seconds) for p in self.entry.pieces)
        return self._of(piece for piece in later if piece.end > start and piece.start < end)

    def _of(self, pieces: Iterable[AudioPiece]) -> CodedAudio | None:
        kept = tuple(pieces)
        if not kept:
            return None
        entry = AudioEntry(self.entry.codec, self.entry.sample_rate, self.entry.channels, kept)
        return CodedAudio(entry, {name: self.chunks[name] for name in entry.sizes})
