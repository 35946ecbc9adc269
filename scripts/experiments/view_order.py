"""What a first picture would gain if static splats came in an order by the view, and not by use alone.

    python -m scripts.experiments.view_order RUN --cameras 4 --mbit 2

Chunks of a scene hold splats of like use from all over the scene, so that none of them is out of sight. Here every
static chunk is cut into cells of space, `--cells` of them. Each costs its share of the chunk's bytes, times what
encoding the scene's static splats in such cells takes more than in whole chunks. "use" is the scene as it is, chunk by
chunk; "view" takes the cells whose box the camera sees, layer after layer, and then the others. Printed are, for
cameras of the capture and the same ones with half of their field of view: the share of the static bytes in sight, the
bytes and the seconds of the line until the base of what is seen and of the first slice are there, and the PSNR (dB)
against the whole scene with as many bytes of static splats.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch

from hgs_core.codec.encoder.encode_chunk import encode_static_chunk
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.prepare import prepare_static
from hgs_core.codec.format.decode import decode_chunk
from hgs_core.codec.format.layers import SLICE_PART, STATIC_PART, layers
from hgs_core.codec.format.manifest import Manifest
from hgs_core.codec.format.scene_folder import CHUNKS, load_manifest
from hgs_core.render import rasterize
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats, joined

LONGEST_SIDE = 512  # pixels of the pictures
SHARES = (0.25, 0.5, 0.75)  # of the static bytes, at which pictures are compared
Floats = npt.NDArray[np.float32]
Splats = StaticSplats[Floats]


@dataclass(frozen=True)
class Cell:
    """A part of a static chunk."""

    splats: Splats
    layer: int
    size: float  # bytes

    def seen_by(self, camera: Camera) -> bool:
        """Return whether the box of the splats' centres is within the planes that bound the camera's picture."""
        low, high = self.splats.means.min(axis=0), self.splats.means.max(axis=0)
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        x, y, z = (camera.world_to_camera[:3, :3] @ corners.T + camera.world_to_camera[:3, 3:]).astype(float)
        planes = (
            z,
            camera.fx * x + camera.cx * z,
            (camera.width - camera.cx) * z - camera.fx * x,
            camera.fy * y + camera.cy * z,
            (camera.height - camera.cy) * z - camera.fy * y,
        )
        return all((plane > 0).any() for plane in planes)


def cut_places(means: Floats, places: npt.NDArray[np.intp], cells: int) -> list[npt.NDArray[np.intp]]:
    """Cut splats into so many cells (a power of two), each time in two halves along the longest side."""
    if cells == 1:
        return [places]
    order = np.argsort(means[:, int(np.argmax(np.ptp(means, axis=0)))])
    half = len(order) // 2
    halves = (order[:half], order[half:])
    return [part for index in halves for part in cut_places(means[index], places[index], cells // 2)]


def cut(splats: Splats, cells: int) -> list[Splats]:
    """Cut splats into cells."""
    return [splats.take(index) for index in cut_places(splats.means, np.arange(len(splats)), cells)]


def picture(still: list[Cell], moving: DynamicSplats[Floats], camera: Camera, background: tuple[float, ...]) -> Floats:
    """Draw cells and the splats that move, at the beginning of the scene; [3, H, W]."""
    with torch.no_grad():
        shown: Floats = rasterize(
            joined([cell.splats for cell in still]).map(torch.from_numpy),
            moving.map(torch.from_numpy),
            camera,
            0.0,
            background=background,
            antialiased=True,
            gradients="none",
        ).rgb.numpy()
    return np.clip(shown, 0, 1)


def first(order: list[Cell], budget: float) -> list[Cell]:
    """Return the cells of an order that so many bytes have room for."""
    ends = np.cumsum([cell.size for cell in order])
    return order[: max(1, int((ends <= budget + 1e-6).sum()))]


def dearer(manifest: Manifest, chunks: list[Splats], count: int) -> float:
    """Return by which factor chunks of static splats are larger in so many cells, each encoded as a chunk."""
    settings = dataclasses.replace(EncodeSettings(), prune=0.0)
    prepared = prepare_static(joined(chunks), manifest.cameras, None, settings, antialiased=manifest.antialiased)
    assert len(prepared) == sum(map(len, chunks))
    whole = parts = begin = 0
    for splats in chunks:
        places = np.arange(begin, begin + len(splats))
        begin += len(splats)
        whole += len(encode_static_chunk(prepared.take(places), settings, 0)[0])
        for cell in cut_places(splats.means, places, count):
            parts += len(encode_static_chunk(prepared.take(cell), settings, 0)[0])
    return parts / whole


def main() -> None:
    """Print a row for each view, and the means."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, help="a run or a scene folder")
    parser.add_argument("--cameras", type=int, default=4, help="of the capture, evenly chosen")
    parser.add_argument("--cells", type=int, default=8, help="of each static chunk, a power of two")
    parser.add_argument("--mbit", type=float, default=2.0, help="of the line, per second")
    options = parser.parse_args()
    folder = options.run / "scene" if (options.run / "scene").is_dir() else options.run
    manifest = load_manifest(folder)

    def read(name: str) -> bytes:
        return (folder / CHUNKS / name).read_bytes()

    more = dearer(manifest, [decode_chunk(read(entry.id)).static() for entry in manifest.static], options.cells)
    whole_cells: list[Cell] = []
    cells: list[Cell] = []
    for entry, layer in zip(manifest.static, layers([one.bytes for one in manifest.static], STATIC_PART), strict=True):
        splats = decode_chunk(read(entry.id)).static()
        whole_cells.append(Cell(splats, layer, entry.bytes))
        cells += [
            Cell(part, layer, more * entry.bytes * len(part) / entry.splats) for part in cut(splats, options.cells)
        ]
    slice_ = manifest.slices[0]
    moving = joined([decode_chunk(read(entry.id)).dynamic() for entry in slice_.chunks])
    slice_layers = layers([entry.bytes for entry in slice_.chunks], SLICE_PART)
    slice_base = sum(one.bytes for one, layer in zip(slice_.chunks, slice_layers, strict=True) if layer == 0)
    whole_bytes = sum(cell.size for cell in whole_cells)
    room = sum(cell.size for cell in whole_cells if cell.layer == 0)
    print(
        f"static {whole_bytes / 1e3:.0f} kB; {len(cells)} cells take {more:.3f} times that; base {room / 1e3:.0f} kB; "
        f"base of the first slice {slice_base / 1e3:.0f} kB"
    )
    columns = "  ".join(f"{100 * share:.0f} %: use  view" for share in SHARES)
    print(f"view              in sight  first picture: use, view kB   s      PSNR at {columns}")
    step = max(1, len(manifest.cameras) // options.cameras)
    rows = []
    for camera in manifest.cameras[::step][: options.cameras]:
        wide = camera.within(LONGEST_SIDE)
        narrow = dataclasses.replace(wide, fx=2 * wide.fx, fy=2 * wide.fy)
        for name, view in ((camera.name, wide), (f"{camera.name}, half", narrow)):
            seen = [cell.seen_by(view) for cell in cells]
            by_view = [cell for cell, visible in zip(cells, seen, strict=True) if visible]
            in_sight = sum(cell.size for cell in by_view)
            base = sum(cell.size for cell in by_view if cell.layer == 0)
            by_view += [cell for cell, visible in zip(cells, seen, strict=True) if not visible]
            whole = picture(cells, moving, view, manifest.background)
            levels = []
            for share in SHARES:
                for order in (whole_cells, by_view):
                    part = picture(first(order, share * whole_bytes), moving, view, manifest.background)
                    levels.append(min(99.0, -10 * math.log10(max(1e-10, float(((part - whole) ** 2).mean())))))
            now, then = (room + slice_base) / 1e3, (base + slice_base) / 1e3
            rows.append([in_sight / sum(cell.size for cell in cells), now, then, *levels])
            _print(name, rows[-1], options.mbit)
    _print("mean", list(np.mean(rows, axis=0)), options.mbit)


def _print(name: str, row: list[float], mbit: float) -> None:
    share, now, then, *levels = row
    seconds = [8 * size / 1e3 / mbit for size in (now, then)]
    pairs = "  ".join(f"{use:9.1f} {view:5.1f}" for use, view in zip(levels[::2], levels[1::2], strict=True))
    print(
        f"{name:18s}{100 * share:6.0f} %  {now:15.0f} {then:9.0f}    {seconds[0]:.2f}, {seconds[1]:.2f}  {pairs}",
        flush=True,
    )


if __name__ == "__main__":
    main()
