"""Demands on splats in every engine: each function draws them in a host's page, and asserts one behaviour."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from benchmarks.viewers.browser import psnr
from tests.web_client.engine_hosts import (
    CANVAS_PSNR,
    MAGENTA,
    Engine,
    Picture,
    add_splats,
    camera_named,
    canvas,
    look,
    numbers,
    rasterized,
    settle,
)

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from tests.web_client.conftest import Site

__all__ = [
    "mounts",
    "require_depth",
    "require_meshes_around",
    "require_nothing_left",
    "require_one_complaint",
    "require_restored_context",
    "require_same_frames",
    "require_same_picture_moved",
    "require_steady_heap",
    "require_two_views",
    "require_wall",
    "require_whole_life",
]

WALL = 3.0  # depth, in the middle of the splats


def require_same_picture_moved(page: Page, site: Site) -> None:
    """A scene that is moved, turned and scaled is the same picture to a camera that is, too."""
    camera = camera_named(site, "above")
    scale, turn = 2.5, 0.7
    place = np.eye(4)
    place[:3, :3] = scale * np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    place[:3, 3] = [3.0, -1.0, 7.0]
    rows = np.asarray(camera.world_to_camera, np.float64) @ np.linalg.inv(place)
    rows[:3] *= scale
    look(page, camera, rows, scale)
    add_splats(page, place=place.tolist())
    settle(page)
    assert psnr(canvas(page), rasterized(site, camera, 0.4)) >= CANVAS_PSNR


def require_wall(
    page: Page,
    site: Site,
    shown: Callable[[Page], npt.NDArray[np.generic]] = canvas,
    least: float = CANVAS_PSNR,
    linear: bool = True,
) -> None:
    """Splats behind a wall are hidden, and those before it are drawn over it.

    The reference has only the splats with centres before the wall, on its colour.
    """
    camera = camera_named(site, "side")
    rows = np.asarray(camera.world_to_camera, np.float64)
    truth = rasterized(
        site, camera, 0.4, background=MAGENTA, keep=lambda means: (means.numpy() @ rows[2, :3] + rows[2, 3]) < WALL
    )
    look(page, camera)
    page.evaluate("(depth) => host.addWall(depth)", WALL)
    add_splats(page, **({} if linear else {"linear": False}))
    settle(page)
    assert psnr(shown(page), truth) >= least


def require_depth(page: Page, site: Site) -> None:
    """A mesh before the splats keeps its colour, and one behind them is covered."""
    look(page, camera_named(site, "side"))
    page.evaluate("() => host.addWall(1, { size: 0.3, at: [0.2, 0.1], colour: [1, 0, 0] })")
    page.evaluate("() => host.addWall(6, { size: 2, at: [-0.5, 0], colour: [0, 1, 0] })")
    without = canvas(page)
    add_splats(page)
    settle(page)
    _require_around(canvas(page), without, *((without == colour).all(axis=2) for colour in ([255, 0, 0], [0, 255, 0])))


def require_meshes_around(shown: Picture, without: Picture) -> None:
    """The example's red mesh is before its splats, and the blue one behind them."""
    others = [np.delete(without, channel, axis=2).max(axis=2).astype(int) for channel in (0, 2)]
    bright = [without[..., channel] > np.maximum(2 * other, 30) for channel, other in zip((0, 2), others, strict=True)]
    _require_around(shown, without, *bright)


def _require_around(
    shown: Picture, without: Picture, before: npt.NDArray[np.bool_], behind: npt.NDArray[np.bool_]
) -> None:
    assert before.sum() > 1000
    assert behind.sum() > 1000
    assert np.array_equal(shown[before], without[before])
    assert (shown[behind] != without[behind]).any(axis=1).mean() > 0.9


def require_same_frames(engine: Engine, page: Page, site: Site, error: str) -> None:
    """The host's own picture is unchanged, bit by bit, while splats arrive and are drawn behind a wall.

    With textures of the host's before and after them; `error` is an expression of WebGL's.
    """
    camera = camera_named(site, "side")
    pictures = []
    for splats in (False, True):
        with engine.hosting(page):
            look(page, camera)
            page.evaluate("() => { host.addThings(); host.addWall(8) }")
            if splats:
                behind = np.eye(4)
                behind[:3, 3] = 20 * np.asarray(camera.world_to_camera)[2, :3]
                add_splats(page, place=behind.tolist())
            taken = page.evaluate("() => host.frames(0, 8)")
            if splats:
                settle(page)
            taken += page.evaluate("() => host.frames(8, 4)")
            assert page.evaluate(f"() => [warnings, {error}]") == [[], 0]
            pictures.append(taken)
    assert len(set(pictures[0])) > 5  # every second frame is another picture
    assert [a == b for a, b in zip(*pictures, strict=True)] == [True] * 12


def require_two_views(page: Page, site: Site) -> None:
    """Each of two views of a canvas of twice the width has its own order."""
    cameras = [camera_named(site, name) for name in ("side", "askew")]
    page.evaluate("(cameras) => host.split(...cameras)", [numbers(camera) for camera in cameras])
    add_splats(page)
    settle(page)
    for camera, half in zip(cameras, np.split(canvas(page), 2, axis=1), strict=True):
        assert psnr(half, rasterized(site, camera, 0.4)) >= CANVAS_PSNR


def require_restored_context(page: Page, site: Site) -> None:
    """A context that was lost comes back with the splats."""
    look(page, camera_named(site, "side"))
    add_splats(page)
    settle(page)
    before = canvas(page)
    page.evaluate("() => host.loseContext()")
    settle(page)
    assert np.array_equal(canvas(page), before)


def require_one_complaint(page: Page, site: Site, scaled: str) -> None:
    """An impossible scale is reported once, and the host goes on; `scaled` sets the scale of `host.splats`."""
    look(page, camera_named(site, "side"))
    without = canvas(page)
    add_splats(page)
    settle(page)
    shown = canvas(page)
    page.evaluate(f"() => {{ host.heard.length = 0; host.splats.{scaled}(1, 2, 1) }}")
    for _ in range(3):
        assert np.array_equal(canvas(page), without)
    said = page.evaluate("() => host.heard")
    assert [words.partition(":")[0] for words in said] == ["the scene is scaled by 1, 2, 1"]
    assert page.evaluate("() => warnings") == [f"HgsScene: {said[0]}"]
    page.evaluate(f"() => {{ host.splats.{scaled}(1, 1, 1) }}")
    assert np.array_equal(canvas(page), shown)


def require_whole_life(page: Page, site: Site, once: str, end: str) -> None:
    """A scene plays, tells and ends; the host's picture is then the one without splats.

    `once` is the splats' method for one event; `end` removes them while they seek: an expression that is fulfilled
    with the error's name.
    """
    look(page, camera_named(site, "side"))
    page.evaluate("() => host.addThings()")
    without = canvas(page)
    add_splats(page, 1.9, playbackRate=4)
    settle(page)
    state = page.evaluate("() => [host.splats.paused, host.splats.duration, host.splats.currentTime]")
    assert state == [True, 2, 1.9]
    ended = f'new Promise((resolve) => {{ host.splats.{once}("ended", () => resolve()); host.splats.play() }})'
    page.evaluate(f"() => host.drawUntil({ended})")
    told = [name for name in page.evaluate("() => host.heard") if name != "seeked"]
    assert told == ["manifest", "firstpicture", "ready", "play", "pause", "ended"]
    assert page.evaluate("() => host.splats.ended")
    assert page.evaluate(end) == "AbortError"
    assert np.array_equal(canvas(page), without)


def mounts(end: str, held: str) -> str:
    """A function of a page that has so many scenes come and go: `end` removes one, `held` is its result."""
    return f"""async (count) => {{
      for (let i = 0; i < count; i++) {{
        host.addSplats({{ src: "/clouds/manifest.json", time: 0.4 }});
        await host.settled();
        host.splats.{end}();
        host.heard.length = 0;
        host.draw();
      }}
      return {held};
    }}"""


def require_nothing_left(page: Page, site: Site, mounts: str) -> None:
    """Scenes that come and go leave nothing."""
    look(page, camera_named(site, "side"))
    assert page.evaluate(mounts, 1) == page.evaluate(mounts, 1)
    assert page.evaluate("() => warnings") == []


def require_steady_heap(page: Page, site: Site, mounts: str) -> None:
    """Two hundred scenes that come and go leave a page's heap as it was."""
    look(page, camera_named(site, "side"))
    session = page.context.new_cdp_session(page)

    def heap(count: int) -> float:
        page.evaluate(mounts, count)
        session.send("HeapProfiler.collectGarbage")
        used: float = session.send("Runtime.getHeapUsage")["usedSize"]
        return used / 1e6

    first = heap(20)
    after = [heap(60) for _ in range(3)]
    print(f"heap after 20, 80, 140 and 200 mounts: {first:.2f} {after} MB")
    assert after[-1] < first + 1.0
