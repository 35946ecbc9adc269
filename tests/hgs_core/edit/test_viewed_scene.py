from __future__ import annotations

from hgs_core.edit.viewed_scene import shown_until
from tests.hgs_core.edit.scenes import moving


def test_a_segment_is_shown_until_the_next_starts_and_the_last_until_its_end() -> None:
    scene = moving().scene
    assert [shown_until(scene, i) for i in (0, 1)] == [3.7, 5.3]
