"""The section on bytes: by attribute, and by layer in the order in which a client fetches them."""

from __future__ import annotations

from collections.abc import Sequence

from hgs_core.codec.format.attributes import Kind
from hgs_core.report.charts import Bar, Part, bar_chart, column_chart
from hgs_core.report.markup import chart, note, section, table
from hgs_core.report.scene_sizes import CONTAINER, ChunkSize
from hgs_core.report.sources import FinishedRun

__all__ = ["size_section"]

# What the columns of layers tell apart: eight colours are as many as eyes can.
_GROUPS = {
    "position": "position",
    "log_scale": "scale",
    "rotation": "rotation",
    "opacity": "opacity",
    "rgb": "colour",
    "time_center": "time",
    "time_log_precision": "time",
    "time_exponent": "time",
    "velocity": "motion",
    "acceleration": "motion",
    "jerk": "motion",
    "snap": "motion",
    "crackle": "motion",
    "turning": "motion",
}
_OTHER = "container"
_ORDER = tuple(dict.fromkeys([*_GROUPS.values(), _OTHER]))


def size_section(run: FinishedRun, chunks: Sequence[ChunkSize]) -> str:
    """Return the section."""
    manifest = run.folder.manifest.stat().st_size
    by_attribute = bar_chart("Kilobytes by attribute", _attribute_bars(chunks, manifest), "kB")
    groups = [
        (name, [_column(chunk, f"{name} layer {place}") for place, chunk in enumerate(chunks_of, start=1)])
        for name, chunks_of in (
            ("static", [chunk for chunk in chunks if chunk.kind == Kind.STATIC]),
            ("dynamic", [chunk for chunk in chunks if chunk.kind == Kind.DYNAMIC]),
        )
        if chunks_of
    ]
    charts = chart("By attribute", by_attribute, "Compressed bytes of every attribute's streams; 1 kB is 1,000 bytes.")
    if groups:
        words = "Static layers: the most visible first. Dynamic layers: in order of time."
        charts += chart("By layer", column_chart("Kilobytes by layer", groups, "kB"), words)
    rows = _rows(chunks)
    sound = run.manifest.bytes_audio
    heard = f", sound of {sound:,}" if sound else ""
    total = f"{run.bytes_total:,} bytes: chunks{heard} and a manifest of {manifest:,}; the thumbnail is not counted."
    head = ("attribute", "static bytes", "per splat", "dynamic bytes", "per splat")
    return section("size", "Size", [note(total), f'<div class="charts">{charts}</div>', table("Bytes", head, rows)])


def _sums(chunks: Sequence[ChunkSize], kind: Kind) -> dict[str, int]:
    sums: dict[str, int] = {}
    for chunk in chunks:
        if chunk.kind == kind:
            for name, size in chunk.streams.items():
                sums[name] = sums.get(name, 0) + size
    return sums


def _attribute_bars(chunks: Sequence[ChunkSize], manifest: int) -> list[Bar]:
    static, dynamic = _sums(chunks, Kind.STATIC), _sums(chunks, Kind.DYNAMIC)
    sizes = {name: (static.get(name, 0), dynamic.get(name, 0)) for name in {**static, **dynamic}}
    bars = [
        Bar(
            name.replace("_", " "),
            [
                Part("static", still / 1e3, 0, f"{still:,} bytes"),
                Part("dynamic", moving / 1e3, 1, f"{moving:,} bytes"),
            ],
            f"{(still + moving) / 1e3:.1f} kB",
        )
        for name, (still, moving) in sorted(sizes.items(), key=lambda item: -sum(item[1]))
    ]
    words = f"{manifest:,} bytes"
    return [*bars, Bar("manifest", [Part("manifest", manifest / 1e3, 7, words)], f"{manifest / 1e3:.1f} kB")]


def _column(chunk: ChunkSize, name: str) -> Bar:
    sums = dict.fromkeys(_ORDER, 0)
    for attribute, size in chunk.streams.items():
        sums[_GROUPS.get(attribute, _OTHER)] += size
    parts = [
        Part(group, size / 1e3, number, f"{size:,} bytes") for number, (group, size) in enumerate(sums.items()) if size
    ]
    slice_words = f", slice {chunk.slice + 1}" if chunk.kind == Kind.DYNAMIC else ""
    return Bar(name, parts, f"{chunk.splats:,} splats{slice_words}")


def _rows(chunks: Sequence[ChunkSize]) -> list[tuple[str, ...]]:
    sums = {kind: _sums(chunks, kind) for kind in Kind}
    splats = {kind: sum(chunk.splats for chunk in chunks if chunk.kind == kind) for kind in Kind}
    names = list(dict.fromkeys([*sums[Kind.STATIC], *sums[Kind.DYNAMIC]]))
    names = [*(name for name in names if name != CONTAINER), CONTAINER]

    def cells(size: dict[Kind, int | None]) -> tuple[str, ...]:
        return tuple(
            word
            for kind, value in size.items()
            for word in (
                ("-", "-") if value is None or not splats[kind] else (f"{value:,}", f"{value / splats[kind]:.2f}")
            )
        )

    rows = [(name.replace("_", " "), *cells({kind: sums[kind].get(name) for kind in Kind})) for name in names]
    return [*rows, ("all", *cells({kind: sum(sums[kind].values()) for kind in Kind}))]
