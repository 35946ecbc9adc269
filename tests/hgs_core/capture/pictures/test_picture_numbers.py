"""Pictures of equal numbers are of one moment, even with gaps between them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.open import open_capture
from hgs_core.capture.pictures.picture_numbers import PictureNumbers, picture_numbers
from tests.hgs_core.capture.layouts import HEIGHT, NAMES, WIDTH, easymocap

CAMERAS = ("a", "b")


def numbered(*cameras: list[str], in_order: bool = False) -> PictureNumbers:
    files = [
        [Path(f"images/{camera}/{name}") for name in names] for camera, names in zip(CAMERAS, cameras, strict=True)
    ]
    return picture_numbers("images", CAMERAS, files, in_order=in_order)


def names(numbers: list[int] | range, pattern: str = "{:04d}.png") -> list[str]:
    return [pattern.format(number) for number in numbers]


def test_a_step_that_all_share_is_one_frame() -> None:
    found = numbered(names(range(0, 50, 5)), names([0, 5, 10, 20]))
    assert found.step == 5
    np.testing.assert_allclose(found.seconds(10)[1], [0, 0.1, 0.2, 0.4])
    assert found.notes() == ["b has no picture 15"]


def test_what_no_camera_has_is_time_that_goes_on() -> None:
    found = numbered(names([1, 2, 5, 6, 9]), names([1, 2, 5, 6, 7, 8, 9]))
    assert found.notes() == ["no camera has picture 3, 4", "a has no picture 7, 8"]
    np.testing.assert_allclose(found.seconds(1)[0], [0, 1, 4, 5, 8])


def test_numbers_that_cameras_do_not_share_are_refused_with_the_way_out() -> None:
    found = numbered(names(range(24)), names(range(101, 125)))
    with pytest.raises(
        InputError, match=r'none is there for all cameras: a 0 to 23, b 101 to 124; .*"frames": {"b": 0}'
    ):
        found.require_shared("images")
    with pytest.raises(InputError, match=r"only number 7 is there for all cameras"):
        numbered(names([6, 7]), names([7, 8])).require_shared("images")


def test_equally_many_that_count_from_different_numbers_are_refused_with_both_ways_out(tmp_path: Path) -> None:
    easymocap(tmp_path)
    for place, name in enumerate(NAMES):
        write_pictures(tmp_path, name, {n + (place == 2) for n in range(6)}, "{:04d}", "cameras")
    with pytest.raises(
        InputError, match=r"all cameras have 6 pictures in a row, .*cam02 0 to 5, cam03 1 to 6"
    ) as refusal:
        open_capture(tmp_path)
    together, numbered = re.findall(r'{"frames": {[^}]*}}', refusal.value.cure)
    (tmp_path / "sync.json").write_text(together)
    assert [int(open_capture(tmp_path).frame(i, 0)[0, 0, 0]) for i in range(4)] == [0, 0, 1, 0]
    (tmp_path / "sync.json").write_text(numbered)
    assert [int(open_capture(tmp_path).frame(i, 0)[0, 0, 0]) for i in range(4)] == [1, 1, 1, 1]


def test_a_counter_that_begins_anew_is_refused_with_the_numbers_that_go_on() -> None:
    counted = [*range(1, 9), *range(9990, 10000)]
    with pytest.raises(InputError, match=r"anew after DSC_9999.png, .* DSC_0001.png to DSC_0008.png come f") as refusal:
        numbered(names(counted, "DSC_{:04d}.png"), names(counted, "DSC_{:04d}.png"))
    assert refusal.value.cure == "add 9999 to their numbers"
    renamed = names([*range(9990, 10000), *range(10000, 10008)], "DSC_{:04d}.png")
    assert numbered(renamed, renamed).notes() == []


def test_times_of_a_day_that_go_over_midnight_are_refused_until_they_have_dates() -> None:
    times = ["00-00-00-016.png", "00-00-00-050.png", "23-59-59-950.png", "23-59-59-983.png"]
    with pytest.raises(
        InputError, match=r"go over midnight, .* 00-00-00-016.png to 00-00-00-050.png come f"
    ) as refusal:
        numbered(times, times)
    assert "2026-01-02_00-00-00-016.png and 2026-01-01_23-59-59-983.png" in refusal.value.cure
    dated = [*(f"2026-01-01_{time}" for time in times[2:]), *(f"2026-01-02_{time}" for time in times[:2])]
    np.testing.assert_allclose(numbered(dated, dated).seconds(30)[0], [0, 0.033, 0.066, 0.1])


def test_a_counter_behind_the_second_is_no_time_stamp() -> None:
    burst = [f"IMG_20261103_1459{second}_{n:03d}.png" for second in (20, 21) for n in range(6)]
    with pytest.raises(InputError, match=r"every 1 ms; where the last number counts the pictures of a second, call"):
        numbered(burst, burst)


def test_two_pictures_of_one_number_are_refused() -> None:
    for twice in (["0001.jpg", "0001.png", "0002.png"], ["1.png", "01.png"], ["1.png", "01.png", "2.png"]):
        with pytest.raises(InputError, match=r"are both picture 1 of camera a; take one of them away"):
            numbered(twice, names(range(3)))


def test_names_without_numbers_are_to_be_alike() -> None:
    assert numbered(["x.png", "y.png"], ["x.png", "y.png"]).numbers == ((0, 1), (0, 1))
    assert not numbered(["a_x.png", "a_y.png"], ["b_x.png", "b_y.png"]).told
    with pytest.raises(
        InputError, match=r"camera a has no picture called z, as b has, .*; call each picture by the num"
    ):
        numbered(["x.png", "y.png"], ["x.png", "z.png"])
    with pytest.raises(InputError, match=r"camera a has two pictures called x"):
        numbered(["x.jpg", "x.png"], ["x.jpg", "x.png"])
    assert numbered(["x.png", "y.png"], ["x.png", "z.png"], in_order=True).numbers == ((0, 1), (0, 1))


def test_time_stamps_are_seconds() -> None:
    found = numbered(names(range(1764000000000, 1764000001000, 40)), names(range(1764000000020, 1764000001000, 40)))
    np.testing.assert_allclose(found.seconds(30)[1][:3], [0.02, 0.06, 0.1])
    assert found.rate(30) == pytest.approx(25)
    assert "milliseconds: 25 pictures a second" in found.notes()[0]


@pytest.mark.parametrize(("unit", "scale"), [("milli", 1e3), ("micro", 1e6), ("nano", 1e9)])
def test_uneven_steps_are_time_stamps(unit: str, scale: float) -> None:
    stamps = [round(frame / 30 * scale + frame % 2) for frame in range(20) if frame not in (7, 8)]
    found = numbered(names(stamps), names(stamps))
    np.testing.assert_allclose(found.seconds(25)[0], np.array(stamps) / scale, atol=1e-9)
    assert found.rate(25) == pytest.approx(30, rel=0.01)
    assert f"{unit}seconds" in found.notes()[0]


def test_numbers_too_far_apart_for_frames_are_refused() -> None:
    with pytest.raises(InputError, match="too far for frames"):
        numbered(["0.png", "1.png", f"1{'0' * 200}.png"], names([0, 1]))


def test_a_file_of_times_that_contradicts_the_numbers_is_named() -> None:
    found = numbered(names([0, 1, 2, 5, 6]), names(range(7)))
    assert found.contradictions("t.json", [[0, 0.1, 0.2, 0.5, 0.6], [n / 10 for n in range(7)]]) == []
    said = found.contradictions("t.json", [[0, 0.1, 0.2, 0.3, 0.4], [n / 10 for n in range(7)]])
    assert said == ["after picture 2 of a comes 5, as if 1 later: t.json counts, not the numbers"]


def write_pictures(root: Path, camera: str, numbers: set[int], pattern: str, folder: str) -> None:
    """Write pictures with their number as grey, in a folder for each camera or each moment."""
    for number in numbers:
        called = pattern.format(number)
        path = root / (f"images/{camera}/{called}.png" if folder == "cameras" else f"images/{called}/{camera}.png")
        path.parent.mkdir(parents=True, exist_ok=True)
        Image.new("RGB", (WIDTH, HEIGHT), (number,) * 3).save(path)


def any_in_a_row(numbers: list[set[int]]) -> bool:
    every = sorted(set.union(*numbers))
    unit = int(np.gcd.reduce(np.array(every) - every[0])) or 1
    return all(max(own) - min(own) == unit * (len(own) - 1) for own in numbers)


SUBSETS = st.lists(st.sets(st.integers(0, 11), min_size=1), min_size=len(NAMES), max_size=len(NAMES))


@settings(max_examples=30, deadline=None)
@given(
    there=SUBSETS,
    step=st.sampled_from([1, 2, 5, 10]),
    begins=st.sampled_from([0, 1, 7, 99]),
    patterns=st.lists(st.sampled_from(["{}", "{:04d}", "frame_{:06d}", "f{}_rgb2"]), min_size=4, max_size=4),
)
def test_every_moment_shows_pictures_of_one_number(
    tmp_path_factory: pytest.TempPathFactory, there: list[set[int]], step: int, begins: int, patterns: list[str]
) -> None:
    root = tmp_path_factory.mktemp("numbers")
    easymocap(root)
    numbers = [{begins + step * number for number in own} for own in there]
    for name, own, pattern in zip(NAMES, numbers, patterns, strict=True):
        write_pictures(root, name, own, pattern, "cameras")
    shared = sorted(set.intersection(*numbers))
    shifted = len(set(map(len, numbers))) == 1 and len(set(map(min, numbers))) > 1
    if (len(shared) < 2 or (shifted and any_in_a_row(numbers))) and max(map(len, numbers)) > 1:
        with pytest.raises(InputError, match=r"(by the numbers of|pictures in a row, by numbers|no number that says)"):
            open_capture(root)
        return
    capture = open_capture(root)
    if max(map(len, numbers)) == 1:
        assert len(capture.times) == 1
        return
    shown = [[int(capture.frame(i, t)[0, 0, 0]) for t in range(len(capture.times))] for i in range(len(NAMES))]
    assert shown == [shared] * len(NAMES)
    every = np.array(sorted(set.union(*numbers)))
    unit = np.gcd.reduce(every - every[0])
    np.testing.assert_allclose(capture.times, (np.array(shared) - shared[0]) / unit / 30, atol=1e-9)


def test_a_moment_that_lacks_a_picture_of_one_camera(tmp_path: Path) -> None:
    easymocap(tmp_path)
    for name in NAMES:
        write_pictures(tmp_path, name, set(range(8)) - ({3, 4} if name == NAMES[1] else set()), "t{:03d}", "moments")
    capture = open_capture(tmp_path)
    assert [int(capture.frame(1, tick)[0, 0, 0]) for tick in range(len(capture.times))] == [0, 1, 2, 5, 6, 7]
    assert [int(capture.frame(0, tick)[0, 0, 0]) for tick in range(len(capture.times))] == [0, 1, 2, 5, 6, 7]
    assert f"{NAMES[1]} has no picture 3, 4" in capture.notes


def test_the_way_out_that_a_refusal_names_works(tmp_path: Path) -> None:
    easymocap(tmp_path)
    for place, name in enumerate(NAMES):
        write_pictures(tmp_path, name, {100 * place % 250 + n for n in (0, 1, 4, 5)}, "{:04d}", "cameras")
    with pytest.raises(InputError, match="none is there for all cameras") as refusal:
        open_capture(tmp_path)
    written = refusal.value.cure.split("write ")[1].split(" to sync.json")[0]
    (tmp_path / "sync.json").write_text(written)
    capture = open_capture(tmp_path)
    shown = [[int(capture.frame(i, t)[0, 0, 0]) - 100 * i % 250 for t in range(4)] for i in range(len(NAMES))]
    assert shown == [[0, 1, 4, 5]] * len(NAMES)
    np.testing.assert_allclose(capture.times, np.array([0, 1, 4, 5]) / 30)
