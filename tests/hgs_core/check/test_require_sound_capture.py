from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.check.findings import CaptureCheck, Finding
from hgs_core.check.require_sound_capture import require_sound


def check(*findings: Finding) -> CaptureCheck:
    return CaptureCheck((), findings, (), (0,), 64)


def test_a_capture_that_only_needs_a_look_goes_on() -> None:
    require_sound(check(Finding(False, ("a",), "few matches", "look")), Path("capture"))


def test_the_first_fault_is_told_with_its_cure_and_the_way_on() -> None:
    faults = [Finding(True, ("a", "b"), "swapped", "exchange them"), Finding(True, ("c",), "inverted", "invert it")]
    with pytest.raises(InputError) as caught:
        require_sound(check(*faults), Path("capture"))
    words = "capture, camera a, b: swapped (and 1 more, see hgs check); exchange them; or train with --trust-poses"
    assert str(caught.value) == words


def test_a_dead_camera_that_is_held_out_does_not_stop_a_training() -> None:
    dead = check(Finding(True, ("a",), "its pictures are black", "leave it out", of_pictures=True))
    require_sound(dead, Path("capture"), held_out=["a", "b"])
    with pytest.raises(InputError, match=r"black; leave it out$"):  # trusting its pose would not help
        require_sound(dead, Path("capture"), held_out=["b"])
    with pytest.raises(InputError, match="inverted"):
        require_sound(check(Finding(True, ("a",), "inverted", "invert it")), Path("capture"), held_out=["a"])
