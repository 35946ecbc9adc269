from __future__ import annotations

from server.stream.playhead import Playhead


def test_playhead_wraps_as_a_looping_player_does() -> None:
    playhead = Playhead(start=10.0, end=14.0, time=10.0)
    playhead.set(13.0, clock=100.0, rate=2.0)
    assert playhead.at(100.5) == 14.0
    assert playhead.at(101.0) == 11.0
    playhead.set(99.0, clock=101.0)
    assert playhead.at(101.0) == 14.0


def test_playhead_of_a_moment_stands() -> None:
    assert Playhead(start=1.0, end=1.0, time=1.0).at(5.0) == 1.0


def test_playhead_waits_at_the_edge_of_a_scene_that_grows() -> None:
    playhead = Playhead(start=0.0, end=4.0, time=3.0, grows=True)
    assert playhead.at(2.0) == 4.0
