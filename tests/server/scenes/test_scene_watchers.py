from __future__ import annotations

from server.scenes.scene_watchers import SceneWatchers


def test_all_who_watch_a_scene_are_told_and_nobody_else() -> None:
    watchers = SceneWatchers()
    with watchers.join("a") as first, watchers.join("a") as second, watchers.join("b") as other:
        watchers.tell("a")
        assert (first.is_set(), second.is_set(), other.is_set()) == (True, True, False)


def test_who_has_left_is_forgotten() -> None:
    watchers = SceneWatchers()
    with watchers.join("a") as first:
        pass
    with watchers.join("a") as second:
        watchers.tell("a")
    watchers.tell("a")
    assert (first.is_set(), second.is_set()) == (False, True)
    assert watchers._watching == {}
