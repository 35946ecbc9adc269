from __future__ import annotations

from hgs_core.runs.training import told_of_training


def test_viewers_are_not_told_of_the_machine_nor_of_curves() -> None:
    summary = {"seconds": 3.0, "iterations": 60, "machine": {}, "history": {}, "profile": {}}
    assert told_of_training(summary) == {"seconds": 3.0, "iterations": 60}
