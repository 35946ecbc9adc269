"""Which of the two kinds of point clouds a .ply file is."""

from __future__ import annotations

import numpy as np

from hgs_core.interchange.file_format import NOTHING_KNOWN
from hgs_core.interchange.ply.ply_file import PLY
from hgs_core.scene import DynamicSplats, HybridScene
from tests.hgs_core.interchange.scenes import CAMERA, Write, dynamics, gaussian_ply_of, plain

assert PLY.read is not None
assert PLY.write_still is not None
assert PLY.write_moving is not None


def test_a_point_cloud_with_times_lasts_and_one_without_is_still(
    scene: HybridScene[np.ndarray], written: Write
) -> None:
    moving = PLY.read(
        written("moving.ply", PLY.write_moving(scene.static, dynamics(), [CAMERA], True).data), NOTHING_KNOWN
    )
    assert (len(moving.static), [len(part) for part in moving.dynamic], moving.lasts) == (50, [30], True)
    still = PLY.read(written("still.ply", PLY.write_still(scene.static, False).data), NOTHING_KNOWN)
    assert (len(still.static), len(still.dynamic), still.lasts) == (50, 0, False)
    assert (moving.antialiased, still.antialiased) == (True, False)


def test_what_the_table_and_the_splats_of_it_lack_is_told_together(written: Write) -> None:
    data = gaussian_ply_of(plain(), label=np.zeros(20, np.float32))
    header, _, rows = data.partition(b"end_header\n")
    path = written("x.ply", header + b"element face 1\nproperty uchar x\nend_header\n" + rows + b"\0")
    told = [change.what for change in PLY.read(path, NOTHING_KNOWN).changes if change.count is None]
    assert told == ["element face", "properties label"]
    moving = PLY.write_moving(plain(), DynamicSplats.empty(), [], False).data
    header, _, rows = moving.partition(b"end_header\n")
    path = written("y.ply", header + b"element face 1\nproperty uchar x\nend_header\n" + rows + b"\0")
    assert "element face" in [change.what for change in PLY.read(path, NOTHING_KNOWN).changes]
