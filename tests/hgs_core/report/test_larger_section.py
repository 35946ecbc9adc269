from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from hgs_core.base.progress import silent
from hgs_core.report.larger_pictures import Crop, LargerPictures
from hgs_core.report.larger_section import larger_section
from hgs_core.report.sources import FinishedRun, read_run

PICTURES = LargerPictures(
    camera="2",
    frame=4,
    seconds=0.5,
    crop_size=(64, 48),
    crops=(Crop(1, "data:a", None), Crop(2, "data:b", 45.25), Crop(4, "data:c", 43.5)),
    size=(64, 48),
    walk=("data:d", "data:e", "data:f"),
)


@pytest.fixture(scope="module")
def finished(run: Path) -> FinishedRun:
    return read_run(run, silent)


def test_crops_and_walk_stand_beside_each_other_with_their_figures(finished: FinishedRun) -> None:
    html = larger_section(finished, [PICTURES])
    assert re.findall(r'src="([^"]*)"', html) == [f"data:{letter}" for letter in "abcdef"]
    assert re.findall(r"<figcaption>([^<]*)<", html) == [
        "Training size",
        "2x, averaged 45.2 dB from the training size",
        "4x, averaged 43.5 dB from the training size",
        "From the camera&#x27;s place",
        "From a third of the way to what moves",
        "From two thirds of the way",
    ]
    assert "Camera 2, frame 4, 0.50 s" in html


def test_measured_means_are_a_table(finished: FinishedRun) -> None:
    magnified = {"psnr": 28.0, "psnr_2x": 27.9, "agreement_2x": 45.0, "agreement_walked_1_of_3": 26.0}
    html = larger_section(replace(finished, scores={**finished.scores, "magnified": magnified}), [])
    rows = [re.findall(r"<t[hd][^>]*>([^<]*)<", row) for row in re.findall(r"<tr>(.*?)</tr>", html)][1:]
    assert rows == [
        ["training size", "28.00", ""],
        ["2x", "27.90", "45.00"],
        ["a third of the way to what moves", "", "26.00"],
        ["two thirds of the way", "", ""],
    ]


def test_without_measured_means_the_command_is_given(finished: FinishedRun) -> None:
    html = larger_section(finished, [])
    assert "hgs eval RUN --magnify 2,4" in html
    assert "<table>" not in html
