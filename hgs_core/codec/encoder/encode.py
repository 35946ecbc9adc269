"""From a trained scene to a scene folder: manifest.json, chunks/<sha256>, thumbnail.jpg."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.atomic import write_bytes
from hgs_core.base.cores import core_pool
from hgs_core.codec.encoder.chunking import Layer, dynamic_layers, slice_limits, static_layers
from hgs_core.codec.encoder.encode_chunk import encode_static_chunk
from hgs_core.codec.encoder.encode_dynamic import encode_dynamic_chunk
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.find_captured_space import find_captured_space
from hgs_core.codec.encoder.prepare import prepare_dynamic, prepare_static
from hgs_core.codec.encoder.scene_chunks import CodedChunk, SceneChunks
from hgs_core.codec.encoder.segment_times import Shown, frame_interval, shown_segments
from hgs_core.codec.encoder.utility import SetUtility, Utility
from hgs_core.codec.encoder.viewpoint import find_viewpoint
from hgs_core.codec.format.audio import CodedAudio
from hgs_core.codec.format.captured_space import CapturedSpace
from hgs_core.codec.format.chunk import VERSIONS
from hgs_core.codec.format.decode import DecodedChunk
from hgs_core.codec.format.manifest import Manifest, SegmentEntry, SliceEntry
from hgs_core.codec.format.scene_folder import CHUNKS, MANIFEST, THUMBNAIL
from hgs_core.codec.format.start_views import StartViews
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene
from hgs_core.scene.temporal import lifetime

__all__ = ["encode_scene"]

Triple = tuple[float, float, float]


def encode_scene(
    scene: HybridScene[Floats],
    out: Path,
    *,
    cameras: Sequence[Camera],
    times: NDArray[np.float64],
    title: str,
    settings: EncodeSettings | None = None,
    thumbnail: Callable[[bool], bytes] | None = None,
    training: Mapping[str, Any] | None = None,
    utility: Utility | None = None,
    closer: Sequence[Camera] = (),
    trained: Sequence[Camera] = (),
    start_views: StartViews | None = None,
    narrowed: Callable[[CapturedSpace, Triple, Triple], CapturedSpace] | None = None,
    metres_per_unit: float | None = None,
    up: Triple | None = None,
    audio: CodedAudio | None = None,
    chunks: SceneChunks | None = None,
) -> Manifest:
    """Write `scene` to the folder `out` and return its manifest.

    `times` [F] are the seconds of the capture's frames, `thumbnail` returns a JPEG picture, given whether viewers begin
    with the subject alone, `training` is anything JSON can hold, `utility` what every splat was measured to do to the
    capture's pictures (else it is guessed from size and opacity, and nothing is pruned for it). Splats are sized for
    how `cameras` and `closer` see them; the manifest names the former. `trained` are those of them whose pictures made
    the scene: they tell the manifest's captured space, which it lacks without them; `narrowed` returns that space with
    further limits, given also its centre and the scene's `up`. `start_views` are the first views of viewers, else the
    first camera. `metres_per_unit`, above 0, tells headsets how large the scene is, where that is known. `up` is the
    unit vector that points upwards; without it, the mean of the cameras' upward directions. `audio` is the scene's
    sound, on the clock of `times`. `chunks` hold the scene's splats already.
    Equal arguments give equal bytes. The manifest appears last and atomically; chunks of an earlier scene in the same
    folder are removed after that.

    Raises:
        InputError: the scene, the cameras or the times hold what cannot be encoded.
        RuntimeError: a chunk does not decode within its declared bounds (a fault of this program).
        OSError: the folder cannot be written.

    Example:
        >>> import hgs_core as hgs
        >>> from pathlib import Path
        >>> capture, scene = hgs.open_capture(Path("capture")), hgs.load_scene(Path("run/scene.npz"))
        >>> manifest = hgs.encode_scene(
        ...     scene, Path("encoded"), cameras=capture.cameras, times=capture.times, title="Spheres"
        ... )
        >>> manifest.totals.splats_static == len(hgs.decode_scene(Path("encoded")).static)
        True
    """
    settings = settings or EncodeSettings()
    times = np.asarray(times, np.float64)
    interval = frame_interval(times)
    segments = shown_segments(scene, interval)
    moving = [np.asarray(s.dynamic.motion, np.float64)[:, 0] for s in scene.segments if len(s.dynamic)]
    points = np.concatenate(moving) if moving else np.asarray(scene.static.means, np.float64)
    view = find_viewpoint(cameras, points)
    up = view.up if up is None else up
    if chunks is None:
        chunks = _scene_chunks(scene, segments, (*cameras, *closer), utility, settings)
    space = find_captured_space(trained, view.center, up, moves=scene.dynamic_splats > 0) if trained else None
    if space and narrowed:
        space = narrowed(space, view.center, up)
    alone = space is not None and space.subject_only
    manifest = Manifest(
        title=title,
        start=scene.start,
        end=scene.end,
        frame_rate=1 / interval,
        background=scene.background,
        up=up,
        center=view.center,
        extent=view.extent,
        cameras=tuple(cameras),
        segments=tuple(SegmentEntry(segment.start, segment.end) for segment in scene.segments),
        static=tuple(chunk.entry for chunk in chunks.static),
        slices=chunks.slices,
        thumbnail=thumbnail is not None,
        training=dict(training or {}),
        antialiased=scene.antialiased,
        start_views=start_views,
        photographed=bool(trained),
        captured_space=space,
        metres_per_unit=metres_per_unit,
        audio=None if audio is None else audio.entry,
        version=max([VERSIONS[0], *(chunk.version for chunk in chunks)]),
    )
    stored = {chunk.entry.id: chunk.data for chunk in chunks} | dict(audio.chunks if audio is not None else {})
    _write(out, manifest, stored, None if thumbnail is None else thumbnail(alone))
    return manifest


def _scene_chunks(
    scene: HybridScene[Floats],
    segments: Sequence[Shown],
    cameras: Sequence[Camera],
    utility: Utility | None,
    settings: EncodeSettings,
) -> SceneChunks:
    static = _static_chunks(scene, cameras, utility, settings)
    moving: list[CodedChunk] = []
    slices: list[SliceEntry] = []
    for shown in segments:
        known = None if utility is None else utility.dynamic[shown.number]
        index = len(static) + len(moving)
        pieces, chunks = _segment_chunks(shown, cameras, known, settings.of_dynamic, index, scene.antialiased)
        slices += pieces
        moving += chunks
    return SceneChunks(tuple(static), tuple(moving), tuple(slices))


def _static_chunks(
    scene: HybridScene[Floats],
    cameras: Sequence[Camera],
    utility: Utility | None,
    settings: EncodeSettings,
) -> list[CodedChunk]:
    known = None if utility is None else utility.static
    splats = prepare_static(scene.static, cameras, known, settings, antialiased=scene.antialiased)

    def coded(layer: Layer, index: int) -> CodedChunk:
        return CodedChunk.of(*encode_static_chunk(splats.take(layer.index), settings, index))

    with core_pool() as pool:
        return list(pool.map(coded, static_layers(splats, settings), itertools.count()))


def _segment_chunks(
    shown: Shown,
    cameras: Sequence[Camera],
    utility: SetUtility | None,
    settings: EncodeSettings,
    index: int,
    antialiased: bool,
) -> tuple[list[SliceEntry], list[CodedChunk]]:
    """Encode a segment; `index` numbers its first chunk."""
    time = shown.time
    splats = prepare_dynamic(
        shown.segment.dynamic, time.shown_until, shown.frame, cameras, utility, settings, antialiased=antialiased
    )
    seconds, limits = slice_limits(time, shown.until, settings)
    count = len(limits) - 1
    chunks: list[list[tuple[float, CodedChunk]]] = [[] for _ in range(count)]
    needs: list[list[str]] = [[] for _ in range(count)]

    def encoded(layer: Layer, place: int) -> tuple[bytes, DecodedChunk]:
        return encode_dynamic_chunk(splats.take(layer.index), time, settings, place)

    layers = dynamic_layers(splats, time, limits, settings)
    with core_pool() as pool:
        encodings = list(pool.map(encoded, layers, itertools.count(index)))
    for layer, (data, decoded) in zip(layers, encodings, strict=True):
        chunk = CodedChunk.of(data, decoded)
        first, last = _slices_lived_in(decoded, limits)
        chunks[first].append((layer.utility, chunk))
        for later in range(first + 1, last + 1):
            needs[later].append(chunk.entry.id)
    ordered = [[chunk for _, chunk in sorted(piece, key=lambda one: -one[0])] for piece in chunks]
    slices = [
        SliceEntry(
            shown.number,
            float(seconds[i]),
            float(seconds[i + 1]),
            tuple(chunk.entry for chunk in ordered[i]),
            tuple(needs[i]),
        )
        for i in range(count)
    ]
    return slices, [chunk for piece in ordered for chunk in piece]


def _slices_lived_in(chunk: DecodedChunk, limits: Doubles) -> tuple[int, int]:
    """Return the first and the last slice in which splats of a chunk live as they decode.

    The first can precede the one that the chunk was cut for: where nearly all splats of a chunk are opaque, its steps
    are coarser and some lives longer than `SegmentTime.life` foresees.
    """
    start, end = lifetime(chunk.dynamic())
    moments = np.array([start.min(), end.max()], np.float64)
    first, last = np.clip(np.searchsorted(limits, moments, side="right") - 1, 0, len(limits) - 2)
    return int(first), int(last)


def _write(out: Path, manifest: Manifest, chunks: Mapping[str, bytes], thumbnail: bytes | None) -> None:
    text = json.dumps(manifest.to_json(), allow_nan=False, separators=(",", ":"))
    for name, data in chunks.items():
        write_bytes(out / CHUNKS / name, data)
    if thumbnail is not None:
        write_bytes(out / THUMBNAIL, thumbnail)
    write_bytes(out / MANIFEST, text.encode())
    for file in (out / CHUNKS).glob("*"):
        if file.name not in chunks:
            file.unlink()
    if thumbnail is None:
        (out / THUMBNAIL).unlink(missing_ok=True)
