from __future__ import annotations

import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from server.protocol.messages import Hello, Pause, Play, Seek, encode
from server.scenes.scene_index import Chunk, SceneIndex, Slice
from server.scenes.slice_queue import SliceQueue
from server.stream.stream_session import StreamSession


class PlainQueue:
    """The order of the protocol's "Order", by looking at every slice."""

    def __init__(self, ends: list[float]) -> None:
        self.ends = ends
        self.queued = set(range(len(ends)))

    def is_over(self, index: int, time: float) -> bool:
        last = index == len(self.ends) - 1
        return time > self.ends[index] if last else time >= self.ends[index]

    def copy(self) -> PlainQueue:
        return PlainQueue(self.ends)

    def add(self, index: int) -> None:
        self.queued.add(index)

    def discard(self, index: int) -> None:
        self.queued.discard(index)

    def next(self, time: float) -> int | None:
        return min(self.queued, key=lambda index: (self.is_over(index, time), index), default=None)

    def first_shown_after(self, time: float, begin: int = 0) -> int | None:
        return min((k for k in self.queued if k >= begin and not self.is_over(k, time)), default=None)


# Few different values, so that times and ends often are the same; ends need not ascend.
MOMENTS = st.integers(0, 8).map(lambda k: k / 4)


@given(
    ends=st.lists(MOMENTS, max_size=20),
    actions=st.lists(st.tuples(st.sampled_from(["add", "discard", "next", "first"]), st.integers(0, 20), MOMENTS)),
)
def test_queue_answers_as_a_look_at_every_slice_does(ends: list[float], actions: list[tuple[str, int, float]]) -> None:
    queue, plain = SliceQueue(ends).copy(), PlainQueue(ends)
    for action, index, time in actions:
        if action == "next":
            assert queue.next(time) == plain.next(time)
        elif action == "first":
            assert queue.first_shown_after(time, index) == plain.first_shown_after(time, index)
        elif index < len(ends):
            getattr(queue, action)(index)
            getattr(plain, action)(index)


def test_copy_leaves_the_queue_as_it_is() -> None:
    queue = SliceQueue([1.0, 2.0])
    queue.copy().discard(0)
    assert queue.next(0.0) == 0


def scene_of(slices: list[tuple[float, float]]) -> SceneIndex:
    """A scene of one small chunk for each of the slices."""
    return SceneIndex(
        scene_id="s",
        manifest=b"{}",
        start=0.0,
        end=max((end for _, end in slices), default=0.0),
        static=(Chunk(bytes(32), 100),),
        slices=tuple(Slice(*s, (Chunk(k.to_bytes(32, "big"), 5000),)) for k, s in enumerate(slices, 1)),
    )


SLICES = st.lists(st.tuples(MOMENTS, MOMENTS), max_size=8).map(
    lambda pairs: sorted((min(pair), max(pair)) for pair in pairs)
)
MESSAGES = st.one_of(
    st.builds(Seek, MOMENTS), st.builds(Play, MOMENTS, st.integers(0, 4)), st.builds(Pause, MOMENTS), st.none()
)


@given(slices=SLICES, steps=st.lists(st.tuples(MESSAGES, MOMENTS), max_size=30))
def test_whole_stream_is_in_the_order_of_a_look_at_every_slice(
    slices: list[tuple[float, float]], steps: list[tuple[Any, float]]
) -> None:
    scene, reference = scene_of(slices), scene_of(slices)
    object.__setattr__(reference, "queue", PlainQueue([end for _, end in slices]))  # a cached property
    sessions = [StreamSession(scene), StreamSession(reference)]
    clock = 0.0
    for message, wait in [(Hello(1, 1 << 20), 0.0), *steps, *[(None, 0.0)] * 40]:
        clock += wait
        for session in sessions:
            if message is not None:
                session.receive(encode(message), clock)
        first, second = (session.take(clock) for session in sessions)
        assert first == second


def lines_run(function: Callable[[], object]) -> int:
    """Return how many lines of Python a call executes."""
    count = 0

    def trace(frame: FrameType, event: str, argument: object) -> Any:
        nonlocal count
        count += event == "line"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        function()
    finally:
        sys.settrace(before)
    return count


def test_work_for_a_frame_grows_by_the_logarithm_of_the_number_of_slices() -> None:
    """16 times as many slices are four steps more down a tree, and four more up."""
    work = {}
    for count in (64, 1024):
        scene = scene_of([(float(k), k + 1.0) for k in range(count)])
        session = StreamSession(scene)
        session.receive(encode(Hello(1, 1 << 24, time=count / 2)), 0.0)
        session.take(0.0)
        session.take(0.0)
        work[count] = lines_run(lambda session=session: [session.take(0.0) for _ in range(20)])  # type: ignore[misc]
        work[count] += lines_run(lambda scene=scene, count=count: scene.alive(count / 3))  # type: ignore[misc]
    assert work[1024] < 2 * work[64]


def test_queue_that_grows_keeps_what_was_taken_out() -> None:
    queue = SliceQueue([1.0, 2.0, 3.0])
    queue.discard(0)
    grown = queue.grown([1.0, 2.0, 3.0, 4.0, 5.0])
    found = []
    while (index := grown.next(3.0)) is not None:
        found.append(index)
        grown.discard(index)
    assert found == [3, 4, 1, 2]
