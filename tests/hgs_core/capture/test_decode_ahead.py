"""Decoding ahead: every frame once and in order, with progress, stopped at once."""

from __future__ import annotations

import threading

import pytest

from hgs_core.base.progress import Progress, StageStopped, silent
from hgs_core.capture.decode_ahead import decode_ahead


def test_every_frame_is_decoded_once_and_in_order() -> None:
    seen: dict[int, list[int]] = {0: [], 3: []}
    decode_ahead({0: [1, 2, 5], 3: [0, 4]}, lambda camera, frame: seen[camera].append(frame), silent)
    assert seen == {0: [1, 2, 5], 3: [0, 4]}


def test_progress_counts_pictures_to_the_end() -> None:
    reports: list[Progress] = []
    decode_ahead({0: range(4), 1: range(3)}, lambda camera, frame: None, reports.append)
    assert reports[0] == Progress("frames", 0, 7)
    assert reports[-1] == Progress("frames", 7, 7)


def test_a_fault_ends_the_others() -> None:
    decoded = []

    def decode(camera: int, frame: int) -> None:
        if camera == 1:
            raise ValueError("damaged")
        decoded.append(frame)
        ended.wait(0.01)

    ended = threading.Event()
    with pytest.raises(ValueError, match="damaged"):
        decode_ahead({0: range(10_000), 1: range(1)}, decode, silent)
    assert len(decoded) < 10_000


def test_the_callback_stops_it() -> None:
    def refuse(progress: Progress) -> None:
        if progress.done == 0:
            raise StageStopped

    with pytest.raises(StageStopped):
        decode_ahead({0: range(3)}, lambda camera, frame: None, refuse)
