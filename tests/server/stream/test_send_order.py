from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from itertools import islice

from server.scenes.scene_index import Chunk, SceneIndex, Slice
from server.stream.send_order import COMPLETE, Mark, SendOrder

MakeScene = Callable[..., SceneIndex]
# Ten slices of 1.5 s, each of a base and two refinements, whose sizes tell which they are.
TEN = [(1.5 * k, 1.5 * k + 1.5, [400 + k, 300 + k, 200 + k]) for k in range(10)]


def sizes(order: SendOrder, time: float = 0.0, rate: float = 1.0, measured: float | None = None) -> Iterator[int]:
    """Take chunk after chunk while the playhead stands where it is."""
    while (chunk := order.next(time, rate, measured)) is not None:
        order.settle(chunk)
        yield chunk.size


def first(order: SendOrder, count: int, *playhead: float) -> list[int]:
    return list(islice(sizes(order, *playhead), count))


def test_room_and_what_moves_come_together(make_scene: MakeScene) -> None:
    scene = make_scene([50, 50, 50, 450], [(0.0, 1.0, [300, 300, 300, 900])])
    assert first(SendOrder(scene), 5) == [50, 300, 50, 300, 50]


def test_bases_of_the_next_seconds_come_before_refinements(make_scene: MakeScene) -> None:
    assert first(SendOrder(make_scene([10], TEN)), 4) == [10, 400, 401, 402]


def test_refinements_are_spread_over_the_slices_that_come_soon(make_scene: MakeScene) -> None:
    order = SendOrder(make_scene([10], TEN))
    first(order, 4)
    assert first(order, 6) == [300, 301, 302, 200, 201, 202]


def test_refinements_of_what_stands_and_of_what_moves_take_turns(make_scene: MakeScene) -> None:
    order = SendOrder(make_scene([10, 11, 12], TEN))
    first(order, 4)
    assert first(order, 6) == [11, 300, 12, 301, 302, 200]


def test_bases_go_further_ahead_once_the_next_seconds_are_complete(make_scene: MakeScene) -> None:
    order = SendOrder(make_scene([10], TEN))
    first(order, 10)
    assert first(order, 6) == [403, 404, 405, 303, 304, 305]


def test_faster_playhead_needs_more_of_the_scene(make_scene: MakeScene) -> None:
    assert first(SendOrder(make_scene([], TEN)), 6, 0.0, 2.0) == [400, 401, 402, 403, 404, 300]


def test_playhead_near_the_end_needs_the_beginning(make_scene: MakeScene) -> None:
    order = SendOrder(make_scene([], TEN))
    assert first(order, 6, 14.25) == [409, 400, 401, 309, 300, 301]


def test_refinement_that_would_come_when_its_slice_is_over_waits(make_scene: MakeScene) -> None:
    order = SendOrder(make_scene([], TEN))
    first(order, 3, 0.9)
    # 64 KiB take 0.65 s of this line.
    assert first(order, 1, 0.9, 1.0, 100_000.0) == [301]
    assert first(order, 1, 0.9, 0.0, 100_000.0) == [300]  # nothing passes while the playhead stands


def test_every_chunk_comes_once_and_every_slice_is_marked_by_layer(make_scene: MakeScene) -> None:
    scene = make_scene([10, 20, 30], TEN)
    order = SendOrder(scene)
    assert sorted(sizes(order)) == sorted(chunk.size for chunk in chunks_of(scene))
    assert sorted((mark.layer, mark.index) for mark in order.marks) == [
        (k, i) for k in (0, COMPLETE) for i in range(10)
    ]


def test_slice_that_was_sought_is_marked_again(make_scene: MakeScene) -> None:
    order = SendOrder(make_scene([10], TEN))
    assert list(sizes(order))
    order.marks.clear()
    order.sought(6.5)
    assert order.next(6.5, 1.0) is None
    assert list(order.marks) == [Mark(4, 0), Mark(4, COMPLETE)]


def test_base_of_a_later_slice_is_that_of_the_chunks_it_needs(make_scene: MakeScene) -> None:
    scene = make_scene([], [(0.0, 1.0, [400, 300, 200]), (1.0, 2.0, [100])])
    one, two = scene.slices
    order = SendOrder(
        dataclasses.replace(scene, slices=(one, dataclasses.replace(two, chunks=(*one.chunks, *two.chunks))))
    )
    assert first(order, 3, 1.5) == [400, 100, 300]


def test_limit_of_splats_leaves_out_what_no_picture_has_room_for(make_scene: MakeScene) -> None:
    scene = make_scene([100, 100, 100, 100], [(0.0, 1.0, [100, 100, 100]), (1.0, 2.0, [100])])  # splats as bytes
    order = SendOrder(scene)
    order.limit(400)
    assert sorted(sizes(order)) == [100] * 5  # two static ones, two of the slice with most, and the other's base
    assert order.left_out == 300
    order.limit(None)
    assert list(sizes(order)) == [100] * 3


def test_bases_come_whatever_the_limit(make_scene: MakeScene) -> None:
    order = SendOrder(make_scene([100, 100, 100, 100], [(0.0, 1.0, [100, 100, 100])]))
    order.limit(10)
    assert (list(sizes(order)), order.left_out) == ([100, 100], 500)


def test_static_chunks_have_the_room_that_what_moves_does_not_need(make_scene: MakeScene) -> None:
    order = SendOrder(make_scene([101, 101, 101, 101], [(0.0, 1.0, [50, 50])]))
    order.limit(410)
    assert sorted(sizes(order)) == [50, 50, 101, 101, 101]


def chunks_of(scene: SceneIndex) -> list[Chunk]:
    return [*scene.static, *(chunk for piece in scene.slices for chunk in piece.chunks)]


SOUNDS = [(1.0 * k, 1.0 * k + 1, 20 + k) for k in range(15)]  # one second each


def test_sound_comes_after_the_bases_of_its_time_and_before_refinements(make_scene: MakeScene) -> None:
    order = SendOrder(make_scene([10], TEN, SOUNDS))
    order.hear(True)
    assert first(order, 10) == [10, 400, 401, 402, 20, 21, 22, 23, 300, 301]


def test_sound_at_the_playhead_is_first_and_goes_on_around_the_end(make_scene: MakeScene) -> None:
    order = SendOrder(make_scene([], TEN, SOUNDS))
    order.hear(True)
    assert [size for size in first(order, 9, 13.5) if size < 100] == [33, 34, 20, 21]


def test_who_does_not_listen_gets_no_sound_and_who_begins_to_gets_what_is_missing(make_scene: MakeScene) -> None:
    order = SendOrder(make_scene([10], TEN, SOUNDS))
    assert not {size for size in sizes(order) if size in range(20, 35)}
    order.hear(True)
    assert first(order, 3) == [20, 21, 22]
    order.hear(False)
    assert first(order, 1) == []
    order.hear(True)
    assert first(order, 1) == [23]


def test_equal_sound_at_two_times_comes_once(make_scene: MakeScene) -> None:
    scene = make_scene([], [(0.0, 2.0, [100])], [(0.0, 1.0, 20), (1.0, 2.0, 21)])
    twice = dataclasses.replace(
        scene, sounds=(scene.sounds[0], dataclasses.replace(scene.sounds[0], start=1.0, end=2.0))
    )
    order = SendOrder(twice)
    order.hear(True)
    assert list(sizes(order)) == [100, 20]


def test_pages_come_before_what_they_list_and_those_of_the_next_seconds_before_all_bases(make_scene: MakeScene) -> None:
    scene = make_scene([10], [(2.0 * k, 2.0 * k + 2, [400 + k, 300 + k]) for k in range(12)])
    pages = [Slice(6.0 * k, 6.0 * k + 6, (Chunk(bytes([k]) * 32, 900 + k),)) for k in range(4)]
    slices = [
        dataclasses.replace(piece, chunks=(pages[place // 3].chunks[0], *piece.chunks))
        for place, piece in enumerate(scene.slices)
    ]
    order = SendOrder(dataclasses.replace(scene, slices=tuple(slices), pages=tuple(pages)))
    assert first(order, 6) == [10, 900, 400, 901, 902, 401]
    assert first(order, 2, 17.9) == [408, 903]  # shown chunks precede the next page
    assert sorted(sizes(order)) == sorted({*range(400, 412), *range(300, 312)} - {400, 401, 408})


def test_page_that_replaces_another_one_comes_though_all_chunks_are_there(make_scene: MakeScene) -> None:
    scene = make_scene([10], [(0.0, 2.0, [400])])
    order = SendOrder(scene)
    assert list(sizes(order)) == [10, 400]
    page = Slice(50.0, 52.0, (Chunk(bytes(32), 900),))
    order.grow(dataclasses.replace(scene, pages=(page,), end=52.0), None)
    assert list(sizes(order)) == [900]


def test_sound_never_comes_before_the_page_that_lists_it(make_scene: MakeScene) -> None:
    pieces = [(20.0 * k, 20.0 * k + 20, 50 + k) for k in range(3)]
    scene = make_scene([10], [(20.0 * k, 20.0 * k + 20, [400 + k]) for k in range(3)], pieces)
    pages = tuple(Slice(20.0 * k, 20.0 * k + 20, (Chunk(bytes([k]) * 32, 900 + k),)) for k in range(3))
    order = SendOrder(dataclasses.replace(scene, pages=pages))  # the slices' pages are another matter
    order.hear(True)
    sent = list(sizes(order))
    assert [sent.index(900 + k) < sent.index(50 + k) for k in range(3) if 900 + k in sent] == [True] * 3
    assert {900, 901, 902} <= set(sent)
