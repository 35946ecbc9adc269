"""The pictures of a headset's eyes from their own poses: the reference rasterizer's picture, and the head's order."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import pytest

from benchmarks.viewers.browser import psnr
from hgs_core.render import rasterize
from tests.web_client.conftest import Site
from tests.web_client.emulated_headset import headset_page
from tests.web_client.ordered_picture import moment, ordered_picture

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from hgs_core.scene.camera import Camera
    from tests.web_client.emulated_headset import Headset

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

EYE_PSNR = 45.0  # dB; pictures of headsets have 8 bits
CLEAR = 0.25  # metres from which on nothing fades

Position = tuple[float, float, float]
Image = npt.NDArray[np.float64]

STANDING: Position = (0.0, 1.6, 0.0)
HEADS = ((STANDING, 0.0, 0.0), ((0.4, 1.5, -0.3), 0.35, -0.2))


def reference_picture(site: Site, camera: Camera, backdrop: Image, seconds: float = 0.4) -> Image:
    """The picture of the decoded scene, [H, W, 3], antialiased as pictures of headsets always are, over a backdrop."""
    import torch

    scene = site.scene.map(lambda array: torch.tensor(array, dtype=torch.float64))
    segment = scene.segment_at(seconds)
    render = rasterize(
        scene.static,
        segment.dynamic,
        camera,
        segment.normalised(seconds),
        background=(0.0, 0.0, 0.0),
        backend="reference",
        gradients="none",
        antialiased=True,
    )
    picture: Image = render.rgb.permute(1, 2, 0).numpy() + (1 - render.alpha.numpy()[..., None]) * backdrop
    return picture


def eyes_see_the_reference_picture(headset: Headset, position: Position, yaw: float = 0.0, pitch: float = 0.0) -> None:
    """Each eye sees it from its own place, after beginning at the scene's first camera."""
    cameras = headset.cameras(headset.site.cameras[0], position, yaw, pitch)
    for eye, backdrop, camera in zip(headset.pictures(), headset.backdrops(), cameras, strict=True):
        assert psnr(eye[..., :3], reference_picture(headset.site, camera, backdrop)) >= EYE_PSNR


def expected(headset: Headset, position: Position, yaw: float = 0.0, pitch: float = 0.0) -> tuple[Image, Image]:
    """Both eyes' pictures, the splats in the order of their distance from the middle of the head."""
    site = headset.site
    left, right = headset.cameras(site.cameras[0], position, yaw, pitch)
    centre = (left.position + right.position) / 2
    splats = moment(site.scene, 0.4)
    clear = CLEAR * headset.scene_from_room(site.cameras[0])[1]
    one, other = (
        ordered_picture(splats, camera, centre, backdrop, clear=clear)
        for camera, backdrop in zip((left, right), headset.backdrops(), strict=True)
    )
    return one, other


def eyes_see_what_is_expected(headset: Headset, position: Position, yaw: float = 0.0, pitch: float = 0.0) -> None:
    headset.look(position, yaw, pitch)
    headset.settle()
    for eye, truth in zip(headset.pictures(), expected(headset, position, yaw, pitch), strict=True):
        assert psnr(eye[..., :3], truth) >= EYE_PSNR


def test_both_eyes_see_the_reference_picture(browser: Browser, dust: Site) -> None:
    """Of splats so small that the order by distance is nearly the one by depth."""
    with headset_page(browser, dust) as headset:
        headset.enter()
        for position, yaw, pitch in HEADS:
            headset.look(position, yaw, pitch)
            headset.settle()
            eyes_see_the_reference_picture(headset, position, yaw, pitch)
            assert all(np.all(eye[..., 3] == 1) for eye in headset.pictures())


def test_large_splats_lie_in_the_order_of_their_distance_from_the_head(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.enter()
        for position, yaw, pitch in HEADS:
            eyes_see_what_is_expected(headset, position, yaw, pitch)


def test_splats_fade_before_an_eye_that_is_among_them(browser: Browser, site: Site) -> None:
    with headset_page(browser, site) as headset:
        headset.enter()
        eyes_see_what_is_expected(headset, (0.0, 1.6, -2.2))
