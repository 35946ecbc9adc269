from __future__ import annotations

from collections.abc import Sequence

import av
import numpy as np
import pytest

from hgs_core.check.field_order import FieldOrder, busiest_frames, field_order
from hgs_core.check.picture_changes import picture_changes
from tests.hgs_core.check.conftest import STUDIO

SIZE = (96, 160)
Film = list[np.ndarray]
MIDDLES = (2, 4, 6)


def striped(frames: int, speed: tuple[float, float]) -> Film:
    """A square of stripes one line high, which moves before a wall of noise."""
    wall = np.random.default_rng(0).integers(40, 160, SIZE)
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]]
    film = []
    for frame in range(frames):
        down, right = rows - 20 - speed[0] * frame, columns - 15 - speed[1] * frame
        inside = (down >= 0) & (down < 40) & (right >= 0) & (right < 40)
        film.append(np.where(inside, np.where(np.floor(down) % 2 == 0, 230, 20), wall).astype(np.uint8))
    return film


def filmed(frames: int) -> Film:
    """The first frames of a camera of samples/studio."""
    with av.open(str(STUDIO / "cam04.mp4")) as video:
        frames_of = video.decode(video=0)
        return [next(frames_of).reformat(format="gray").to_ndarray() for _ in range(frames)]


def woven(film: Sequence[np.ndarray], top_first: bool) -> Film:
    """Every two pictures as the fields of one."""
    made = []
    for first, second in zip(film[::2], film[1::2], strict=True):
        top, bottom = (first, second) if top_first else (second, first)
        made.append(top.copy())
        made[-1][1::2] = bottom[1::2]
    return made


@pytest.mark.parametrize(("top_first", "order"), [(True, FieldOrder.TOP_FIRST), (False, FieldOrder.BOTTOM_FIRST)])
def test_order_of_two_fields_is_found(top_first: bool, order: FieldOrder) -> None:
    assert field_order(woven(filmed(18), top_first).__getitem__, MIDDLES) is order


@pytest.mark.parametrize("speed", [(0, 5), (1, 3), (2, 3), (0.5, 2)])
def test_stripes_that_move_in_whole_pictures_are_no_fields(speed: tuple[float, float]) -> None:
    assert field_order(striped(9, speed).__getitem__, MIDDLES) is FieldOrder.WHOLE


@pytest.mark.parametrize(("frames", "step"), [(9, 1), (18, 2)])
def test_whole_pictures_are_told_at_every_rate(frames: int, step: int) -> None:
    assert field_order(filmed(frames)[::step].__getitem__, MIDDLES) is FieldOrder.WHOLE


def test_repeated_pictures_are_whole() -> None:
    assert field_order([one for one in filmed(5) for _ in (0, 1)].__getitem__, MIDDLES) is FieldOrder.WHOLE


@pytest.mark.parametrize("top_first", [True, False])
def test_the_filter_of_the_cure_makes_whole_pictures(top_first: bool) -> None:
    film = woven(filmed(18), top_first)
    graph = av.filter.Graph()
    source = graph.add_buffer(width=film[0].shape[1], height=film[0].shape[0], format="gray", time_base=1)
    order = FieldOrder.TOP_FIRST if top_first else FieldOrder.BOTTOM_FIRST
    deinterlacer = graph.add("bwdif", f"mode=send_frame:parity={order.value}")
    source.link_to(deinterlacer)
    deinterlacer.link_to(graph.add("buffersink"))
    graph.configure()
    made: Film = []
    for number, picture in enumerate(film):
        frame = av.VideoFrame.from_ndarray(picture, format="gray")
        frame.pts = number
        graph.push(frame)
        made += _ready(graph)
    assert field_order(made.__getitem__, MIDDLES) is FieldOrder.WHOLE


def _ready(graph: av.filter.Graph) -> Film:
    try:
        return [graph.vpull().to_ndarray()]
    except (BlockingIOError, av.EOFError):
        return []


def test_nothing_is_told_where_nothing_moves() -> None:
    assert field_order(striped(9, (0, 0)).__getitem__, MIDDLES) is None


def test_frames_around_the_greatest_motion_are_looked_at() -> None:
    def picture(frame: int) -> np.ndarray:
        grey = np.full((96, 128, 3), 90, np.uint8)
        grey[20:60, : 5 + frame + 20 * max(0, frame - 8)] = 200
        return grey

    assert busiest_frames(picture_changes(picture, range(13))) == (9, 10, 11)
    assert busiest_frames(picture_changes(picture, [0, 5, 12])) == (5,)


def test_still_pictures_have_no_busiest_frame() -> None:
    film = [np.full((96, 128, 3), 90, np.uint8)] * 5
    assert busiest_frames(picture_changes(film.__getitem__, range(5))) == ()
