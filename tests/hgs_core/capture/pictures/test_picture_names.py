"""The numbers that names of pictures have."""

from __future__ import annotations

import datetime
from pathlib import Path

import pytest

from hgs_core.capture.pictures.picture_names import labels_of, numbers_in

DAY = datetime.date(2025, 11, 24).toordinal() * 86_400_000
"""Its midnight, milliseconds."""


def test_what_changes_is_what_tells_pictures_apart() -> None:
    assert labels_of([Path("a/cam4/0007.png"), Path("a/cam4/0008.png")]) == ["0007", "0008"]
    assert labels_of([Path("a/t7/images/cam4.png"), Path("a/t8/images/cam4.png")]) == ["t7", "t8"]
    assert labels_of([Path("a/1/0001.png"), Path("a/2/0001.png")]) == ["1", "2"]
    assert labels_of([Path("a/1/0001.png")]) == ["0001"]


@pytest.mark.parametrize(
    ("labels", "numbers"),
    [
        ([["0007", "0009"], ["7", "10"]], ((7, 9), (7, 10))),
        ([["cam04_0007", "cam04_0009"], ["cam06_7", "cam06_8"]], ((7, 9), (7, 8))),
        ([["cam04.0007", "cam04.0009"], ["cam06.0007", "cam06.0008"]], ((7, 9), (7, 8))),
        ([["7_cam4", "8_cam4"], ["7_cam6", "8_cam6"]], ((7, 8), (7, 8))),
        ([["f7", "f8"], ["g8"]], ((7, 8), (8,))),
        ([["a1b", "a2b"], ["x3", "x4"]], ((1, 2), (3, 4))),
        ([["20251124_115959_001", "20251124_115959_002"]], ((1, 2),)),
        ([["20251124_115959_000059999", "20251124_115959_000060000"]], ((59999, 60000),)),
        ([["000059999", "000060000"]], ((59999, 60000),)),
        ([["20251124_000058", "20251124_000059", "20251124_000060"]], ((58, 59, 60),)),
    ],
)
def test_counts(labels: list[list[str]], numbers: tuple[tuple[int, ...], ...]) -> None:
    assert numbers_in(labels) == (numbers, None)


@pytest.mark.parametrize(
    ("labels", "numbers", "unit"),
    [
        (["1764000000000", "1764000000033"], (1764000000000, 1764000000033), 1e-3),
        (["7_1764000000000000", "9_1764000000033333"], (1764000000000000, 1764000000033333), 1e-6),
        (["1764000000000000000", "1764000000033333333"], (1764000000000000000, 1764000000033333333), 1e-9),
        (["11.97", "12.0", "12.033"], (11970, 12000, 12033), 1e-3),
        (["1764000000033.5", "1764000000066.83"], (176400000003350, 176400000006683), 1e-5),
        (["20251124_115959_967", "20251124_120000_000"], (DAY + 43199967, DAY + 43200000), 1e-3),
        (["2025-11-24 11.59.59.967", "2025-11-24 12.00.00.000"], (DAY + 43199967, DAY + 43200000), 1e-3),
        (["20251124_115959967", "20251124_120000000"], (DAY + 43199967, DAY + 43200000), 1e-3),
        (["20251124115959967", "20251124120000000"], (DAY + 43199967, DAY + 43200000), 1e-3),
        (["20251123T235959.967", "20251124T000000.000"], (DAY - 33, DAY), 1e-3),
        (["c4_115959934", "c4_115959967", "c4_120000000"], (43199934, 43199967, 43200000), 1e-3),
        (["c4_115958", "c4_115959", "c4_120000"], (43198, 43199, 43200), 1),
        (["115959.934", "115959.967", "120000.000"], (43199934, 43199967, 43200000), 1e-3),
        (["7_1712345678901", "8_1712345678934"], (1712345678901, 1712345678934), 1e-3),
    ],
)
def test_time_stamps(labels: list[str], numbers: tuple[int, ...], unit: float) -> None:
    read = numbers_in([labels])
    assert read is not None
    assert read[0] == (numbers,)
    assert read[1] == pytest.approx(unit)


@pytest.mark.parametrize(
    "labels", [[["a", "b"]], [["a7", "b8"]], [["1_1", "1_2", "2_1"]], [["7_x", "8_x"], ["x"]], [["7_1", "8_2", "8_2"]]]
)
def test_names_whose_numbers_tell_nothing(labels: list[list[str]]) -> None:
    assert numbers_in(labels) is None
