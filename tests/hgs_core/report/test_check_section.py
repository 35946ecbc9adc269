from __future__ import annotations

import re

from hgs_core.check.findings import CameraResult, CaptureCheck, Finding, ShownMatch, ShownPair
from hgs_core.report.check_section import PairPictures, check_section

PAIR = ShownPair(
    ("a<b", "c"), 3, ((64, 48), (80, 60)), 5.5, (ShownMatch((10.0, 20.0), (30.0, 34.0), (0.0, 1.0, -30.0)),)
)


def check(*findings: Finding) -> CaptureCheck:
    results = (CameraResult("a<b", 1, 1400, 5.5, -0.2), CameraResult("c", 1, 1400, None, None))
    return CaptureCheck(results, findings, (PAIR,), (0, 3), 80)


def test_cameras_and_findings_are_listed_with_their_names_escaped() -> None:
    html = check_section(check(Finding(True, ("a<b",), "it is upside down", "turn it")), [])
    assert "a&lt;b: it is upside down; turn it" in html
    assert "<td>5.50</td><td>-0.2</td>" in html
    assert "a<b" not in html


def test_a_match_is_drawn_in_both_pictures_and_its_line_across_the_second() -> None:
    html = check_section(check(), [PairPictures(PAIR, "data:1", "data:2")])
    assert re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)"', html) == [("10.0", "20.0"), ("30.0", "34.0")]
    assert '<line x1="0.0" y1="30.0" x2="80.0" y2="30.0"' in html
    assert "miss by 5.50 px" in html


def test_runs_that_were_not_checked_say_so() -> None:
    assert "hgs check does it" in check_section(None, [])
