from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Callable
from typing import Any

import msgpack
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hgs_core.codec.format.growth import first_segments
from server.bench.bench_scene import made_up_scene
from server.protocol.messages import (
    HEADER_BYTES,
    MAX_BALANCE,
    MAX_PAYLOAD,
    MIN_PAYLOAD,
    PROTOCOL_VERSION,
    Credit,
    Hello,
    Limits,
    Pause,
    Ping,
    Play,
    ProtocolError,
    Seek,
    encode,
)
from server.scenes.scene_index import Chunk, SceneIndex, read_scene
from server.stream.flow_control import SHORT_PAYLOAD
from server.stream.send_order import COMPLETE
from server.stream.stream_session import MAX_UNSENT, ChunkPart, StreamSession

MakeScene = Callable[..., SceneIndex]
WINDOW = 1 << 24
THREE_SLICES = [(0.0, 1.0, [1000, 2000]), (1.5, 2.0, [3000]), (4.0, 5.0, [4000])]


def drain(session: StreamSession, clock: float = 0.0) -> list[Any]:
    """Take all there is: control messages as dicts, chunk frames as ChunkParts."""
    items: list[Any] = []
    while (item := session.take(clock)) is not None:
        items.append(msgpack.unpackb(item) if isinstance(item, bytes) else item)
    return items


def start(scene: SceneIndex, **fields: Any) -> StreamSession:
    session = StreamSession(scene)
    session.receive(encode(Hello(**{"protocol": PROTOCOL_VERSION, "credits": WINDOW} | fields)), 0.0)
    return session


def chunks_of(items: list[Any]) -> list[Chunk]:
    return [item.chunk for item in items if isinstance(item, ChunkPart)]


def marks_of(items: list[Any], layer: int | None = COMPLETE) -> list[int]:
    marks = [item for item in items if isinstance(item, dict) and item["type"] == "slice"]
    return [mark["index"] for mark in marks if mark.get("layer") == layer]


def step(session: StreamSession, frames: int, clock: float = 0.0) -> list[ChunkPart]:
    """Take until that many chunk frames have come."""
    parts: list[ChunkPart] = []
    while len(parts) < frames:
        item = session.take(clock)
        assert item is not None
        if isinstance(item, ChunkPart):
            parts.append(item)
    return parts


def growing_scene(segments: int) -> SceneIndex:
    """Return a scene of three segments when it has the first so many."""
    manifest = first_segments(made_up_scene(6, static_bytes=90_000, slice_bytes=9000).manifest, segments)
    return read_scene("bench", json.dumps(manifest.to_json(), separators=(",", ":")).encode())


def test_nothing_is_said_before_hello(make_scene: MakeScene) -> None:
    assert StreamSession(make_scene([10], [])).take(0.0) is None


def test_welcome_carries_the_manifest_and_what_remains(make_scene: MakeScene) -> None:
    scene = make_scene([10, 20], THREE_SLICES)
    welcome = drain(start(scene, have=frozenset({scene.static[1].id})))[0]
    assert welcome == {
        "type": "welcome",
        "protocol": 1,
        "scene": "studio",
        "manifest": scene.manifest,
        "manifest_id": hashlib.sha256(scene.manifest).digest(),
        "remaining": 10_010,
    }


def test_manifest_that_the_client_keeps_is_not_sent_again(make_scene: MakeScene) -> None:
    scene = make_scene([10], [])
    assert drain(start(scene, manifest_id=scene.manifest_id))[0]["manifest"] == b""
    assert drain(start(scene, manifest_id=bytes(32)))[0]["manifest"] == scene.manifest


def test_bases_come_before_refinements_and_slices_are_marked_by_layer(make_scene: MakeScene) -> None:
    scene = make_scene([10, 20], THREE_SLICES)
    items = drain(start(scene))
    assert [chunk.size for chunk in chunks_of(items)] == [10, 1000, 3000, 20, 2000, 4000]
    assert marks_of(items, 0) == [0, 1, 2]
    assert marks_of(items) == [1, 0, 2]
    assert items[3] == {"type": "slice", "index": 0, "start": 0.0, "end": 1.0, "layer": 0}
    assert items[-1] == {"type": "end", "bytes": 10_030, "left_out": 0}


def test_slices_begin_at_the_playhead_and_wrap_around(make_scene: MakeScene) -> None:
    assert marks_of(drain(start(make_scene([10], THREE_SLICES), time=1.6)), 0) == [1, 2, 0]


def test_paused_playhead_passes_nothing(make_scene: MakeScene) -> None:
    session = start(make_scene([], THREE_SLICES))
    session.receive(encode(Pause(0.5)), 0.0)
    assert marks_of(drain(session, clock=2.6), 0) == [0, 1, 2]


def test_play_moves_the_playhead_and_drops_nothing(make_scene: MakeScene) -> None:
    scene = make_scene([], THREE_SLICES)
    session = start(scene, rate=0.0)
    first = step(session, 1)
    session.receive(encode(Play(4.5, 1.0)), 0.0)
    rest = drain(session)
    assert marks_of(rest, 0) == [2, 0, 1]
    assert len({part.chunk.id for part in [*first, *rest] if isinstance(part, ChunkPart)}) == len(scene.sizes)


def test_seek_sends_what_is_alive_first(make_scene: MakeScene) -> None:
    scene = make_scene([10, 20, 30], [(0.0, 1.0, [1000]), (1.0, 2.0, [2000, 2100]), (2.0, 3.0, [3000])])
    session = start(scene)
    step(session, 3)
    session.receive(encode(Seek(1.5)), 0.0)
    assert chunks_of(drain(session))[0].size == 2000


def test_seek_resumes_a_chunk_that_was_sent_in_part(make_scene: MakeScene) -> None:
    scene = make_scene([3 * SHORT_PAYLOAD], THREE_SLICES)
    session = start(scene)
    assert step(session, 1)[0].offset == 0
    session.receive(encode(Seek(4.7)), 0.0)
    rest = [item for item in drain(session) if isinstance(item, ChunkPart)]
    assert rest[0].chunk == scene.slices[2].chunks[0]
    assert [part.offset for part in rest if part.chunk == scene.static[0]] == [SHORT_PAYLOAD, 2 * SHORT_PAYLOAD]


def test_seek_into_a_complete_slice_marks_it_again(make_scene: MakeScene) -> None:
    session = start(make_scene([10], THREE_SLICES))
    drain(session)
    session.receive(encode(Seek(0.5)), 0.0)
    again = {"type": "slice", "index": 0, "start": 0.0, "end": 1.0}
    assert drain(session) == [again | {"layer": 0}, again | {"layer": 1}]


def test_seek_is_clamped_to_the_scene(make_scene: MakeScene) -> None:
    session = start(make_scene([10], THREE_SLICES), credits=0)
    session.receive(encode(Seek(1e9)), 0.0)
    session.receive(encode(Credit(WINDOW)), 0.0)
    assert marks_of(drain(session), 0)[0] == 2


def test_have_list_is_not_sent_again(make_scene: MakeScene) -> None:
    scene = make_scene([10, 20], THREE_SLICES)
    have = frozenset({scene.static[0].id, scene.slices[1].chunks[0].id, b"\0" * 32})
    items = drain(start(scene, have=have))
    assert not {chunk.id for chunk in chunks_of(items)} & have
    assert sorted(marks_of(items)) == [0, 1, 2]


def test_parts_that_the_client_keeps_are_not_sent_again(make_scene: MakeScene) -> None:
    scene = make_scene([2 * SHORT_PAYLOAD, 500], [(0.0, 1.0, [3000])])
    first, second = scene.static
    have = frozenset({second.id})
    items = drain(start(scene, have=have, parts={first.id: 20_000, second.id: 20, b"\0" * 32: 1 << 40}))
    assert items[0]["remaining"] == 2 * SHORT_PAYLOAD - 20_000 + 3000
    assert [(part.chunk, part.offset, part.length) for part in items if isinstance(part, ChunkPart)] == [
        (first, 20_000, 2 * SHORT_PAYLOAD - 20_000),
        (scene.slices[0].chunks[0], 0, 3000),
    ]
    assert items[-1] == {"type": "end", "bytes": 2 * SHORT_PAYLOAD - 20_000 + 3000, "left_out": 0}


@pytest.mark.parametrize("offset", [10, 11, 1 << 40])
def test_part_that_is_no_part_is_refused(make_scene: MakeScene, offset: int) -> None:
    scene = make_scene([10], [])
    with pytest.raises(ProtocolError, match="has 10 bytes") as caught:
        start(scene, parts={scene.static[0].id: offset})
    assert (caught.value.closing.code, caught.value.closing.error) == (4000, "malformed")


def test_chunk_that_cannot_be_read_costs_itself_alone(make_scene: MakeScene) -> None:
    scene = make_scene([10, 20], [(0.0, 1.0, [1000, 2000]), (1.0, 2.0, [3000])])
    session = start(scene)
    items: list[Any] = []
    while (item := session.take(0.0)) is not None:
        if isinstance(item, ChunkPart) and item.chunk.size in (20, 1000):
            session.miss(item)
        else:
            items.append(msgpack.unpackb(item) if isinstance(item, bytes) else item)
    assert items[2] == {"type": "missing", "id": scene.slices[0].chunks[0].id}
    assert {"type": "missing", "id": scene.static[1].id} in items
    assert [chunk.size for chunk in chunks_of(items)] == [10, 3000, 2000]
    assert sorted(marks_of(items)) == [0, 1]
    assert items[-1] == {"type": "end", "bytes": 5010, "left_out": 0}
    assert session.balance == WINDOW - 5010 - 3 * HEADER_BYTES


def test_chunk_that_breaks_off_is_not_gone_on_with(make_scene: MakeScene) -> None:
    session = start(make_scene([3 * SHORT_PAYLOAD, 20], []))
    step(session, 1)
    (second,) = step(session, 1)
    session.miss(second)
    items = drain(session)
    assert [chunk.size for chunk in chunks_of(items)] == [20]
    assert items[-1] == {"type": "end", "bytes": SHORT_PAYLOAD + 20, "left_out": 0}


def test_full_have_list_gets_markers_and_end_without_credit(make_scene: MakeScene) -> None:
    scene = make_scene([10, 20], THREE_SLICES)
    items = drain(start(scene, have=frozenset(scene.sizes), credits=0))
    assert [item["type"] for item in items] == ["welcome", *["slice"] * 6, "end"]


def test_still_scene_ends_after_its_statics(make_scene: MakeScene) -> None:
    items = drain(start(make_scene([10], [])))
    assert items[-1] == {"type": "end", "bytes": 10, "left_out": 0}


def test_chunk_of_two_slices_is_sent_once(make_scene: MakeScene) -> None:
    scene = make_scene([], [(0.0, 1.0, [1000]), (1.0, 2.0, [2000])])
    shared = scene.slices[0].chunks[0]
    again = dataclasses.replace(scene.slices[1], chunks=(shared,))
    twice = dataclasses.replace(scene, slices=(scene.slices[0], again))
    items = drain(start(twice))
    assert chunks_of(items) == [shared]
    assert marks_of(items) == [0, 1]


def test_rate_limit_is_kept_from_frame_to_frame(make_scene: MakeScene) -> None:
    session = start(make_scene([10_000_000], []), bytes_per_second=80_000)
    clock, sent = 0.0, 0
    while clock < 10.0:
        item = session.take(clock)
        sent += HEADER_BYTES + item.length if isinstance(item, ChunkPart) else 0
        if item is None:
            wait = session.wait(clock)
            assert wait is not None
            clock += wait
    assert sent == pytest.approx(800_000, rel=0.03)
    session.receive(encode(Limits()), clock)
    assert len([session.take(clock) for _ in range(20)]) == 20


def test_refinements_that_a_limit_of_splats_leaves_out_come_when_it_is_lifted(make_scene: MakeScene) -> None:
    scene = make_scene([100, 200], [(0.0, 1.0, [100, 100, 100])])  # one splat for each byte
    session = start(scene, splats=320)
    items = drain(session)
    assert [chunk.size for chunk in chunks_of(items)] == [100, 100, 100]
    assert items[-1] == {"type": "end", "bytes": 300, "left_out": 300}
    session.receive(encode(Limits()), 0.0)
    assert sorted(chunk.size for chunk in chunks_of(drain(session))) == [100, 200]


def test_ping_is_answered_before_the_next_frame(make_scene: MakeScene) -> None:
    session = start(make_scene([10, 20], []))
    step(session, 1)
    session.receive(encode(Ping(7)), 0.0)
    assert drain(session)[0] == {"type": "pong", "id": 7}


def test_client_that_asks_and_does_not_read_is_refused(make_scene: MakeScene) -> None:
    session = start(make_scene([10], []))
    for k in range(MAX_UNSENT - 1):  # the welcome waits too
        session.receive(encode(Ping(k)), 0.0)
    with pytest.raises(ProtocolError) as caught:
        session.receive(encode(Ping(0)), 0.0)
    assert caught.value.closing.error == "flood"


def test_no_credit_no_frames(make_scene: MakeScene) -> None:
    session = start(make_scene([10], []), credits=0)
    assert [item["type"] for item in drain(session)] == ["welcome"]


def test_least_balance_that_always_lets_a_frame_through(make_scene: MakeScene) -> None:
    session = start(make_scene([10_000], []), credits=MIN_PAYLOAD + HEADER_BYTES - 1)
    assert len(drain(session)) == 1
    session.receive(encode(Credit(1)), 0.0)
    (part,) = drain(session)
    assert (part.offset, part.length) == (0, MIN_PAYLOAD)


def test_credit_overflow_is_refused(make_scene: MakeScene) -> None:
    session = start(make_scene([10], []), credits=MAX_BALANCE)
    with pytest.raises(ProtocolError) as caught:
        session.receive(encode(Credit(1)), 0.0)
    assert (caught.value.closing.code, caught.value.closing.error) == (4009, "credit-overflow")


@pytest.mark.parametrize("first", [Credit(1), Seek(0.0), Ping(1), Play(0.0, 1.0), Pause(0.0)])
def test_hello_comes_first(make_scene: MakeScene, first: Any) -> None:
    with pytest.raises(ProtocolError, match="hello"):
        StreamSession(make_scene([10], [])).receive(encode(first), 0.0)


def test_hello_comes_once(make_scene: MakeScene) -> None:
    session = start(make_scene([10], []))
    with pytest.raises(ProtocolError, match="hello"):
        session.receive(encode(Hello(1, 0)), 0.0)


def test_follower_gets_what_is_added_and_nothing_twice() -> None:
    first, second, last = (growing_scene(count) for count in (1, 2, 3))
    session = start(first, follow=True)
    items = drain(session)
    for scene, before in ((second, first), (last, second)):
        session.grow(scene, 1.0)
        session.grow(scene, 1.0)  # the same again is no news
        added = drain(session, 1.0)
        assert added[0]["type"] == "grow"
        assert (added[0]["manifest"], added[0]["manifest_id"]) == (scene.manifest, scene.manifest_id)
        assert added[0]["remaining"] == sum(chunk.size for chunk in chunks_of(added))
        assert added[-1]["type"] == "end"
        assert marks_of(added) == [k for k in range(len(scene.slices)) if k >= len(before.slices)]
        items += added
    received = [chunk.id for chunk in chunks_of(items)]
    assert len(received) == len(set(received))
    assert set(received) == first.sizes.keys() | second.sizes.keys() | last.sizes.keys()


def test_pages_are_sent_with_their_bytes_and_in_their_turn() -> None:
    scene = read_scene("bench", made_up_scene(120, static_bytes=12_000, slice_bytes=900).document)
    items = [item for item in drain(start(scene)) if isinstance(item, ChunkPart)]
    pages = {item.chunk.id: item.data for item in items if item.data is not None}
    assert pages == scene.page_bytes
    place = {item.chunk.id: number for number, item in enumerate(items)}
    for page, listed in scene.page_chunks.items():
        assert place[page] < min(place[chunk] for chunk in listed)
    assert place[scene.pages[2].chunks[0].id] > place[scene.slices[70].chunks[1].id]  # none long before its time


def test_page_that_another_one_has_replaced_is_not_gone_on_with() -> None:
    first, page = growing_scene(1), Chunk(b"p" * 32, 10_000)
    (data,) = first.page_bytes.values()
    first = dataclasses.replace(
        first,
        slices=tuple(dataclasses.replace(piece, chunks=(page, *piece.chunks[1:])) for piece in first.slices),
        pages=(dataclasses.replace(first.pages[0], chunks=(page,)),),
        page_bytes={page.id: data.ljust(page.size, b"\0")},
    )
    have = frozenset(chunk.id for chunk in first.static)
    session = start(first, follow=True, have=have, credits=HEADER_BYTES + 5000)
    assert [part.chunk for part in step(session, 1)] == [page]
    session.grow(growing_scene(3), 0.0)
    session.receive(encode(Credit(WINDOW)), 0.0)
    assert page not in chunks_of(drain(session))


def test_who_does_not_follow_keeps_the_scene_as_it_was() -> None:
    session = start(growing_scene(1))
    drain(session)
    session.grow(growing_scene(2), 1.0)
    assert drain(session, 1.0) == []


def test_scene_that_grows_before_hello_is_welcomed_as_it_is() -> None:
    session = StreamSession(growing_scene(1))
    session.grow(growing_scene(2), 0.0)
    session.receive(encode(Hello(1, WINDOW)), 0.0)
    assert drain(session)[0]["manifest"] == growing_scene(2).manifest


def test_older_version_is_no_news_and_another_scene_ends_the_stream(make_scene: MakeScene) -> None:
    session = start(growing_scene(2), follow=True)
    drain(session)
    session.grow(growing_scene(1), 1.0)
    assert drain(session, 1.0) == []
    other = read_scene("bench", growing_scene(3).document.replace(b'"extent":4.0', b'"extent":5.0'))
    with pytest.raises(ProtocolError, match="another scene"):
        session.grow(other, 1.0)


def test_growth_keeps_the_limit_of_splats() -> None:
    session = start(growing_scene(1), follow=True, splats=1)
    before = chunks_of(drain(session))
    session.grow(growing_scene(3), 1.0)
    added = drain(session, 1.0)
    assert {chunk.layer for chunk in (*before, *chunks_of(added))} == {0}
    assert added[-1]["left_out"] > 0


ACTIONS = st.one_of(
    st.builds(Credit, st.integers(0, 200_000)),
    st.builds(Seek, st.floats(-1, 4)),
    st.builds(Play, st.floats(-1, 4), st.floats(0, 16)),
    st.builds(Pause, st.floats(-1, 4)),
    st.just(None),  # time passes and a frame is taken
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(
    static=st.lists(st.integers(1, 200_000), max_size=4),
    sizes=st.lists(st.lists(st.integers(1, 100_000), max_size=3), min_size=1, max_size=4),
    credit=st.integers(0, 100_000),
    actions=st.lists(ACTIONS, max_size=40),
    missing=st.sets(st.integers(0, 20)),
)
def test_credits_are_never_exceeded_and_every_byte_comes_once(
    make_scene: MakeScene, static: list[int], sizes: list[list[int]], credit: int, actions: list[Any], missing: set[int]
) -> None:
    scene = make_scene(static, [(k * 0.75, k * 0.75 + 1.0, chunk_sizes) for k, chunk_sizes in enumerate(sizes)])
    session = start(scene, credits=credit)
    granted, sent, clock = credit, 0, 0.0
    received: dict[bytes, int] = {}
    lost = {chunk for k, chunk in enumerate(scene.sizes) if k in missing}
    told: set[bytes] = set()

    def take() -> Any:
        nonlocal sent
        item = session.take(clock)
        if isinstance(item, ChunkPart) and item.chunk.id in lost:
            session.miss(item)
        elif isinstance(item, ChunkPart):
            sent += HEADER_BYTES + item.length
            assert item.offset == received.get(item.chunk.id, 0)
            assert 1 <= item.length <= MAX_PAYLOAD
            received[item.chunk.id] = item.offset + item.length
            assert received[item.chunk.id] <= item.chunk.size
        elif item is not None and (message := msgpack.unpackb(item))["type"] == "slice":
            piece = scene.slices[message["index"]]
            needed = [chunk for chunk in (piece.chunks if message["layer"] else piece.base) if chunk.id not in told]
            assert all(received[chunk.id] == chunk.size for chunk in needed)
        elif item is not None and message["type"] == "missing":
            assert message["id"] in lost - told
            told.add(message["id"])
        assert sent <= granted
        assert session.balance == granted - sent
        return item

    for action in actions:
        if isinstance(action, Credit):
            granted += action.bytes
        if action is not None:
            session.receive(encode(action), clock)
        clock += 0.1
        take()
    while granted - sent < MAX_BALANCE // 2:
        session.receive(encode(Credit(1 << 20)), clock)
        granted += 1 << 20
    while take() is not None:
        pass
    assert received == {chunk: size for chunk, size in scene.sizes.items() if chunk not in lost}
    assert told == lost


def test_sound_comes_to_who_asks_for_it_and_counts_for_them_alone(make_scene: MakeScene) -> None:
    scene = make_scene([50], [(0.0, 2.0, [100])], [(0.0, 1.0, 20), (1.0, 2.0, 21)])
    deaf = drain(start(scene))
    assert (deaf[0]["remaining"], [chunk.size for chunk in chunks_of(deaf)]) == (150, [50, 100])
    listening = drain(start(scene, audio=True))
    assert (listening[0]["remaining"], [chunk.size for chunk in chunks_of(listening)]) == (191, [50, 100, 20, 21])
    assert listening[-1] == {"type": "end", "bytes": 191, "left_out": 0}


def test_who_begins_to_listen_gets_the_sound_then_and_what_it_keeps_does_not_come(make_scene: MakeScene) -> None:
    scene = make_scene([50], [(0.0, 2.0, [100])], [(0.0, 1.0, 20), (1.0, 2.0, 21)])
    session = start(scene, have=frozenset({scene.sounds[0].chunks[0].id}))
    before = drain(session)
    assert (before[0]["remaining"], before[-1]["type"]) == (150, "end")
    session.receive(encode(Limits(audio=True)), 0.0)
    after = drain(session)
    assert [chunk.size for chunk in chunks_of(after)] == [21]
    assert after[-1]["type"] == "end"
    session.receive(encode(Limits(measured=1000)), 0.0)  # replaces all earlier limits
    assert [item["type"] for item in drain(session)] == ["end"]
