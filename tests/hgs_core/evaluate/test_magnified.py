"""Scores of larger pictures and nearer eyes, of a synthetic scene."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.base.errors import InputError
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.evaluate.magnified import MagnifiedScorer, walked
from hgs_core.evaluate.run import evaluate_run
from hgs_core.evaluate.truth import Truth
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.camera import Camera, looking_at


def scorer(run: Path, *, photographed: bool = True) -> MagnifiedScorer:
    folder = RunFolder(run)
    capture = folder.read_spec().open_capture()
    manifest = dataclasses.replace(load_manifest(folder.manifest), photographed=photographed)
    scene = decode_scene(folder.scene).map(torch.from_numpy)
    source = Truth(capture, range(len(capture.cameras)), pictures=None, masks=None, downscale=1)
    return MagnifiedScorer(scene, manifest, capture, source, "cpu")


def test_larger_pictures_are_those_of_the_training_size_where_the_rig_is_known(finished: Path) -> None:
    known, unknown = (scorer(finished, photographed=rig).scores([1], [2, 4]) for rig in (True, False))
    assert set(known) >= {"psnr", "psnr_2x", "agreement_2x", "psnr_4x", "agreement_4x"}
    assert known["psnr"] == pytest.approx(unknown["psnr"], abs=1e-6)
    for factor in (2, 4):
        assert known[f"agreement_{factor}x"] > 40
        assert known[f"agreement_{factor}x"] > unknown[f"agreement_{factor}x"]


def test_nearer_eyes_see_the_same_surfaces(finished: Path) -> None:
    scores = scorer(finished).scores([1], [2])
    assert scores["agreement_walked_1_of_3"] > 25
    assert scores["agreement_walked_2_of_3"] > 20


def test_a_walk_goes_along_the_axis() -> None:
    camera = Camera("a", 64, 64, 50.0, 50.0, 32.0, 32.0, looking_at((1.0, 0.5, -3.0), (0.0, 0.0, 0.0)))
    moved = walked(camera, 0.25, 6.0)
    np.testing.assert_allclose(moved.position - camera.position, 1.5 * camera.world_to_camera[2, :3], atol=1e-12)
    assert moved.near == 0.75 * camera.near


@pytest.mark.parametrize("factor", [1, 9])
def test_a_factor_that_magnifies_nothing_or_too_much_is_refused(finished: Path, factor: int) -> None:
    with pytest.raises(InputError, match="whole number from 2 to 8"):
        scorer(finished).scores([1], [factor])


def test_the_scores_are_a_field_of_the_evaluation(finished: Path) -> None:
    assert evaluate_run(finished, cameras=["2"])["magnified"] is None
    assert evaluate_run(finished, cameras=["2"], magnify=[2])["magnified"]["agreement_2x"] > 40
