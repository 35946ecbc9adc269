from __future__ import annotations

from hgs_core.codec.format.growth import first_segments
from hgs_core.codec.format.manifest import Manifest
from server.bench.bench_scene import made_up_scene
from server.client.playback import Buffer, Clock, Throughput

MADE_UP: Manifest = made_up_scene(10, static_bytes=1200, slice_bytes=90).manifest  # 20 slices of 60 and 30 bytes
ROOM = [entry.id for entry in MADE_UP.static]
BASES = [piece.chunks[0].id for piece in MADE_UP.slices]
DETAILS = [piece.chunks[1].id for piece in MADE_UP.slices]


def test_playhead_waits_at_the_edge_and_goes_on_when_the_scene_has_grown() -> None:
    have = {*ROOM, *BASES, *DETAILS}
    clock = Clock(Buffer(first_segments(MADE_UP, 1)), 1.9)
    for now in (0.0, 0.05, 0.1, 0.2, 5.0):
        clock.tick(now, have, 1e6)
    assert clock.time == 2.0
    assert (clock.at_edge, clock.waiting, clock.stalls, clock.waited) == (True, True, 0, 0.0)
    clock.buffer = Buffer(MADE_UP)
    clock.tick(5.2, have, 1e6)
    assert (clock.at_edge, clock.waiting) == (False, False)
    assert clock.time > 2.0


def test_throughput_is_the_lower_of_two_means() -> None:
    line = Throughput()
    assert line.rate(0.0) == 0.0
    for k in range(100):
        line.count(1000, k / 10)
    assert 9999 < line.rate(10.0) < 10_001
    for k in range(100, 110):
        line.count(100, k / 10)
    slower = line.rate(11.0)
    assert slower < 4000
    for k in range(110, 120):
        line.count(1000, k / 10)
    assert line.rate(12.0) < 9000
    assert line.rate(60.0) == 0.0


def test_moment_can_be_shown_once_the_bases_are_there() -> None:
    buffer = Buffer(MADE_UP)
    assert not buffer.playable(1.2, {*ROOM[:2], *BASES})
    assert not buffer.playable(1.2, {*ROOM[:3], BASES[0], BASES[2]})  # slice 2 needs the base of slice 1, too
    assert buffer.playable(1.2, {*ROOM[:3], BASES[0], BASES[1], BASES[2]})


def test_playing_lasts_where_bases_come_as_fast_as_they_are_shown() -> None:
    buffer = Buffer(MADE_UP)
    have = {*ROOM, BASES[0]}
    assert buffer.lasts(0.0, 1.0, have, line=130, reserve=1.5)  # 120 bytes per second are shown
    assert not buffer.lasts(0.0, 1.0, have, line=110, reserve=1.5)
    assert not buffer.lasts(0.0, 2.0, have, line=130, reserve=1.5)
    assert buffer.lasts(0.0, 1.0, {*ROOM, *BASES[:3]}, line=0, reserve=1.5)
    assert not buffer.lasts(0.0, 1.0, {*ROOM, *BASES[:3]}, line=0, reserve=3.0)
    assert buffer.lasts(9.6, 1.0, {*ROOM, *BASES[16:]}, line=0, reserve=3.0)


def test_clock_counts_what_it_waits_for_after_it_has_begun() -> None:
    clock = Clock(Buffer(MADE_UP), 0.0)
    assert not clock.tick(0.0, set(), 0.0)
    have = {*ROOM, *BASES[:4]}
    assert clock.tick(0.1, have, 0.0)
    assert clock.started == 0.1
    now = 0.1
    while not clock.waiting:
        now += 0.1
        clock.tick(now, have, 0.0)
    assert 1.8 < clock.time < 2.0
    have.update(BASES[:8])
    assert not clock.tick(now + 0.1, have, 0.0)  # a larger reserve after a wait
    have.update(BASES)
    assert clock.tick(now + 0.2, have, 0.0)
    assert clock.stalls == 1
    assert 0.05 < clock.waited < 0.25


def test_waiting_after_a_seek_is_no_stall() -> None:
    clock = Clock(Buffer(MADE_UP), 0.0)
    have = {*ROOM, *BASES[:4]}
    clock.tick(0.0, have, 0.0)
    clock.tick(0.1, have, 0.0)
    clock.seek(5.0)
    clock.tick(0.2, have, 0.0)
    assert clock.waiting
    assert clock.stalls == 0


def test_clock_goes_on_at_the_start_after_the_end() -> None:
    clock = Clock(Buffer(MADE_UP), 9.9)
    have = {*ROOM, *BASES}
    for now in (0.0, 0.2):
        clock.tick(now, have, 1e6)
    assert clock.time < 1.0
