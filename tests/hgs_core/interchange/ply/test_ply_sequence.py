from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.file_format import NOTHING_KNOWN
from hgs_core.interchange.ply.gaussian_ply import gaussian_ply
from hgs_core.interchange.ply.ply_file import PLY
from hgs_core.interchange.ply.ply_sequence import frame_files, is_sequence, read_sequence
from hgs_core.interchange.ply.spacetime_ply import spacetime_ply
from hgs_core.scene import StaticSplats
from hgs_core.scene.temporal import evaluate
from tests.hgs_core.interchange.scenes import counted, dynamics, gaussian_ply_of, plain, statics


def read(path: Path) -> StaticSplats[np.ndarray]:
    assert PLY.read is not None
    return PLY.read(path, NOTHING_KNOWN).static


def test_a_folder_or_a_name_without_suffix_stands_for_frames(tmp_path: Path) -> None:
    (tmp_path / "take.1").mkdir()
    names = ("take.1", "frames", "x.ply")
    assert [is_sequence(tmp_path / name) for name in names] == [True, True, False]


def frames(folder: Path, *parts: StaticSplats[np.ndarray], names: str = "a{:03d}.PLY") -> Path:
    folder.mkdir()
    for number, splats in enumerate(parts, 1):
        (folder / names.format(number)).write_bytes(gaussian_ply(splats).data)
    return folder


def test_what_all_frames_have_is_static_and_the_rest_stands_for_its_frame(tmp_path: Path) -> None:
    """In any order, and only where each frame has it once."""
    room, first, second = statics(20, 1), statics(3, 2), statics(4, 3)
    arrays = {name: [getattr(part, name) for part in (room, first, second)] for name, _ in room.items()}
    one = StaticSplats(**{name: np.concatenate([r, f]) for name, (r, f, _) in arrays.items()})
    other = StaticSplats(**{name: np.concatenate([s, r[::-1], r[:1]]) for name, (r, _, s) in arrays.items()})
    found = read_sequence(frames(tmp_path / "x", one, other))
    assert found.lasts
    np.testing.assert_array_equal(found.static.means, room.means[1:])
    assert [len(part) for part in found.dynamic] == [3 + 1, 4 + 2]
    later = found.dynamic[1]
    np.testing.assert_array_equal(later.motion[:4, 0], second.means)
    assert not later.motion[:, 1:].any()
    assert not later.rotation[:, 1].any()
    for moment in (0.0, 1.0):
        np.testing.assert_allclose(evaluate(later, moment)[2][:4], 1 / (1 + np.exp(-second.opacity_logits)), atol=1e-4)


def test_frames_go_by_their_numbers_in_whatever_steps(tmp_path: Path) -> None:
    for number in (100, 5, 10, 15, *range(20, 100, 5)):
        (tmp_path / f"take2_{number}.ply").write_bytes(b"")
    (tmp_path / "notes.txt").write_bytes(b"")
    assert [file.name for file in frame_files(tmp_path)] == [f"take2_{n}.ply" for n in range(5, 101, 5)]


@pytest.mark.parametrize(
    ("names", "problem"),
    [
        ([], "holds no frames; give a folder with one set of files like frame_0000.ply"),
        (["a1.ply"], "holds no frames"),
        (["x.ply", "y.ply"], "holds no frames"),
        (["a1.ply", "b2.ply"], "has numbered .ply files that begin with a and b"),
        (["a1.ply", "a2.ply", "a4.ply"], "has frames 2 and 4, and others 1 apart; export the missing ones"),
    ],
)
def test_a_folder_that_is_no_sequence_is_named(tmp_path: Path, names: list[str], problem: str) -> None:
    for name in names:
        (tmp_path / name).write_bytes(b"")
    with pytest.raises(InputError) as caught:
        frame_files(tmp_path)
    assert str(caught.value).startswith(f"{tmp_path}: {problem}")


def test_a_file_of_all_times_is_no_frame(tmp_path: Path) -> None:
    for number in range(2):
        (tmp_path / f"{number}.ply").write_bytes(spacetime_ply(plain(), dynamics()).data)
    with pytest.raises(InputError, match=r"0\.ply: holds all times of an STGS scene, and no frame; import it alone"):
        read_sequence(tmp_path)


def test_what_reading_left_out_is_told_of_the_frame_with_the_most(tmp_path: Path) -> None:
    for number, count in enumerate((3, 8, 5)):
        rest = np.zeros((20, 1), np.float32)
        rest[:count] = 1
        more = {f"f_rest_{i}": rest[:, 0] for i in range(9)}
        (tmp_path / f"{number}.ply").write_bytes(gaussian_ply_of(plain(), **more))
    assert counted(read_sequence(tmp_path).changes)["left out", "view-dependent colour"] == 8
