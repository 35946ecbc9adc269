"""Many players on one page: more than a browser has graphics contexts for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from tests.web_client.test_embedding import SCRIPT, STOOD, embedding, host, pixels, wait_for_picture

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.test_embedding import Host

__all__ = ["host"]

pytestmark = [pytest.mark.browser, pytest.mark.timeout(240)]

GRID = (
    "<style>body { margin: 0; display: grid; grid-template-columns: repeat(4, 190px); gap: 8px }"
    "hgs-player { width: 190px; height: 190px }</style>"
)
IN_SIGHT = """() => [...document.querySelectorAll("hgs-player")].filter((one) => {
  const { top, bottom } = one.getBoundingClientRect();
  return bottom > 0 && top < innerHeight;
})"""
PICTURED = f"() => ({IN_SIGHT})().every(({{ player }}) => player?.statistics?.firstFrame != null)"
DRAWN = f"""() => ({IN_SIGHT})().every(({{ shadowRoot }}) => {{
  const [canvas, kept] = shadowRoot.querySelectorAll(".stage canvas");
  return canvas && !kept && !canvas.getContext("webgl2").isContextLost();
}})"""
CONTEXTS = """() => [...document.querySelectorAll("hgs-player")]
  .map(({ shadowRoot }) => shadowRoot.querySelector(".stage canvas")?.getContext("webgl2"))
  .filter((gl) => gl && !gl.isContextLost()).length"""
LOSE = """(name) => {
  const canvas = document.getElementById(name).shadowRoot.querySelector(".stage canvas");
  window.loss = canvas.getContext("webgl2").getExtension("WEBGL_lose_context");
  loss.loseContext();
}"""


def gallery(count: int, attributes: str = "") -> str:
    return (
        GRID + SCRIPT + "".join(f'<hgs-player id="p{i}" src="clouds/" {attributes}></hgs-player>' for i in range(count))
    )


def problems(page: Page) -> list[str]:
    """The problems reported by players; filled while the page is used."""
    found: list[str] = []
    page.on("console", lambda line: found.append(line.text) if line.type in ("error", "warning") else None)
    return found


@pytest.mark.parametrize("count", [20, pytest.param(40, marks=pytest.mark.slow)])
def test_a_gallery_that_is_scrolled_through_draws_whatever_is_in_sight(
    browser: Browser, host: Host, count: int
) -> None:
    """Those out of sight give their contexts back, keep their pictures, and draw again at the same time."""
    with embedding(browser, host, "", viewport={"width": 800, "height": 560}) as page:  # three rows of four
        found = problems(page)
        (host.folder / "index.html").write_text('<link rel="icon" href="data:,">' + gallery(count))
        page.reload()
        page.wait_for_function("() => customElements.get('hgs-player')")
        page.wait_for_function(PICTURED)
        page.evaluate("() => p0.player.seek(0.8)")
        before = pixels(page, "p0")
        for row in range(0, count // 4, 2):
            page.evaluate("(y) => scrollTo({ top: y, behavior: 'instant' })", 198 * row)
            page.wait_for_function(PICTURED)
            assert page.evaluate(CONTEXTS) <= 14
        page.wait_for_function(
            "() => p0.shadowRoot.querySelectorAll('.stage canvas').length === 2"
        )  # its picture is kept
        assert page.evaluate("() => p0.shadowRoot.querySelector('.stage canvas').getContext('webgl2').isContextLost()")
        assert (pixels(page, "p0") == before).mean() > 0.99
        page.evaluate("() => scrollTo({ top: 0, behavior: 'instant' })")
        page.wait_for_function(DRAWN)
        page.evaluate(STOOD, "p0")
        assert page.evaluate("() => p0.currentTime") == 0.8
        assert (pixels(page, "p0") == before).all()
        assert page.get_by_role("alert").filter(visible=True).count() == 0
        assert found == []


def test_of_more_in_sight_than_there_are_contexts_one_that_stands_aside_can_be_pressed(
    browser: Browser, host: Host
) -> None:
    small = GRID.replace("190px", "150px").replace("repeat(4", "repeat(5")
    body = gallery(20, "autoplay loop").replace(GRID, small)
    with embedding(browser, host, body, viewport={"width": 800, "height": 700}) as page:
        found = problems(page)
        page.wait_for_function(PICTURED)
        aside = "() => [...document.querySelectorAll('hgs-player')].filter((one) => one.player.statistics.setAside)"
        page.wait_for_function(f"() => ({aside})().length === 6")
        before = page.evaluate(f"() => ({aside})().map(({{ id }}) => id)")  # scenes arrive in any order
        pressed = before[0]
        said = page.locator(f"#{pressed}").get_by_text("Press to play this one instead.").bounding_box()
        assert said
        page.mouse.click(said["x"] + 5, said["y"] + 5)
        playing = f"!{pressed}.paused && !{pressed}.player.statistics.setAside && {pressed}.currentTime > 0"
        page.wait_for_function(f"() => {playing}")
        page.wait_for_function(f"() => ({aside})().length === 6")
        after = page.evaluate(f"() => ({aside})().map(({{ id }}) => id)")
        (other,) = set(after) - set(before)
        assert set(after) == {*before, other} - {pressed}
        assert page.evaluate(f"() => {other}.paused")
        assert page.evaluate(CONTEXTS) <= 14
        assert page.get_by_role("alert").filter(visible=True).count() == 0
        assert found == []


def test_a_player_out_of_sight_still_answers_its_page(browser: Browser, host: Host) -> None:
    """Loading, seeking and pictures keep their promises out of sight."""
    body = SCRIPT + '<p style="height: 3000px">Text</p><hgs-player id="p0" src="clouds/" camera="side"></hgs-player>'
    with embedding(browser, host, body) as page:
        wait_for_picture(page, "p0")
        page.wait_for_function("() => p0.shadowRoot.querySelectorAll('.stage canvas').length === 2")
        first = pixels(page, "p0")
        page.evaluate("() => p0.player.seek(1.4)")
        page.wait_for_function("() => p0.shadowRoot.querySelectorAll('.stage canvas').length === 2")
        assert (pixels(page, "p0") == first).mean() < 0.9
        assert page.evaluate("async () => (await p0.player.screenshot()).type") == "image/png"


@pytest.mark.parametrize("when", ["before its scene is known", "while it plays"])
def test_a_context_that_is_taken_away_is_called_lost_and_comes_back(browser: Browser, host: Host, when: str) -> None:
    held: list[Any] = []
    early = when.startswith("before")
    with embedding(browser, host, "") as page:
        found = problems(page)
        if early:
            page.route("**/index.hgs", lambda route: held.append(route))
            page.route("**/manifest.json", lambda route: held.append(route))
        (host.folder / "index.html").write_text(
            '<link rel="icon" href="data:,">' + SCRIPT + '<hgs-player id="p0" src="clouds/" camera="side"></hgs-player>'
        )
        page.reload()
        if early:
            page.wait_for_function("() => window.p0?.shadowRoot?.querySelector('.stage canvas')")
        else:
            wait_for_picture(page, "p0")
        page.evaluate(LOSE, "p0")
        page.wait_for_function("() => p0.player.statistics.contextLost")
        page.get_by_text("The graphics card was reset. One moment…").wait_for()
        for route in held:
            route.continue_()
        page.unroute_all()
        if early:
            page.wait_for_function("() => p0.player.manifest && p0.player.statistics.complete")
        assert page.get_by_role("alert").filter(visible=True).count() == 0
        page.evaluate("() => loss.restoreContext()")
        wait_for_picture(page, "p0")
        assert len({tuple(pixel) for pixel in pixels(page, "p0").reshape(-1, 4)[::97]}) > 20
        assert [line for line in found if "null" in line or "device holds" in line] == []
