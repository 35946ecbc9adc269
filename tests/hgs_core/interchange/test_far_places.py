"""Map coordinates and other places far from the origin."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from hgs_core.interchange import import_scene
from hgs_core.interchange.far_places import middle_if_far
from hgs_core.interchange.ply.ply_table import write_ply
from hgs_core.render.rasterize import rasterize
from hgs_core.scene.camera import Camera, looking_at
from tests.hgs_core.interchange.scenes import Write, statics
from tests.hgs_core.interchange.test_splat_properties import COUNT, columns


@pytest.mark.parametrize("offset", [0.0, 1e3, 1e6, 1e7])
def test_far_away_places_look_as_they_do_near_the_origin(written: Write, offset: float) -> None:
    """Map coordinates in 64 bits: from the same place beside them the picture is the same."""
    names = list(columns())
    rows = np.stack([*columns().values()], axis=1)
    rows[:, :2] += [offset, 12 * offset]
    header = "ply\nformat binary_little_endian 1.0\nelement vertex 300\n"
    header += "".join(f"property double {name}\n" for name in names) + "end_header\n"
    found = import_scene(written("x.ply", header.encode() + rows.tobytes()))
    places = [change for change in found.changes if change.what == "places"]
    assert len(places) == (offset >= 1e3)
    middle = np.zeros(3)
    if places:
        middle = np.array([float(part) for part in str(places[0]).partition("(")[2].partition(")")[0].split(",")])
    near = [offset, 12 * offset, 0] - middle
    pictures = []
    for splats, eye in ((found.scene.static, near), (statics(COUNT), np.zeros(3))):
        camera = Camera("", 64, 64, 60, 60, 32, 32, looking_at(eye + np.array([0, 0, -8.0]), eye))
        drawn = rasterize(splats.map(torch.from_numpy), None, camera, gradients="none")
        pictures.append(drawn.rgb.numpy())
    assert -10 * np.log10(((pictures[0] - pictures[1]) ** 2).mean() + 1e-12) > 50


def test_places_that_a_file_rounds_to_more_than_half_a_splat_are_told(written: Write) -> None:
    """Map coordinates in 32 bits, or in too few digits: no reader can bring them back."""
    near, far = columns(), columns() | {"y": columns()["y"] + 5.4e6}
    text = "\n".join(" ".join(f"{number:.6g}" for number in row) for row in zip(*far.values(), strict=True))
    header = "".join(f"property double {name}\n" for name in far)
    ascii_ply = f"ply\nformat ascii 1.0\nelement vertex {COUNT}\n{header}end_header\n{text}\n".encode()
    steps = {
        name: [change.reason.partition(";")[0] for change in import_scene(path).changes if change.what == "places"][1:]
        for name, path in {
            "near": written("x.ply", write_ply(near)),
            "floats": written("y.ply", write_ply(far)),
            "digits": written("z.ply", ascii_ply),
        }.items()
    }
    assert steps == {
        "near": [],
        "floats": ["the file holds them in steps of 0.5"],
        "digits": ["the file holds them in steps of 10"],
    }


def test_a_capture_keeps_places_where_they_are(written: Write) -> None:
    table = columns() | {"x": columns()["x"] + 1e6}
    found = import_scene(written("x.ply", write_ply(table)), centred=False)
    assert np.median(found.scene.static.means[:, 0]) == pytest.approx(1e6, rel=1e-3)


def test_places_near_the_origin_or_none_at_all_have_no_middle() -> None:
    near = statics().means.astype(np.float64)
    assert middle_if_far(near) is None
    assert middle_if_far(np.full((3, 3), np.nan)) is None
    assert middle_if_far(np.zeros((0, 3))) is None
    assert middle_if_far(np.array([[5.0, 0, 0]])) is None
    np.testing.assert_allclose(middle_if_far(np.array([[5e6, 0, 0]])), [5e6, 0, 0])
