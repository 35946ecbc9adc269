"""What a format drops or changes is counted: one splat, or a few, of each kind."""

from __future__ import annotations

import dataclasses
import gzip
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange import Change, export_scene, import_scene
from hgs_core.interchange.gaussian_ply import gaussian_ply
from hgs_core.interchange.ply_table import write_ply
from hgs_core.interchange.spacetime_ply import spacetime_ply
from hgs_core.interchange.splat_file import splat_file
from hgs_core.interchange.spz_file import spz_file
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.camera import Camera

CAMERA = Camera("cam00", 640, 480, 500.0, 510.0, 320.0, 240.0, np.eye(4))
Write = Callable[[str, bytes], Path]
Counted = dict[tuple[str, str], int | None]


def counted(changes: Iterable[Change]) -> Counted:
    """Return the counts by action and attribute; no two changes may share both."""
    found = [((str(change.action), change.what), change.count) for change in changes]
    assert len(dict(found)) == len(found)
    return dict(found)


def plain(count: int = 20) -> StaticSplats[np.ndarray]:
    """Splats that every format holds to the bit."""
    k = np.arange(count)
    return StaticSplats(
        (np.stack([k, -k, k], axis=1) / 64).astype(np.float32),
        np.full((count, 3), -2.0, np.float32),
        np.tile(np.float32([1, 0, 0, 0]), (count, 1)),
        np.full(count, np.log(51 / 204), np.float32),  # 51 / 255
        np.full((count, 3), 0.5, np.float32),
    )


def still(**changed: dict[int, float]) -> HybridScene[np.ndarray]:
    """The plain splats with some numbers (by row, in the first column) replaced."""
    arrays = {name: array.copy() for name, array in plain().items()}
    for name, values in changed.items():
        for row, value in values.items():
            arrays[name].reshape(20, -1)[row, 0] = value
    return HybridScene(StaticSplats(**arrays), (Segment(0.0, 0.0, DynamicSplats.empty()),))


def export(scene: HybridScene[np.ndarray], path: Path, **more: object) -> Counted:
    given = {"cameras": [CAMERA]} | more
    return counted(export_scene(scene, path, **given))  # type: ignore[arg-type]


HARD = {
    "means": {0: 1e-5},
    "rgb": {1: -0.25, 2: 1.75, 3: 0.3333},
    "opacity_logits": {4: -9.0, 5: 0.77, 6: 40.0},
    "log_scales": {7: -100.0, 8: 90.0, 9: -2.01},
    "quats": {10: 0.7},
}
LOST = {
    ".ply": {("limited", "opacity"): 1, ("limited", "colour"): 1},
    ".splat": {
        ("limited", "scale"): 2, ("limited", "colour"): 2, ("rounded", "colour"): 20, ("rounded", "opacity"): 1,
        ("replaced", "opacity"): 1, ("rounded", "rotation"): 20,
    },
    ".spz": {
        ("rounded", "position"): 1, ("limited", "scale"): 2, ("rounded", "scale"): 1, ("limited", "colour"): 1,
        ("rounded", "colour"): 20, ("rounded", "opacity"): 1, ("replaced", "opacity"): 1,
    },
}  # fmt: skip


@pytest.mark.parametrize("suffix", list(LOST))
def test_what_a_still_format_cannot_hold_is_counted_by_kind(tmp_path: Path, suffix: str) -> None:
    assert export(still(**HARD), tmp_path / f"x{suffix}") == LOST[suffix]


def test_what_a_3dgs_ply_holds_is_not_counted(tmp_path: Path) -> None:
    assert export(still(), tmp_path / "x.ply") == {}


@pytest.mark.parametrize(
    ("suffix", "expected"),
    [(".ply", ["antialiasing", "background"]), (".splat", ["antialiasing", "background"]), (".spz", ["background"])],
)
def test_what_a_scene_has_as_a_whole_is_told(tmp_path: Path, suffix: str, expected: list[str]) -> None:
    scene = dataclasses.replace(still(), antialiased=True, background=(1.0, 1.0, 1.0))
    found = export(scene, tmp_path / f"x{suffix}")
    assert [what for (_, what), count in found.items() if count is None] == expected


def test_a_moment_of_a_moving_scene_tells_what_it_lacks(scene: HybridScene[np.ndarray], tmp_path: Path) -> None:
    dynamic = scene.segments[0].dynamic
    dynamic.time_centers[:10], dynamic.time_log_precisions[:10] = 0.0, 9.0  # long gone at 3 s
    dynamic.time_centers[10:], dynamic.time_log_precisions[10:] = 0.5, 0.0
    found = export(scene, tmp_path / "x.ply", time=3.0)
    assert found[("left out", "splats")] == 10
    assert found[("left out", "motion and life")] == 20


def test_an_stgs_ply_tells_of_other_segments_lives_and_splats_that_are_never_seen(
    scene: HybridScene[np.ndarray], tmp_path: Path
) -> None:
    own = scene.segments[0]
    own.dynamic.opacity_logits[:3] = -9  # below 1/255
    own.dynamic.time_log_precisions[3:5] = 50.0
    other = Segment(4.0, 6.0, own.dynamic.take(slice(0, 7)))
    longer = HybridScene(scene.static, (own, other))
    changes = export_scene(longer, tmp_path / "x.ply", cameras=[], segment=0)
    assert sorted(str(change) for change in changes) == [
        "3 of 80 splats left out: they are never seen",
        "7 of 87 splats left out: they are of other segments",
        "life of 2 of 27 splats limited: to widths of 2.1e-09 to 2.2e+04 of the time shown",
        "time replaced: 0 to 1 stands for 2 to 4 s",
    ]


def test_a_splatv_file_tells_what_halves_and_bytes_change(scene: HybridScene[np.ndarray], tmp_path: Path) -> None:
    dynamic = scene.segments[0].dynamic
    dynamic.motion[0, 1] = 1e6
    dynamic.time_log_precisions[:2] = 30.0
    scene.static.log_scales[:4] = 12.0
    found = export(scene, tmp_path / "x.splatv")
    assert found[("limited", "motion")] == 1
    assert found[("limited", "life")] == 2
    assert found[("limited", "scale")] == 4
    assert found[("rounded", "colour")] == found[("rounded", "rotation")] == 80
    assert found[("rounded", "motion")] == found[("rounded", "turning")] == 30


def test_reading_a_3dgs_ply_tells_of_each_attribute(written: Write) -> None:
    given = still(
        means={0: np.nan, 1: np.inf}, quats={2: np.nan}, opacity_logits={3: np.inf, 4: -np.inf},
        log_scales={5: -np.inf, 6: 99.0}, rgb={7: -0.5, 8: np.nan},
    ).static  # fmt: skip
    found = import_scene(written("x.ply", gaussian_ply_of(given)), 1.0)
    assert (found.splats, len(found.scene.static)) == (20, 16)
    assert [str(change) for change in found.changes] == [
        "2 of 20 splats left out: position is no finite number",
        "1 of 20 splats left out: rotation is no finite number",
        "1 of 20 splats left out: colour is no finite number",
        "opacity of 2 of 16 splats limited: to 0.000001 to 0.999999",
        "scale of 2 of 16 splats limited: to e^-30 to e^30",
        "colour of 1 of 16 splats limited: to 0 to 8",
    ]


def gaussian_ply_of(splats: StaticSplats[np.ndarray], **more: np.ndarray) -> bytes:
    """A file with the splats' own logits, infinite ones too, and further properties."""
    names = ["x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3", "opacity"]
    dc = (splats.rgb - 0.5) / 0.28209479
    table = np.concatenate([splats.means, splats.log_scales, splats.quats, splats.opacity_logits[:, None], dc], axis=1)
    return write_ply(dict(zip([*names, "f_dc_0", "f_dc_1", "f_dc_2"], table.T, strict=True)) | more)


def test_only_splats_whose_colour_depends_on_the_view_are_counted(written: Write) -> None:
    rest = {f"f_rest_{i}": np.zeros(20, np.float32) for i in range(9)}
    rest["f_rest_4"][:6] = 0.1
    label = {"label": np.zeros(20, np.float32)}
    found = counted(import_scene(written("x.ply", gaussian_ply_of(plain(), **rest, **label)), 1.0).changes)
    assert found == {("left out", "view-dependent colour"): 6, ("left out", "properties label"): None}


def test_numbers_of_64_bits_and_further_elements_are_told(written: Write) -> None:
    data = gaussian_ply(plain(2)).data
    header, _, rows = data.partition(b"end_header\n")
    wide = np.frombuffer(rows, "<f4").astype("<f8").reshape(2, -1).copy()
    wide[1, 0] = 0.1
    header = header.replace(b"float", b"double") + b"element face 1\nproperty uchar x\nend_header\n"
    found = counted(import_scene(written("x.ply", header + wide.tobytes() + b"\0"), 1.0).changes)
    assert found == {("rounded", "numbers"): 1, ("left out", "element face"): None}


def test_reading_an_stgs_ply_tells_of_features_and_motions(scene: HybridScene[np.ndarray], written: Write) -> None:
    dynamic = scene.segments[0].dynamic
    dynamic.motion[:2, 2] = np.nan
    data = spacetime_ply(scene.static, dynamic).data
    header, _, rows = data.partition(b"end_header\n")
    table = np.frombuffer(rows, "<f4").reshape(80, -1)
    names = [line.split()[2] for line in header.decode().splitlines() if line.startswith("property")]
    more = {"f_t_0": np.zeros(80, np.float32)}
    more["f_t_0"][:5] = 1
    path = written("x.ply", write_ply(dict(zip(names, table.T, strict=True)) | more))
    changes = import_scene(path, 1.0).changes
    assert counted(changes) == {("left out", "features f_t"): 5, ("left out", "splats"): 2}
    assert changes[-1].reason == "position or motion is no finite number"


def test_reading_a_splat_file_tells_of_bad_scales(written: Write) -> None:
    rows = np.frombuffer(splat_file(plain()).data, "<f4").reshape(20, 8).copy()
    rows[0, 3] = -1.0
    rows[1:4, 4] = 0.0
    found = counted(import_scene(written("x.splat", rows.tobytes()), 1.0).changes)
    assert found == {("left out", "splats"): 1, ("limited", "scale"): 3}


def test_reading_an_spz_file_tells_of_harmonics_and_negative_colours(written: Write) -> None:
    raw = bytearray(gzip.decompress(spz_file(still(rgb={0: -0.4}).static).data))
    raw[12] = 1  # the degree
    harmonics = np.full((20, 9), 128, np.uint8)
    harmonics[:7, 3] = 90
    path = written("x.spz", gzip.compress(bytes(raw) + harmonics.tobytes()))
    found = counted(import_scene(path, 1.0).changes)
    assert found == {("left out", "view-dependent colour"): 7, ("limited", "colour"): 1}


@pytest.mark.parametrize(
    ("name", "value", "problem"),
    [
        ("means", np.nan, "holds no splat that can be seen: all 20 splats left out: position is no finite number"),
        ("opacity_logits", -8.0, "holds no splat that can be seen; export it again"),
    ],
)
def test_a_file_of_which_nothing_would_be_left_is_refused(
    written: Write, name: str, value: float, problem: str
) -> None:
    splats = plain()
    nothing = dataclasses.replace(splats, **{name: np.full_like(getattr(splats, name), value)})
    with pytest.raises(InputError, match=problem):
        import_scene(written("x.ply", gaussian_ply_of(nothing)), 1.0)
