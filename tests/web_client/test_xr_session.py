"""Entering a headset, its frames, its controls, and coming back to the page."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest

from benchmarks.viewers.browser import canvas_pixels, open_viewer, psnr
from tests.web_client.emulated_headset import headset_page, rotation
from tests.web_client.test_xr_pictures import EYE_PSNR, STANDING, eyes_see_the_reference_picture

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from tests.web_client.conftest import Site
    from tests.web_client.emulated_headset import Doubles, Headset

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

PLAYING = "paused=0&t=0.1"

PANEL = np.array([0.0, 1.6 - 0.35, -0.8])  # the middle of the panel before a head at STANDING
TILT = math.atan2(0.35, 0.8)
SIZE = (0.64, 0.2)  # metres
PICTURE = (1024, 320)  # pixels


def aim_at_panel(headset: Headset, x: float, y: float, yaw: float = 0.0) -> None:
    """Let the right controller point at a pixel of the panel's picture, straight on from 30 cm away.

    The panel is before a head at STANDING that has turned to its left by `yaw`, radians.
    """
    axes = rotation(yaw, -TILT)
    middle = rotation(yaw) @ (PANEL - STANDING) + STANDING
    right = SIZE[0] * (x / PICTURE[0] - 0.5)
    up = SIZE[1] * (0.5 - y / PICTURE[1])
    headset.aim(middle + axes @ [right, up, 0.3], yaw, -TILT)


def look_again(headset: Headset) -> None:
    """Show the panel as when the session began: it went away when the frames settled."""
    headset.look(STANDING)
    headset.hold("squeeze", "left")
    headset.hold("squeeze", "left", down=False)


def test_a_page_without_a_headset_offers_none(browser: Browser, site: Site) -> None:
    with open_viewer(browser, f"{site.page}?paused=1", width=800, height=500) as page:
        page.evaluate("() => navigator.xr?.isSessionSupported('immersive-vr')")
        assert page.get_by_role("button", name="Show in").count() == 0


def test_both_kinds_are_offered_where_the_headset_has_them(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.page.get_by_role("button", name="Show in the headset").wait_for()
        headset.page.get_by_role("button", name="Show in this room").wait_for()


REFUSALS = {
    "NotAllowedError": "did not allow this page to use the headset",
    "NotSupportedError": "cannot show the scene",
    "InvalidStateError": "is in use",
    "AbortError": "could not be started",
}


def test_a_refusal_is_told_in_plain_words_and_the_page_goes_on(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        page = headset.page
        before = canvas_pixels(page)
        for refusal, words in REFUSALS.items():
            page.evaluate("(name) => { headset.refusal = name; }", refusal)
            page.get_by_role("button", name="Show in the headset").click()
            page.get_by_role("alert").filter(has_text=words).wait_for()
            page.evaluate("() => { headset.refusal = null; return hgs.seek(0.4); }")
            assert np.array_equal(canvas_pixels(page), before)
        headset.enter()
        assert page.get_by_role("alert").filter(has_text=words).count() == 0


def test_a_headset_that_fails_after_all_is_left(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        page = headset.page
        page.evaluate("() => { XRSession.prototype.requestReferenceSpace = () => Promise.reject(new Error('none')); }")
        page.get_by_role("button", name="Show in the headset").click()
        page.get_by_role("alert").filter(has_text="could not be started").wait_for()
        assert page.evaluate("() => headset.session === null && hgs.seek(0.4).then(() => true)")


def test_every_frame_is_drawn_for_both_eyes_while_the_order_is_late(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.enter()
        draws = headset.page.evaluate(
            """() => Array.from({ length: 20 }, (_, i) => {
              headset.device.position.x = 0.01 * i;
              return headset.frame(); // in one task, so that no answer of the worker can come in between
            })"""
        )
        assert draws == [2] * 20


def test_the_order_is_never_older_than_a_frame_if_the_worker_keeps_up(browser: Browser, site: Site) -> None:
    with headset_page(browser, site, PLAYING) as headset:
        headset.enter()
        ages = headset.page.evaluate(
            """async () => {
              const ages = [];
              for (let i = 0; i < 20; i++) {
                headset.device.position.x = 0.01 * i;
                headset.skip(11);
                headset.frame();
                ages.push(headset.frames - headset.orderOf); // of the order that was drawn
                await headset.answered();
              }
              return ages;
            }"""
        )
        assert ages == [1] * 20


def test_what_is_near_lies_farther_to_the_right_for_the_left_eye(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.enter()
        left, right = (
            eye[..., :3] - backdrop for eye, backdrop in zip(headset.pictures(), headset.backdrops(), strict=True)
        )
        ahead = [camera.cx for camera in headset.cameras(site.cameras[0], STANDING)]

        def middle(cloud: Doubles) -> float:
            weight = np.abs(cloud).sum(axis=(0, 2))
            return float(weight @ (np.arange(headset.width) + 0.5) / weight.sum())

        disparity = (middle(left) - ahead[0]) - (middle(right) - ahead[1])
        focal = headset.width / 1.5
        # The cloud reaches from 1.5 m to 3.5 m before the eyes.
        assert focal * 0.064 / 3.5 < disparity < focal * 0.064 / 1.5


def test_where_the_room_is_seen_behind_the_scene_alpha_says_how_much(browser: Browser, dust: Site) -> None:
    import torch

    from hgs_core.render import rasterize

    scene = dust.scene.map(lambda array: torch.tensor(array, dtype=torch.float64))
    segment = scene.segment_at(0.4)
    with headset_page(browser, dust) as headset:
        headset.enter("Show in this room")
        for eye, camera in zip(headset.pictures(), headset.cameras(dust.cameras[0], STANDING), strict=True):
            truth = rasterize(
                scene.static,
                segment.dynamic,
                camera,
                segment.normalised(0.4),
                background=(0.0, 0.0, 0.0),
                backend="reference",
                gradients="none",
                antialiased=True,
            )
            assert psnr(eye[..., :3], truth.rgb.permute(1, 2, 0).numpy()) >= EYE_PSNR  # multiplied by alpha
            assert psnr(eye[..., 3], truth.alpha.numpy()) >= EYE_PSNR
            assert eye[0, 0, 3] == 0


def test_without_tracking_nothing_is_drawn_until_it_is_back(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.enter()
        headset.page.evaluate("() => { headset.tracking = false; }")
        assert [headset.frame() for _ in range(3)] == [0, 0, 0]
        headset.page.evaluate("() => { headset.tracking = true; }")
        assert headset.frame() == 2


@pytest.mark.parametrize("state", ["hidden", "visible-blurred"])
def test_the_scene_waits_while_the_headset_does_not_show_it(browser: Browser, site: Site, state: str) -> None:
    with headset_page(browser, site, PLAYING) as headset:
        headset.enter()

        def playing(visibility: str) -> bool:
            headset.page.evaluate("(state) => headset.device.updateVisibilityState(state)", visibility)
            headset.frame()
            headset.frame()
            return bool(headset.page.evaluate("() => hgs.state.playing"))

        assert not playing(state)
        assert playing("visible")


def left_by_the_system(headset: Headset) -> None:
    headset.page.evaluate("() => headset.session.end()")


def left_by_button(headset: Headset) -> None:
    headset.press("b-button")


def left_by_panel(headset: Headset) -> None:
    look_again(headset)
    aim_at_panel(headset, 934, 226)
    headset.frame()
    headset.press("trigger")


def left_by_the_page(headset: Headset) -> None:
    # The emulator covers the page with the headset's picture.
    headset.page.get_by_role("button", name="Leave the headset").first.dispatch_event("click")


@pytest.mark.parametrize(
    "leave",
    [
        left_by_the_system,
        *(pytest.param(leave, marks=pytest.mark.slow) for leave in (left_by_button, left_by_panel, left_by_the_page)),
    ],
)
def test_leaving_brings_the_page_back(browser: Browser, site: Site, leave: Callable[[Headset], None]) -> None:
    with headset_page(browser, site) as headset:
        page = headset.page
        before = canvas_pixels(page)
        headset.enter()
        headset.look((0.5, 1.6, 0.5))
        leave(headset)
        page.wait_for_function("() => headset.session === null")
        page.evaluate("() => hgs.seek(0.4)")
        assert np.array_equal(canvas_pixels(page), before)
        page.keyboard.press("Shift+ArrowLeft")
        while np.array_equal(canvas_pixels(page), before):  # the first key is obeyed once what it loads is there
            page.wait_for_timeout(50)
        headset.enter()
        assert headset.frame() == 2


def test_a_button_plays_and_pauses(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.enter()
        headset.press("a-button")
        assert headset.page.evaluate("() => hgs.state.playing")
        headset.press("x-button", "left")
        assert not headset.page.evaluate("() => hgs.state.playing")


def test_the_panel_plays_and_seeks(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.enter()
        without = headset.pictures()[0]
        look_again(headset)
        assert not np.array_equal(headset.pictures()[0], without)
        aim_at_panel(headset, 92, 92)
        headset.frame()
        headset.press("trigger")
        assert headset.page.evaluate("() => hgs.state.playing")
        headset.press("trigger")
        assert not headset.page.evaluate("() => hgs.state.playing")
        aim_at_panel(headset, 208 + 776 / 4, 66)
        headset.frame()
        headset.hold("trigger")
        assert headset.page.evaluate("() => hgs.state.time") == pytest.approx(0.5, abs=0.01)
        aim_at_panel(headset, 208 + 776 * 3 / 4, 300)  # the drag leaves the bar
        headset.frame()
        headset.hold("trigger", down=False)
        assert headset.page.evaluate("() => hgs.state.time") == pytest.approx(1.5, abs=0.01)


def test_the_left_stick_moves_the_playhead(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.enter()
        headset.page.evaluate(
            """() => {
              headset.device.controllers.left.updateAxes("thumbstick", 1, 0);
              for (let i = 0; i < 3; i++) {
                headset.skip(1000); // a step is of a tenth of a second at most
                headset.frame();
              }
            }"""
        )
        # A quarter of two seconds each second, and the stick counts from the second frame on that has it.
        assert headset.page.evaluate("() => hgs.state.time") in (
            pytest.approx(0.4 + 2 * 0.05, abs=0.002),
            pytest.approx(0.4 + 3 * 0.05, abs=0.002),
        )


def test_a_flick_of_the_right_stick_turns_the_viewer(browser: Browser, dust: Site) -> None:
    head = (0.3, 1.6, -0.2)
    with headset_page(browser, dust) as headset:
        headset.enter()
        headset.look(head)
        headset.frame()
        headset.page.evaluate(
            """() => {
              for (const x of [0, 1, 1, 1, 0]) {
                headset.device.controllers.right.updateAxes("thumbstick", x, 0);
                headset.frame();
                headset.frame();
              }
            }"""
        )
        headset.settle()
        eyes_see_the_reference_picture(headset, head, yaw=-math.pi / 6)  # once to the right


def test_a_hand_moves_the_scene_and_the_panel_brings_it_back(browser: Browser, dust: Site) -> None:
    with headset_page(browser, dust) as headset:
        headset.enter()
        before = headset.pictures()[0]
        headset.aim(np.array([0.2, 1.2, -0.3]))
        headset.hold("squeeze")
        headset.aim(np.array([0.4, 1.3, -0.6]))
        headset.frame()
        headset.hold("squeeze", down=False)
        headset.aim(np.array([0.2, 1.2, -0.3]))  # not holding
        headset.settle()
        eyes_see_the_reference_picture(headset, (-0.2, 1.5, 0.3))  # equal to a head moved the other way
        look_again(headset)
        aim_at_panel(headset, 174, 226)
        headset.frame()
        headset.press("trigger")
        headset.aim(np.array([0.2, 1.2, 1.0]))
        headset.settle()
        assert np.array_equal(headset.pictures()[0], before)


def test_a_pinching_hand_moves_the_scene(browser: Browser, dust: Site) -> None:
    with headset_page(browser, dust) as headset:
        headset.page.evaluate("() => { headset.device.primaryInputMode = 'hand'; }")
        headset.enter()
        headset.page.evaluate(
            """() => {
              const hand = headset.device.hands.right;
              const frames = () => { headset.frame(); headset.frame(); };
              hand.position.set(0.2, 1.2, -0.3);
              frames();
              hand.updatePinchValue(1);
              frames();
              hand.position.set(0.1, 1.25, -0.5);
              frames();
              hand.updatePinchValue(0);
              frames();
              hand.position.set(0.3, 1.2, -0.3); // without pinching
              frames();
            }"""
        )
        headset.settle()
        eyes_see_the_reference_picture(headset, (0.1, 1.55, 0.2))  # equal to a head moved the other way


@pytest.mark.slow
def test_pictures_become_coarser_while_frames_are_late_and_finer_again(browser: Browser, site: Site) -> None:
    with headset_page(browser, site, size=(32, 32)) as headset:
        # The test's own clock alone, so that a busy machine makes no frame late.
        headset.page.evaluate(
            "() => { let time = 0; performance.now = () => time; headset.skip = (ms) => (time += ms); }"
        )
        headset.enter()

        def drawn(frames: int, interval: float) -> list[int]:
            size: list[int] = headset.page.evaluate(
                """([frames, interval]) => {
                  for (let i = 0; i < frames; i++) {
                    headset.skip(interval);
                    headset.frame();
                  }
                  return headset.drawn;
                }""",
                [frames, interval],
            )
            return size

        assert drawn(100, 1000 / 72) == [32, 32]
        assert drawn(72 * 2, 2000 / 72)[0] < 32
        assert drawn(72 * 14, 1000 / 72) == [32, 32]


def test_fewer_splats_are_drawn_while_frames_are_late_all_the_same(browser: Browser, site: Site) -> None:
    with headset_page(browser, site, size=(32, 32)) as headset:
        page = headset.page
        page.evaluate("() => { let time = 0; performance.now = () => time; headset.skip = (ms) => (time += ms); }")
        headset.enter()
        budgets = []
        for _ in range(5):
            page.evaluate("() => { for (let i = 0; i < 72; i++) { headset.skip(2000 / 72); headset.frame(); } }")
            page.evaluate("() => headset.answered()")
            budgets.append(page.evaluate("() => { headset.frame(); return headset.budget; }"))
            page.evaluate("() => headset.answered()")
        assert budgets == [math.inf, math.inf, math.inf, 200_000, 100_000]


def test_both_eyes_draw_the_splats_that_the_page_has_a_budget_for(browser: Browser, site: Site) -> None:
    with headset_page(browser, site, "paused=1&t=0.4&splats=1000") as headset:
        headset.enter()
        assert headset.frame() == 2
        assert 900 < headset.page.evaluate("() => hgs.state.splats") <= 1000


def test_a_lost_context_comes_back_in_the_headset(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.enter()
        before = headset.pictures()[0]
        draws = headset.page.evaluate(
            """async () => {
              const { context: gl } = headset.session.renderState.baseLayer;
              const lose = gl.getExtension("WEBGL_lose_context");
              const event = (name) => new Promise((done) => gl.canvas.addEventListener(name, done, { once: true }));
              const lost = event("webglcontextlost");
              lose.loseContext();
              await lost;
              await new Promise((resolve) => setTimeout(resolve)); // until the event has been dealt with
              const meanwhile = headset.frame();
              const restored = event("webglcontextrestored");
              lose.restoreContext();
              await restored;
              await headset.entered();
              return meanwhile;
            }"""
        )
        assert draws == 0
        headset.settle()
        assert np.array_equal(headset.pictures()[0], before)
