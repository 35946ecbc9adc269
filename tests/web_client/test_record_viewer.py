"""The film of the viewer: time and camera are set frame by frame."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image

from benchmarks.viewers.browser import open_viewer
from scripts import record_viewer
from scripts.record_viewer import film, write_webp

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from tests.web_client.conftest import Site


@pytest.mark.browser
@pytest.mark.timeout(120)
@pytest.mark.slow
def test_a_film_shows_every_time_from_another_place_and_is_the_same_each_time(
    site: Site, browser: Browser, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(record_viewer, "_RATE", 2)

    def recorded() -> list[Image.Image]:
        width, height = record_viewer._SIZE
        with open_viewer(browser, f"{site.page}?paused=1&camera=side", width=width, height=height) as page:
            frames = list(film(page, site.start, site.end))
            assert page.evaluate("() => window.hgs.quality") == "high"  # or pictures were as coarse as the machine slow
            return frames

    first, again = recorded(), recorded()
    plays = round((site.end - site.start) * 2)
    assert len(first) == plays * 2
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert len({frame.tobytes() for frame in first}) == len(first)  # the second play is seen from elsewhere


def test_the_animation_is_endless_and_keeps_its_frames(tmp_path: Path) -> None:
    frames = [Image.new("RGB", (32, 24), (shade, 0, 0)) for shade in (0, 120, 240)]
    size = write_webp(tmp_path / "new" / "film.webp", frames, 60)
    assert size == (tmp_path / "new" / "film.webp").stat().st_size
    with Image.open(tmp_path / "new" / "film.webp") as film_read:
        assert film_read.n_frames == 3
        assert film_read.info["loop"] == 0
