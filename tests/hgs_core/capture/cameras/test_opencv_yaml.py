"""The YAML that OpenCV's FileStorage writes, as it came out of cv2.FileStorage of OpenCV 4 and 5."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.opencv_yaml import OpenCvYaml, is_opencv_yaml

WRITTEN = """%YAML:1.0
---
names:
   - "00"
   - "cam 1"
K_00: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 3.6864000000000001e+02, 0., 256., 0.,
       3.6864000000000001e+02, 192., 0., 0., 1. ]
H_00: 384
list: [ 1., -2.5e-03, .5 ]
words: [ "a", b ]
text: hello
broken: !!opencv-matrix
   rows: 2
   cols: 2
   dt: d
   data: [ 1., 2., 3. ]
infinite: [ .Inf ]
"""


@pytest.fixture
def yaml(tmp_path: Path) -> OpenCvYaml:
    (tmp_path / "a.yml").write_text(WRITTEN)
    return OpenCvYaml(tmp_path / "a.yml")


def test_matrices_lists_numbers_and_words(yaml: OpenCvYaml) -> None:
    np.testing.assert_allclose(yaml.numbers("K_00"), [[368.64, 0, 256], [0, 368.64, 192], [0, 0, 1]])
    np.testing.assert_allclose(yaml.numbers("list"), [1, -0.0025, 0.5])
    assert yaml.numbers("H_00").tolist() == [384]
    assert yaml.words("names") == ["00", "cam 1"]
    assert yaml.words("words") == ["a", "b"]
    assert yaml.words("nothing") == []
    assert "K_00" in yaml
    assert yaml.names[:3] == ["names", "K_00", "H_00"]


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("gone", "is missing"),
        ("text", "is not made of numbers"),
        ("broken", "has 3 numbers for 2 rows of 2"),
        ("infinite", "is "),
    ],
)
def test_what_is_no_number_is_named(yaml: OpenCvYaml, name: str, problem: str) -> None:
    with pytest.raises(InputError, match=rf"a\.yml, {name}: {problem}"):
        yaml.numbers(name)


def test_a_file_is_known_by_its_beginning(tmp_path: Path) -> None:
    (tmp_path / "a.yml").write_text(WRITTEN)
    (tmp_path / "docker-compose.yml").write_text("services:\n  web: {}\n")
    assert is_opencv_yaml(tmp_path / "a.yml")
    assert not is_opencv_yaml(tmp_path / "docker-compose.yml")
    assert not is_opencv_yaml(tmp_path / "gone.yml")


def test_binary_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.yml").write_bytes(b"%YAML\xff\xfe")
    with pytest.raises(InputError, match=r"a\.yml: is not UTF-8"):
        OpenCvYaml(tmp_path / "a.yml")
