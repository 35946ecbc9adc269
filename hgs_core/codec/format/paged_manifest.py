"""A manifest as far as a reader has it: an index, and those of its pages that have come."""

from __future__ import annotations

import dataclasses
import gzip
import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, NamedTuple

from hgs_core.base.errors import InputError
from hgs_core.codec.format.audio import AudioEntry, AudioPiece
from hgs_core.codec.format.chunk import MAX_CHUNK_BYTES
from hgs_core.codec.format.json_fields import Field, field_of
from hgs_core.codec.format.manifest import ChunkEntry, Manifest, SegmentEntry, SliceEntry
from hgs_core.codec.format.manifest_reading import read_manifest
from hgs_core.codec.format.pages import Page, read_page
from hgs_core.codec.format.paging import INDEX_FORMAT, INDEX_VERSION

__all__ = ["PageEntry", "PagedManifest", "read_index"]

_NOWHERE = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class PageEntry:
    """A page as the index lists it."""

    id: str  # SHA-256 of its bytes, lower-case hex
    bytes: int
    start: float  # start of its first slice, seconds
    segments: int  # how many are in it


def read_index(data: bytes, where: object = "index") -> dict[str, Any]:
    """Return an index as plain JSON: one of pages, or the whole manifest of a short scene.

    Raises:
        InputError: it is not gzip of a JSON object.
    """
    try:
        document = json.loads(gzip.decompress(data))
    except (OSError, EOFError, zlib.error, ValueError, RecursionError) as error:
        raise InputError(where, f"is not JSON in gzip ({error})") from error
    return dict(field_of(document, where).mapping())


class PagedManifest:
    """The manifest as far as an index and some of its pages describe it.

    In place of a page that has not come, `manifest` has a slice of one chunk, which is the page itself: the slice
    cannot be shown without it, as without any other chunk. Where a scene has grown, an earlier version of its last page
    stands for the beginning of the later one until that has come.
    """

    def __init__(self, index: Mapping[str, Any], where: object = "index") -> None:
        """Read an index, given as plain JSON.

        Raises:
            InputError: names the field that is wrong, after `where`.
        """
        root = field_of(dict(index), where)
        self.pages: tuple[PageEntry, ...] = ()
        self._where = where
        self._read: dict[float, tuple[str, Page]] = {}  # start -> id and page
        self._places: dict[str, int] = {}  # id -> place of the page
        self._parts: list[_Part] = []  # contribution of each page, or of its stand-in
        self._manifest: Manifest | None = None
        if root["format"].value != INDEX_FORMAT:
            self._manifest = read_manifest(root.value, where)
            return
        if root["version"].whole(1) != INDEX_VERSION:
            raise root["version"].error(f"is {root['version'].value}, expected {INDEX_VERSION}")
        self.pages = tuple(_entry(field) for field in root["pages"].items())
        if not self.pages:
            raise root["pages"].error("is empty, expected at least one")
        self._header = _header(root["manifest"])
        self._arrange()

    @property
    def manifest(self) -> Manifest:
        """The manifest as far as it has come; another object whenever more of it has."""
        if self._manifest is None:
            self._manifest = self._composed()
        return self._manifest

    def continued_by(self, later: PagedManifest) -> bool:
        """Return whether another one is a later version of this scene."""
        before, after = self.manifest, later.manifest
        if before.live is None or (after.live is not None and after.live <= before.live) or after.end < before.end:
            return False
        full = [(entry.start, entry.segments) for entry in self.pages[:-1]]
        same = [(entry.start, entry.segments) for entry in later.pages[: len(full)]]
        return before.static == after.static and (not later.pages or same == full)

    def become(self, later: PagedManifest) -> None:
        """Go on with a later version of the scene; the pages that have come stay."""
        self.pages, self._manifest = later.pages, later.manifest
        if self.pages:
            self._header = later._header
            self._arrange()

    def lacks(self, name: str) -> bool:
        """Return whether there is such a page, and it has not come."""
        place = self._places.get(name)
        return place is not None and self._page(self.pages[place]) is None

    def add(self, name: str, data: bytes) -> None:
        """Take a page that is lacking.

        Raises:
            InputError: it is damaged, or has not what the index says.
        """
        page = read_page(data, f"{self._where}: page {name}")
        place = self._places[name]
        entry = self.pages[place]
        if len(page.segments) != entry.segments:
            raise InputError(f"page {name}", f"has {len(page.segments)} segments, the index says {entry.segments}")
        self._read[entry.start] = name, page
        self._parts[place] = self._part(place)
        self._manifest = None

    def listed(self) -> dict[str, list[str]]:
        """Return by page which chunks, and then pieces of sound, it lists in order: of the pages that have come.

        Of a scene that grows the last page is left out: it may have become another one.
        """
        found: dict[str, list[str]] = {}
        for entry in self.pages if self.manifest.live is None else self.pages[:-1]:
            if page := self._page(entry):
                names = [chunk.id for piece in page.slices for chunk in piece.chunks]
                found[entry.id] = names + [piece.id for piece in page.pieces]
        return found

    def _page(self, entry: PageEntry) -> Page | None:
        name, page = self._read.get(entry.start, ("", None))
        return page if name == entry.id else None

    def _arrange(self) -> None:
        """Work out the place and contribution of every page; an arriving page changes its own part alone."""
        counts = [entry.segments for entry in self.pages]
        self._firsts = list(accumulate(counts, initial=0))
        self._places = {entry.id: place for place, entry in enumerate(self.pages)}
        self._parts = [self._part(place) for place in range(len(self.pages))]
        self._manifest = None

    def _part(self, place: int) -> _Part:
        entry, first = self.pages[place], self._firsts[place]
        start = entry.start
        end = self._header.end if place + 1 == len(self.pages) else self.pages[place + 1].start
        segments: list[SegmentEntry] = []
        slices: list[SliceEntry] = []
        _, page = self._read.get(start, ("", None))
        if page is not None:
            segments += page.segments
            slices += [dataclasses.replace(piece, segment=first + piece.segment) for piece in page.slices]
            start = slices[-1].end
        if self._page(entry) is None:
            lacking = entry.segments - len(segments)
            chunk = ChunkEntry(entry.id, entry.bytes, 0, _NOWHERE)
            slices.append(SliceEntry(first + len(segments), start, max(start, end), (chunk,), ()))
            segments += [SegmentEntry(start, max(start, end))] * lacking
        return _Part(segments, slices, () if page is None else page.pieces)

    def _composed(self) -> Manifest:
        header, audio = self._header, self._header.audio
        if audio is not None:
            audio = dataclasses.replace(audio, pieces=tuple(piece for part in self._parts for piece in part.pieces))
        segments = tuple(segment for part in self._parts for segment in part.segments)
        slices = tuple(piece for part in self._parts for piece in part.slices)
        return dataclasses.replace(header, segments=segments, slices=slices, audio=audio)


class _Part(NamedTuple):
    """The contribution of a page to the manifest, its segments numbered in the whole scene."""

    segments: Sequence[SegmentEntry]
    slices: Sequence[SliceEntry]
    pieces: Sequence[AudioPiece]


def _entry(field: Field) -> PageEntry:
    return PageEntry(
        field["id"].hash(),
        field["bytes"].whole(1, MAX_CHUNK_BYTES),
        field["start"].number(),
        field["segments"].whole(1),
    )


def _header(field: Field) -> Manifest:
    """Read an index's description of the whole scene; the manifest has one segment and one slice without motion."""
    document = dict(field.mapping())
    audio = document.pop("audio", None)
    span = {"start": field["start"].number(), "end": field["end"].number(low=field["start"].number())}
    totals = {**field["totals"].mapping(), "splats_dynamic": 0, "bytes_dynamic": 0}
    slices = [{"segment": 0, "chunks": [], "needs": [], **span}]
    manifest = read_manifest(document | {"segments": [span], "slices": slices, "totals": totals}, field.path)
    if audio is None:
        return manifest
    sound = Field(f"{field.path}.audio", audio)
    entry = AudioEntry(sound["codec"].text(), sound["sample_rate"].whole(1), sound["channels"].whole(1), ())
    return dataclasses.replace(manifest, audio=entry)
