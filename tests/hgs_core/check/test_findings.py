from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.check.findings import CameraResult, CaptureCheck, Finding, ShownMatch, ShownPair

UPSIDE_DOWN = Finding(True, ("cam00",), "it is upside down", "turn it")
NO_MASK = Finding(False, (), "the masks mark nothing", "mark it")
MATCH = ShownMatch((1.0, 2.0), (3.0, 4.0), (0.6, 0.8, -5.0))
CHECK = CaptureCheck(
    (CameraResult("cam00", 2, 140, 0.12, 0.0), CameraResult("cam01", 0, 0, None, None)),
    (UPSIDE_DOWN, NO_MASK),
    (ShownPair(("cam00", "cam01"), 3, ((64, 48), (64, 48)), 5.5, (MATCH,)),),
    (0, 3),
    64,
)


def test_what_is_saved_is_read_again(tmp_path: Path) -> None:
    CHECK.save(tmp_path / "check.json")
    assert CaptureCheck.load(tmp_path / "check.json") == CHECK


def test_a_damaged_file_is_named(tmp_path: Path) -> None:
    (tmp_path / "check.json").write_text('{"cameras": 3}')
    with pytest.raises(InputError, match=r"check\.json.*checked again"):
        CaptureCheck.load(tmp_path / "check.json")


def test_the_table_has_a_line_per_camera_and_one_per_finding() -> None:
    assert CHECK.table().splitlines() == [
        "camera  partners  matches    px  ahead",
        "cam00          2      140  0.12   +0.0  stop",
        "cam01          0        0     -      -",
        "stop: cam00: it is upside down; turn it",
        "look: the masks mark nothing; mark it",
    ]


def test_only_some_findings_stop() -> None:
    assert [finding.problem for finding in CHECK.stops] == ["it is upside down"]
