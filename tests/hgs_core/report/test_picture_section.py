from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from hgs_core.base.progress import silent
from hgs_core.report.error_colours import colour_table
from hgs_core.report.picture_section import picture_section
from hgs_core.report.pictures import CameraPictures, draw_pictures
from hgs_core.report.sources import FinishedRun, read_run


@pytest.fixture(scope="module")
def finished(run: Path) -> FinishedRun:
    return read_run(run, silent)


@pytest.fixture(scope="module")
def cameras(finished: FinishedRun) -> list[CameraPictures]:
    return draw_pictures(finished, finished.spec.open_capture(), silent)


def test_each_moment_is_a_wipe_an_error_map_and_a_map_of_what_moves(
    finished: FinishedRun, cameras: list[CameraPictures]
) -> None:
    html = picture_section(finished, cameras, "")
    moments = [moment for camera in cameras for moment in camera.moments]
    assert moments
    for moment in moments:
        for uri in (moment.truth, moment.drawn, moment.error, moment.moving):
            assert html.count(f'src="{uri}"') >= 1
        assert f"Frame {moment.frame}, {moment.seconds:.2f} s: {moment.psnr:.2f} dB" in html
        assert f"Dynamic splats draw {moment.dynamic_share:.1%} of the pixels" in html
    assert html.count('type="range"') == len(moments)
    assert html.count("worst frame</span>") == len(cameras)


def test_a_camera_that_was_held_out_is_called_so_and_the_first_is_open(
    finished: FinishedRun, cameras: list[CameraPictures]
) -> None:
    seen = replace(cameras[0], camera="0")
    html = picture_section(finished, [*cameras, seen], "")
    assert re.findall(r"<details( open)?><summary>([^<]*)<", html) == [
        (" open", "Camera 2 (held out)"),
        ("", "Camera 0 (training saw it)"),
    ]


def test_without_held_out_cameras_they_are_called_training_cameras(
    finished: FinishedRun, cameras: list[CameraPictures]
) -> None:
    config = replace(finished.spec.config, capture=replace(finished.spec.config.capture, hold_out=()))
    run = replace(finished, spec=replace(finished.spec, config=config), scores={})
    html = picture_section(run, cameras, "")
    assert "these are training cameras" in html
    assert html.count("(training saw it)") == len(cameras)


def test_other_pictures_than_the_captures_are_told(finished: FinishedRun, cameras: list[CameraPictures]) -> None:
    run = replace(finished, scores={**finished.scores, "truth": "given", "cameras": ["2", "3"]})
    html = picture_section(run, cameras, "")
    assert "The scores are against pictures that were given to hgs eval" in html
    assert "1 of 2 scored cameras are shown." in html


def test_the_key_of_errors_has_the_colours_of_the_maps(finished: FinishedRun, cameras: list[CameraPictures]) -> None:
    stops = re.search(r"linear-gradient\(to right, ([^)]*)\)", picture_section(finished, cameras, ""))
    assert stops
    found = stops[1].split(", ")
    table = colour_table()
    assert [found[0], found[8], found[-1]] == [f"#{bytes(table[k].tolist()).hex()}" for k in (0, 128, 255)]


def test_without_pictures_it_says_why(finished: FinishedRun) -> None:
    html = picture_section(finished, [], "studio: the folder does not exist")
    assert "No pictures: studio: the folder does not exist." in html
    assert "<img" not in html
