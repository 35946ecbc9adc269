from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.corrected_poses import CorrectedCamera, corrections_of, write_corrections
from hgs_core.capture.open import open_capture
from hgs_core.scene.camera import looking_at
from tests.hgs_core.capture import layouts

POSE = looking_at([1.0, 2.0, 3.0], [0.0, 0.0, 0.0])


def written(root: Path, cameras: str = "OpenCV") -> Path:
    layouts.PICTURES["folders"](root)
    layouts.CAMERAS[cameras](root)
    corrected = [CorrectedCamera("cam02", POSE, "cam02", 0.5), CorrectedCamera("cam10", POSE, "cam01")]
    return write_corrections(root, "they were wrong", corrected)


@pytest.mark.parametrize("cameras", layouts.CAMERAS)
def test_a_calibration_of_any_format_is_corrected_and_stays_as_it_is(tmp_path: Path, cameras: str) -> None:
    layouts.PICTURES["folders"](tmp_path)
    layouts.CAMERAS[cameras](tmp_path)
    before = {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
    plain = open_capture(tmp_path)
    write_corrections(tmp_path, "they were wrong", [CorrectedCamera("cam02", POSE, "cam02", 0.5)])
    found = open_capture(tmp_path)
    assert {file: file.read_bytes() for file in before} == before
    assert found.fingerprint() != plain.fingerprint()
    assert any("poses.json corrects" in note and "they were wrong" in note for note in found.notes)
    for camera, old in zip(found.cameras, plain.cameras, strict=True):
        changed = camera.name == "cam02"
        np.testing.assert_allclose(camera.world_to_camera, POSE if changed else old.world_to_camera, atol=1e-12)
        assert camera.fx == pytest.approx(old.fx * (0.5 if changed else 1.0))


def test_a_camera_takes_the_lens_of_another(tmp_path: Path) -> None:
    layouts.PICTURES["folders"](tmp_path)
    layouts.opencv_files(tmp_path)
    file, longer = tmp_path / "cameras" / "cam01.yml", dataclasses.replace(layouts.truth()[0], fx=44.0)
    shorter = layouts.opencv_matrix(layouts.lens_matrix(layouts.truth()[0], 0.5))
    file.write_text(file.read_text().replace(shorter, layouts.opencv_matrix(layouts.lens_matrix(longer, 0.5))))
    write_corrections(tmp_path, "swapped", [CorrectedCamera("cam10", POSE, "cam01")])
    assert [camera.fx for camera in open_capture(tmp_path).cameras] == [44.0, 40.0, 40.0, 44.0]


def test_a_second_correction_is_laid_upon_the_first() -> None:
    earlier = CorrectedCamera("cam02", POSE, "cam01", 0.5)
    later = CorrectedCamera("cam03", POSE, "cam02", 3.0).after(earlier)
    assert (later.name, later.calibration, later.focal) == ("cam03", "cam01", 1.5)
    assert CorrectedCamera("cam03", POSE, "cam02").after(None).calibration == "cam02"


def test_poses_of_a_calibration_that_has_changed_are_refused(tmp_path: Path) -> None:
    written(tmp_path)
    file = tmp_path / "cameras" / "cam01.yml"
    file.write_text(file.read_text() + "\n")
    with pytest.raises(InputError, match=r"poses.json: corrects poses of other files than cam01.yml"):
        open_capture(tmp_path)


def change(key: str, value: Any) -> Callable[[dict[str, Any]], None]:
    return lambda content: content["cameras"]["cam02"].update({key: value})


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda content: content.pop("cameras"), "has no cameras"),
        (lambda content: content.pop("of"), "does not say of which calibration"),
        (lambda content: content["cameras"].update(cam99=content["cameras"]["cam02"]), "there is no camera 'cam99'"),
        (lambda content: content["cameras"]["cam02"].pop("focal"), "camera cam02: is"),
        (change("calibration", "cam99"), "there is no camera 'cam99'"),
        (change("calibration", ["cam01"]), "there is no camera"),
        (change("focal", 0), "focal is 0"),
        (change("focal", float("nan")), "focal"),
        (change("world_to_camera", [[1.0] * 4] * 4), "has no rotation"),
        (change("world_to_camera", np.diag((-1.0, 1, 1, 1)).tolist()), "has no rotation"),
        (change("world_to_camera", "no"), "world_to_camera is"),
    ],
)
def test_a_damaged_file_is_refused(tmp_path: Path, spoil: Callable[[Any], Any], message: str) -> None:
    file = written(tmp_path)
    content = json.loads(file.read_text())
    spoil(content)
    file.write_text(json.dumps(content))
    with pytest.raises(InputError, match=message):
        open_capture(tmp_path)


def test_without_the_file_nothing_is_corrected(tmp_path: Path) -> None:
    assert corrections_of(tmp_path, layouts.NAMES) == {}
