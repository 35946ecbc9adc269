"""Antialiasing keeps thin lines from shimmering while the camera moves by a tenth of a pixel a frame."""

from __future__ import annotations

from hgs_core.scene.camera import Camera, looking_at
from tests.shimmer import drawn, grid, shimmer, truth

SIZE = 96


def test_thin_lines_shimmer_half_as_much_as_without_compensation() -> None:
    scene = grid()
    pixel = 2.5 / SIZE  # world units that the camera moves while the grid moves by a pixel
    cameras = []
    for frame in range(11):
        x, y = 0.1 * pixel * frame, 0.05 * pixel * frame
        pose = looking_at((x, y, -2.5), (x, y, 0))
        cameras.append(Camera("moved", SIZE, SIZE, SIZE, SIZE, SIZE / 2, SIZE / 2, pose))
    truths = [truth(scene, camera) for camera in cameras]
    with_it, without = (
        shimmer([drawn(scene, camera, antialiased=antialiased) for camera in cameras], truths)
        for antialiased in (True, False)
    )
    print(f"shimmer: {with_it:.4f} with compensation, {without:.4f} without")
    assert with_it <= without / 2
