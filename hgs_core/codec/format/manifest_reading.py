"""What no field of a manifest shows alone: the order of time, references between the lists, totals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hgs_core.codec.format.json_fields import Field

if TYPE_CHECKING:
    from hgs_core.codec.format.manifest import Manifest

__all__ = ["check_references"]


def check_references(manifest: Manifest, root: Field) -> None:
    """Check that the lists agree; `root` is the document that the manifest was read from.

    Raises:
        InputError: names the field, what it is and what it should be.
    """
    for name in ("segments", "slices", "cameras"):
        if not getattr(manifest, name):
            raise root[name].error("is empty, expected at least one")
    for name, entries in (("segments", manifest.segments), ("slices", manifest.slices)):
        starts = [entry.start for entry in entries]
        for i in range(1, len(starts)):
            if starts[i] < starts[i - 1]:
                raise root[name].items()[i]["start"].error(f"is {starts[i]}, before the one that precedes it")
    known: set[str] = {chunk.id for chunk in manifest.static}
    if len(known) < len(manifest.static):
        raise root["static"].error("lists a chunk twice")
    earlier: dict[str, int] = {}  # chunk -> segment
    for piece, field in zip(manifest.slices, root["slices"].items(), strict=True):
        if piece.segment >= len(manifest.segments):
            raise field["segment"].error(f"is {piece.segment}, expected below {len(manifest.segments)}")
        for need, item in zip(piece.needs, field["needs"].items(), strict=True):
            if earlier.get(need) != piece.segment:
                raise item.error(f"{need} is not a chunk of an earlier slice of the segment")
        for chunk, item in zip(piece.chunks, field["chunks"].items(), strict=True):
            if chunk.id in known:
                raise item["id"].error(f"{chunk.id} is listed twice")
            known.add(chunk.id)
            earlier[chunk.id] = piece.segment
    for number, sound in enumerate(manifest.audio.pieces if manifest.audio else ()):
        if sound.id in known:
            raise root["audio"]["pieces"].items()[number]["id"].error(f"{sound.id} is a chunk of splats")
    for name, total in vars(manifest.totals).items():
        stated = root["totals"][name].whole(0)
        if stated != total:
            raise root["totals"][name].error(f"is {stated}, but the chunks add up to {total}")
