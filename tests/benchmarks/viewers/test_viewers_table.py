"""The viewers' table: figures as ratios to the fastest of the others."""

from __future__ import annotations

from benchmarks.viewers.viewers_bench import ViewerPoint, ViewerReport
from benchmarks.viewers.viewers_table import viewer_line, viewers_text

MACHINE = {"cpu": "A processor", "cores": 4, "load": 0.5}


def _lines(*points: ViewerPoint) -> list[list[str]]:
    report = ViewerReport(MACHINE, "156.0", "biker.ply", 104_911, (640, 480), 3, 20, points)
    return [line.split() for line in viewers_text(report).splitlines()[4:]]


def test_times_stand_beside_the_fastest_of_the_others() -> None:
    ours = ViewerPoint("hgs", 300.0, 330.0, 345.0, (68.44, 68.06))
    slow, fast = ViewerPoint("slow", 900.0, 300.0, None, (30.0, 30.0)), ViewerPoint("fast", 250.0, 600.0, None, (9, 9))
    _, first, second, third = _lines(ours, slow, fast)
    assert first == ["hgs", "300", "1.20", "330", "1.10", "345", "68.4", "68.1"]
    assert second[:6] == ["slow", "900", "3.60", "300", "1.00", "-"]
    assert third[1:5] == ["250", "1.00", "600", "2.00"]


def test_alone_there_is_nothing_to_compare_with() -> None:
    _, only = _lines(ViewerPoint("hgs", 300.0, 330.0, None, (68.4, 68.1)))
    assert only[1:6] == ["300", "-", "330", "-", "-"]


def test_a_viewer_is_one_line_as_soon_as_it_is_measured() -> None:
    line = viewer_line(ViewerPoint("hgs", 300.0, 330.4, 345.0, (68.4, 68.1)), 1, 3)
    assert line == "hgs: still 300 ms, orbit 330 ms, playing 345 ms, 68.1 dB at worst (round 1 of 3)"
