"""The room of a sparse rig: it fades between the cameras and on request, and the subject does not."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pytest

from benchmarks.viewers.browser import canvas_pixels
from tests.web_client.conftest import serving, site_of
from tests.web_client.emulated_headset import headset_page
from tests.web_client.sparse_scene import ARC, AROUND, encode_room, green, red
from tests.web_client.test_embedding import Host, embedding, hosting, wait_for_picture
from tests.web_client.test_player_manners import settled
from tests.web_client.test_view_page import viewing

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(180)]

BETWEEN = "view=2.598,0,-1.5,0,0,0,0,-1,0"  # 60 degrees from two of the three cameras
ROOM = 0.5  # share of a picture that the walls fill at least, if they are there
TURN = -175  # pixels: 60 degrees
PIXELS = """() => {  // every 101st, which would take long to hand over otherwise
  const { data } = one.player.readPixels();
  return Array.from({ length: data.length / 404 }, (_, i) => [...data.subarray(404 * i, 404 * i + 3)]);
}"""

# The green of a corner before a key is pressed, and frame by frame from then on, until it stays.
SWITCHED = """async (key) => {
  const seen = [];
  const look = async () => seen.push((await window.hgs.readPixels()).data[1]);
  await look();
  document.querySelector(".player-host").shadowRoot.querySelector(".stage")
    .dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, composed: true }));
  while (seen.length < 20 || seen.at(-1) !== seen.at(-10) || seen.at(-1) === seen[0]) {
    await new Promise(requestAnimationFrame);
    await look();
  }
  return seen;
}"""


@pytest.fixture(scope="module")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Site]]:
    """The room filmed by a sparse and by a dense rig."""
    folder = tmp_path_factory.mktemp("rooms")
    rigs = {"sparse": AROUND, "dense": ARC}
    manifests = {name: encode_room(folder / name / "scene", rig) for name, rig in rigs.items()}
    assert manifests["sparse"].captured_space is not None
    assert manifests["sparse"].captured_space.subject_only
    with serving([folder / name for name in rigs], tmp_path_factory.mktemp("home")) as pages:
        yield {name: site_of(page, folder / name / "scene") for name, page in zip(rigs, pages, strict=True)}


@pytest.fixture
def host(rooms: dict[str, Site], tmp_path: Path) -> Iterator[Host]:
    from tests.web_client.test_embedding import PLAYER

    for name, room in rooms.items():
        (tmp_path / name).symlink_to(room.folder)
    (tmp_path / "player").symlink_to(PLAYER)
    with hosting(tmp_path) as served:
        yield served


def press(page: Page, key: str) -> np.ndarray:
    page.keyboard.press(key)
    return settled(page)


def test_a_room_without_a_second_view_comes_with_the_key_and_goes(browser: Browser, rooms: dict[str, Site]) -> None:
    with viewing(browser, rooms["sparse"], reduced_motion="reduce") as page:
        first = settled(page)
        assert green(first) == 0
        assert red(first) > 0.03
        assert first.mean(axis=(0, 1)).min() > 20  # a soft background, no black
        whole = press(page, "h")
        assert green(whole) > ROOM
        assert red(whole) > 0.03
        assert green(press(page, "h")) == 0


def test_between_the_cameras_the_room_fades_and_comes_back(browser: Browser, rooms: dict[str, Site]) -> None:
    with viewing(browser, rooms["sparse"], "?paused=1&t=0.4&subject=0") as page:
        before = settled(page)
        assert green(before) > ROOM
        page.mouse.move(400, 240)
        page.mouse.down()
        page.mouse.move(400 + TURN / 3, 240, steps=6)
        partly = settled(page)
        page.mouse.move(400 + TURN, 240, steps=6)
        page.mouse.up()
        away = settled(page)
        page.mouse.move(300, 240)
        page.mouse.down()
        page.mouse.move(300 - TURN, 240, steps=6)
        page.mouse.up()
        back = settled(page)
    dimmed = before[:50, :50, 1].mean() - partly[:50, :50, 1].mean()
    assert 5 < dimmed < 100
    assert green(away) == 0
    assert red(away) > 0.03
    assert green(back) == pytest.approx(green(before), abs=0.02)


def test_a_dense_rig_never_fades_but_with_the_key(browser: Browser, rooms: dict[str, Site]) -> None:
    with viewing(browser, rooms["dense"], f"?paused=1&t=0.4&{BETWEEN}", reduced_motion="reduce") as page:
        assert green(settled(page)) > ROOM
        assert green(press(page, "h")) == 0


def test_the_key_lets_the_room_fade_and_come_back(browser: Browser, rooms: dict[str, Site]) -> None:
    with viewing(browser, rooms["dense"]) as page:
        there, *fading, gone = page.evaluate(SWITCHED, "h")
        assert there > 100
        assert len({round(green) for green in fading if gone + 2 < green < there - 2}) >= 2
        assert page.evaluate(SWITCHED, "h")[-1] == pytest.approx(there, abs=1)


@pytest.mark.parametrize(
    ("name", "attribute", "there"),
    [
        ("sparse", "", False),
        ("sparse", 'subject-only="false"', True),
        ("dense", "", True),
        ("dense", "subject-only", False),
    ],
)
def test_the_attribute_decides_before_the_scene(
    browser: Browser, host: Host, name: str, attribute: str, there: bool
) -> None:
    body = (
        f'<hgs-player id="one" src="{name}/manifest.json" {attribute}></hgs-player>'
        '<script type="module" src="player/hgs-player.js"></script>'
    )
    with embedding(browser, host, body) as page:
        wait_for_picture(page)

        def shown() -> bool:
            page.evaluate("() => one.player.seek(one.currentTime)")
            picture = np.array([page.evaluate(PIXELS)], np.uint8)
            assert red(picture) > 0.005
            return green(picture) > ROOM

        assert shown() is there
        assert page.evaluate("() => one.subjectOnly") is not there
        page.evaluate("(alone) => { one.subjectOnly = alone; }", there)
        assert shown() is not there
        page.evaluate("() => one.removeAttribute('subject-only')")
        page.evaluate("() => { one.subjectOnly = null; }")
        assert shown() is (name == "dense")


@pytest.mark.parametrize("subject", ["", "&subject=1"])
def test_pictures_for_measurements_have_the_room(browser: Browser, rooms: dict[str, Site], subject: str) -> None:
    with viewing(browser, rooms["sparse"], f"?paused=1&exact=1&width=320&height=200{subject}") as page:
        assert green(canvas_pixels(page)) > ROOM


def test_in_a_headset_the_room_fades_by_the_same_rule(browser: Browser, rooms: dict[str, Site]) -> None:
    """The eyes begin at the first camera, 2.5 m from the ball, and walk to between two cameras."""
    with headset_page(browser, rooms["sparse"], "paused=1&t=0.4&subject=0") as headset:
        headset.enter()
        assert min(green(255 * eye[..., :3]) for eye in headset.pictures()) > ROOM
        headset.look((2.165, 1.6, -1.25), np.pi / 3)
        headset.settle()
        for eye in headset.pictures():
            assert red(255 * eye[..., :3]) > 0.005
            assert eye[..., 1].max() < 0.5  # green that is left is that of the backdrop
