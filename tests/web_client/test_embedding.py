"""The player in pages of others: the element and the module, from plain web servers, beside other players."""

from __future__ import annotations

import shutil
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from benchmarks.viewers.browser import canvas_pixels, open_viewer, psnr
from hgs_core.codec.format.scene_folder import load_manifest
from server.publishing.web_bucket import publish_to_bucket
from server.publishing.web_folder import publish_to_folder
from tests.jobs.modules.s3_server import running_s3_server
from tests.server.publishing.test_web_bucket import let_all_read
from tests.web_client.conftest import HEIGHT, REPOSITORY, WIDTH, serving
from tests.web_client.test_console_pages import violations

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(180)]

PLAYER = REPOSITORY / "server" / "viewer" / "player"
HEAD = (
    '<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
    '<title>A page</title><link rel="icon" href="data:,">'
)
SCRIPT = '<script type="module" src="player/hgs-player.js"></script>'
COMMANDS = "/player/commands.js"
READY = "(id) => new Promise((resolve) => document.getElementById(id).addEventListener('ready', resolve))"
STOOD = "(id) => document.getElementById(id).player.seek(document.getElementById(id).currentTime)"


@dataclass
class Host:
    """A folder on a web server that knows nothing of scenes."""

    folder: Path
    address: str
    requests: list[str] = field(default_factory=list)
    missing: set[str] = field(default_factory=set)  # names of files that it does not have
    damaged: set[str] = field(default_factory=set)  # names of files of which the first answer has a wrong byte


class Files(SimpleHTTPRequestHandler):
    """Any origin may read the files."""

    def __init__(self, *arguments: Any, host: Host, **options: Any) -> None:
        self.host = host
        super().__init__(*arguments, directory=str(host.folder), **options)

    def do_GET(self) -> None:
        name = self.path.rpartition("/")[2]
        self.host.requests.append(self.path)
        if name in self.host.missing:
            self.send_error(404)
        elif name in self.host.damaged:
            self.host.damaged.discard(name)
            body = bytearray((self.host.folder / self.path.lstrip("/")).read_bytes())
            body[100] ^= 1
            self.send_response(200)
            self.send_header("Content-Length", str(len(body)))
            self.end_headers()
            self.wfile.write(body)
        else:
            super().do_GET()

    def end_headers(self) -> None:
        self.send_header("Access-Control-Allow-Origin", "*")
        self.send_header("Cache-Control", "no-store")
        super().end_headers()

    def log_message(self, *arguments: Any) -> None:
        pass


@contextmanager
def hosting(folder: Path) -> Iterator[Host]:
    host = Host(folder, "")
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Files, host=host))
    host.address = f"http://127.0.0.1:{server.server_port}"
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield host
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


@pytest.fixture
def host(site: Site, tmp_path: Path) -> Iterator[Host]:
    """The clouds in `clouds/` as `hgs publish --to` writes them, and the player."""
    if not (PLAYER / "hgs-player.js").is_file():
        pytest.skip("the player is not built: run npm ci && npm run build in web_client")
    folder = tmp_path / "host"
    shutil.copytree(site.folder, folder / "clouds")
    shutil.copytree(PLAYER, folder / "player")
    with hosting(folder) as served:
        yield served


@contextmanager
def embedding(browser: Browser, host: Host, body: str, path: str = "index.html", **options: Any) -> Iterator[Page]:
    """A page of the host with that in it, opened."""
    (host.folder / path).write_text(HEAD + body)
    context = browser.new_context(**({"viewport": {"width": 800, "height": 600}} | options))
    try:
        page = context.new_page()
        page.goto(f"{host.address}/{path}")
        yield page
    finally:
        context.close()


def player(attributes: str, name: str = "one", width: int = WIDTH, height: int = HEIGHT) -> str:
    style = f"width: {width}px; height: {height}px"
    return f'<hgs-player id="{name}" src="clouds/manifest.json" style="{style}" {attributes}></hgs-player>'


def wait_for_picture(page: Page, name: str = "one") -> None:
    """Wait until the picture at the playhead is complete."""
    page.wait_for_function("(id) => document.getElementById(id).player?.manifest", arg=name)
    page.evaluate(STOOD, name)


def pixels(page: Page, name: str = "one") -> np.ndarray:
    page.evaluate("(id) => { window.hgs = document.getElementById(id).player }", name)
    return canvas_pixels(page)


def view_of(page: Page, name: str) -> Any:
    return page.evaluate("(id) => document.getElementById(id).player.camera.view", name)


@pytest.fixture
def served_picture(browser: Browser, site: Site) -> np.ndarray:
    """The clouds from the side at 0.4 s as the server's own page shows them."""
    address = f"{site.page}?camera=side&t=0.4&width={WIDTH}&height={HEIGHT}&paused=1&exact=1"
    with open_viewer(browser, address, width=WIDTH, height=HEIGHT) as page:
        return canvas_pixels(page)


def test_a_folder_that_hgs_publish_writes_plays_by_itself(browser: Browser, site: Site, tmp_path: Path) -> None:
    publish_to_folder(site.folder.parent, tmp_path / "site", player=PLAYER)
    context = browser.new_context(viewport={"width": 800, "height": 600})
    with hosting(tmp_path / "site") as host:
        try:
            page = context.new_page()
            page.goto(host.address)
            page.wait_for_function("() => document.querySelector('hgs-player').currentTime > 0.1")
            size = "({ player }) => [player.width, player.height]"
            assert page.locator("hgs-player").evaluate(size) == [800, 600]
            assert page.get_by_role("button", name="Pause").is_visible()
        finally:
            context.close()
    assert len(host.requests) == len(set(host.requests))


def test_a_bucket_that_hgs_publish_fills_plays_by_itself_and_in_a_page_of_another_origin(
    browser: Browser, site: Site, served_picture: np.ndarray, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with running_s3_server() as server:
        for name, value in server.settings.items():
            monkeypatch.setenv(name, value)
        publish_to_bucket(site.folder.parent, "s3://bucket/scene", player=PLAYER)
        let_all_read(server, "s3://bucket/scene")
        address = f"{server.address}/bucket/scene"
        context = browser.new_context(viewport={"width": 800, "height": 600})
        try:
            page = context.new_page()
            page.goto(f"{address}/index.html")
            page.wait_for_function("() => document.querySelector('hgs-player').currentTime > 0.1")
        finally:
            context.close()
        script = SCRIPT.replace("player/", f"{address}/player/")
        element = player('time="0.4" camera="side"').replace("clouds/", f"{address}/")
        (tmp_path / "page").mkdir()
        with hosting(tmp_path / "page") as page_host, embedding(browser, page_host, script + element) as other:
            wait_for_picture(other)
            assert np.array_equal(pixels(other), served_picture)


def test_a_page_of_another_origin_takes_player_and_scene_from_a_cdn(
    browser: Browser, host: Host, served_picture: np.ndarray, tmp_path: Path
) -> None:
    (tmp_path / "page").mkdir()
    script = SCRIPT.replace("player/", f"{host.address}/player/")
    element = player('time="0.4" camera="side"').replace("clouds/", f"{host.address}/clouds/")
    with hosting(tmp_path / "page") as page_host, embedding(browser, page_host, script + element) as page:
        wait_for_picture(page)
        assert np.array_equal(pixels(page), served_picture)
        assert [path for path in page_host.requests if path != "/index.html"] == []
    loaded = [path for path in host.requests if path.startswith("/player/")]
    assert sorted(loaded) == ["/player/hgs-player.js", "/player/worker.js", "/player/zstd.wasm"]
    assert sum(Path(f"{PLAYER.parent}{path}.br").stat().st_size for path in loaded) <= 45_000


def test_a_part_that_cannot_be_loaded_is_told_and_the_scene_plays_on(browser: Browser, host: Host) -> None:
    host.missing.add("commands.js")
    with embedding(browser, host, SCRIPT + player("controls"), reduced_motion="reduce") as page:
        wait_for_picture(page)
        page.locator(".stage").focus()
        page.keyboard.press("k")
        page.get_by_text("A part of the player could not be loaded. Reloading the page may help.").wait_for()
        page.get_by_role("button", name="Play").click()
        page.wait_for_function("() => !one.paused")


def test_a_page_of_another_origin_takes_player_and_stream_from_a_server(
    browser: Browser, site: Site, served_picture: np.ndarray, tmp_path: Path
) -> None:
    for folder in ("page", "home"):
        (tmp_path / folder).mkdir()
    with hosting(tmp_path / "page") as page_host:
        options = ("--allow-origin", page_host.address)
        with serving([site.folder.parent], tmp_path / "home", *options) as [scene]:
            script = SCRIPT.replace("player/", f"{scene.partition('/view/')[0]}/player/")
            element = player('time="0.4" camera="side"').replace("clouds/manifest.json", scene)
            with embedding(browser, page_host, script + element) as page:
                wait_for_picture(page)
                assert np.array_equal(pixels(page), served_picture)


def test_players_on_one_page_obey_their_own_keys_and_wheel(browser: Browser, host: Host) -> None:
    """The keys of the one that was clicked last, and no wheel before a click: it scrolls the page."""
    body = SCRIPT + player("controls") + player("controls", "two") + '<p style="height: 3000px">Text</p>'
    with embedding(browser, host, body, reduced_motion="reduce") as page:
        for name in ("one", "two"):
            wait_for_picture(page, name)
        before = {name: view_of(page, name) for name in ("one", "two")}
        page.keyboard.press("Shift+ArrowLeft")
        assert {name: view_of(page, name) for name in ("one", "two")} == before
        assert COMMANDS not in host.requests

        page.mouse.move(100, 80)
        page.mouse.wheel(0, 60)
        page.wait_for_function("() => scrollY > 0")
        assert view_of(page, "one") == before["one"]
        page.evaluate("() => scrollTo({ top: 0, behavior: 'instant' })")

        page.locator("#two .stage").click(position={"x": 100, "y": 60})
        page.keyboard.press("Shift+ArrowLeft")
        page.wait_for_function("(x) => two.player.camera.view.position[0] !== x", arg=before["two"]["position"][0])
        assert view_of(page, "one") == before["one"]
        page.wait_for_function("() => !two.paused")  # the click played it, and only it
        assert page.evaluate("() => one.paused")
        page.keyboard.press("k")
        assert page.evaluate("() => two.paused && one.paused")

        page.locator("#one .stage").click(position={"x": 100, "y": 60})
        page.mouse.wheel(0, 60)
        page.wait_for_function(
            "(before) => one.player.camera.view.position[2] !== before[2]", arg=before["one"]["position"]
        )
        assert page.evaluate("() => scrollY") == 0


def test_a_page_with_a_player_keeps_nobody_out(browser: Browser, host: Host) -> None:
    """As axe judges the page: nothing serious, with the settings open, too."""
    body = "<main><h1>Two scenes</h1>" + player("controls") + player("controls", "two") + "</main>" + SCRIPT
    with embedding(browser, host, body, reduced_motion="reduce") as page:
        for name in ("one", "two"):
            wait_for_picture(page, name)
        page.locator("#one").get_by_role("button", name="Settings").click()
        assert violations(page) == []


def test_the_element_is_as_a_video(browser: Browser, host: Host) -> None:
    """Attributes reflect; methods, properties and events are those of media elements."""
    script = """<script>
      window.heard = [];
      addEventListener("DOMContentLoaded", () => {
        for (const type of ["manifest", "ready", "play", "pause", "seeked", "ended", "ratechange", "error"])
          one.addEventListener(type, () => heard.push(type));
      });
    </script>"""
    with embedding(browser, host, script + SCRIPT + player('poster="clouds/thumbnail.jpg"')) as page:
        wait_for_picture(page)
        page.wait_for_function("() => heard.includes('ready')")
        state = "() => [one.paused, one.currentTime, one.duration, one.loop, one.controls, one.playbackRate, one.ended]"
        assert page.evaluate(state) == [True, 0, 2, False, False, 1, False]
        assert not page.locator("#one .transport").is_visible()
        page.evaluate("() => { one.controls = true; one.loop = true; one.playbackRate = 4 }")
        page.locator("#one .transport").wait_for()
        assert page.evaluate("() => [one.getAttribute('loop'), one.hasAttribute('controls')]") == ["", True]
        assert page.evaluate("() => one.player.loop")
        page.evaluate("() => { one.removeAttribute('loop'); one.currentTime = 1.9 }")
        page.evaluate(STOOD, "one")
        assert page.evaluate("() => one.currentTime") == 1.9
        page.evaluate("() => one.play()")
        page.wait_for_function("() => heard.includes('ended')")
        assert page.evaluate(state)[:3] == [True, 2, 2]
        assert page.evaluate("() => one.ended")
        told = page.evaluate("() => heard.filter((type) => type !== 'seeked')")
        assert told == ["manifest", "ready", "ratechange", "play", "pause", "ended"]
        assert (
            page.evaluate("() => { try { one.playbackRate = 0 } catch (error) { return error.name } }") == "RangeError"
        )


def test_an_element_that_a_script_makes_is_moved_taken_away_and_put_back(browser: Browser, host: Host) -> None:
    """Moved it goes on; taken away it gives everything back; put back it loads again."""
    body = SCRIPT + '<div id="here"></div><div id="there"></div>'
    with embedding(browser, host, body) as page:
        page.evaluate(
            """async () => {
              await customElements.whenDefined("hgs-player");
              const made = document.createElement("hgs-player");
              Object.assign(made, { id: "one", src: "clouds/", loop: true });
              window.loads = 0;
              made.addEventListener("loadstart", () => window.loads++);
              here.append(made);
            }"""
        )
        wait_for_picture(page)
        page.evaluate("() => there.append(one)")
        page.evaluate(STOOD, "one")
        assert page.evaluate("() => [loads, one.loop, one.player.manifest !== null]") == [1, True, True]
        page.evaluate("() => { window.kept = one; one.remove() }")
        page.wait_for_function("() => kept.player.manifest === null")
        page.evaluate("() => here.append(kept)")
        wait_for_picture(page)
        assert page.evaluate("() => loads") == 2


@pytest.mark.parametrize("playing", [False, True])
def test_an_element_that_is_put_back_later_goes_on_where_it_was(browser: Browser, host: Host, playing: bool) -> None:
    """Its time, whether it plays, and its camera; from elsewhere, it begins anew."""
    body = '<div id="here"></div><div id="there">' + player("autoplay loop") + "</div>"
    with embedding(browser, host, SCRIPT + body) as page:
        wait_for_picture(page)
        page.evaluate("() => one.pause()")
        page.evaluate("() => one.player.seek(0.8)")
        x = view_of(page, "one")["position"][0]
        page.evaluate("() => one.player.camera.turn(0.3, 0.1)")
        page.wait_for_function("(x) => one.player.camera.view.position[0] !== x", arg=x)
        view = view_of(page, "one")
        if playing:
            page.evaluate("() => { one.playbackRate = 0.01; one.play() }")
        page.evaluate("() => { window.kept = one; one.remove() }")
        page.wait_for_function("() => kept.player.manifest === null")
        assert page.evaluate("() => kept.currentTime") == pytest.approx(0.8, abs=0.05)
        page.evaluate("() => here.append(kept)")
        page.wait_for_function("() => one.player.manifest")
        page.wait_for_function("(playing) => one.paused !== playing", arg=playing)
        assert page.evaluate("() => one.currentTime") == pytest.approx(0.8, abs=0.1)
        assert np.allclose([*view_of(page, "one")["position"]], [*view["position"]], atol=1e-6)
        page.evaluate("() => one.remove()")
        page.wait_for_function("() => kept.player.manifest === null")
        page.evaluate("() => { kept.pause(); kept.src = 'clouds/manifest.json?other'; here.append(kept) }")
        page.wait_for_function("() => one.player.manifest")
        assert page.evaluate("() => one.currentTime") < 0.7


def test_elements_that_are_moved_at_once_go_on(browser: Browser, host: Host) -> None:
    """Into another order, as frameworks move keyed children, and into a document of its own and back."""
    body = "<div id='here'>" + player("") + player("", "two") + "</div><iframe srcdoc='<p>A frame</p>'></iframe>"
    count = (
        "() => { window.loads = 0; for (const p of [one, two]) p.addEventListener('loadstart', () => window.loads++) }"
    )
    with embedding(browser, host, SCRIPT + body) as page:
        for name in ("one", "two"):
            wait_for_picture(page, name)
        page.evaluate("() => one.player.seek(0.8)")
        page.evaluate(count)
        page.evaluate("() => { here.insertBefore(two, one); here.append(two); here.prepend(two) }")
        page.evaluate("() => one.player.seek(0.8)")
        frame = "document.querySelector('iframe').contentDocument"
        page.evaluate(f"() => {{ window.kept = one; {frame}.body.append(one) }}")
        page.evaluate("() => kept.player.seek(0.8)")
        place = "() => getComputedStyle(kept.shadowRoot.querySelector('.stage')).position"
        assert page.evaluate(place) == "absolute"  # it has its styles there, too
        page.evaluate("() => here.append(kept)")
        page.evaluate("() => kept.player.seek(0.8)")
        assert page.evaluate(place) == "absolute"
        assert page.evaluate("() => [loads, one.currentTime]") == [0, 0.8]


def test_a_page_that_asks_for_trusted_types_plays(browser: Browser, host: Host, served_picture: np.ndarray) -> None:
    policy = (
        "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'; "
        "img-src 'self'; style-src-attr 'unsafe-inline'; require-trusted-types-for 'script'; trusted-types hgs-player"
    )
    head = f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
    body = player('controls time="0.4" camera="side"') + player('time="0.4"', "two")
    with embedding(browser, host, head + SCRIPT + body) as page:
        for name in ("one", "two"):
            wait_for_picture(page, name)
        assert np.array_equal(pixels(page), served_picture)
        page.locator("#one").get_by_role("button", name="Settings").click()
        page.locator("#one").get_by_role("group", name="Settings").wait_for()
        assert page.get_by_role("alert").count() == 0


@pytest.mark.parametrize(
    "attributes", ["", "sandbox='allow-scripts'", "sandbox='allow-scripts' allow=\"fullscreen 'none'\""]
)
@pytest.mark.parametrize("where", ["folder", "server"])
def test_a_frame_writes_nothing_into_the_console_of_its_host(
    browser: Browser, host: Host, site: Site, tmp_path: Path, where: str, attributes: str
) -> None:
    """Without its host's permissions; the page in the frame is of another origin."""
    if where == "server" and attributes:
        pytest.skip("a server's pages play in frames of their own origin alone, as its policy says")
    (host.folder / "inner.html").write_text(HEAD + SCRIPT + player("controls autoplay", width=400, height=300))
    inner = f"{host.address}/inner.html" if where == "folder" else site.page
    (tmp_path / "page").mkdir()
    frame = f'<iframe name="inner" src="{inner}" width="500" height="400" {attributes}></iframe>'
    lines: list[str] = []
    with hosting(tmp_path / "page") as outer, embedding(browser, outer, "") as page:
        page.on("console", lambda line: lines.append(line.text) if line.type in ("error", "warning") else None)
        (outer.folder / "index.html").write_text(HEAD + frame)
        page.reload()
        found = page.frame("inner")
        assert found is not None
        time = "() => (window.hgs?.state.time ?? document.querySelector('hgs-player')?.currentTime) > 0"
        found.wait_for_function(time)
        found.get_by_role("button", name="Settings").wait_for()
        assert lines == []


def test_a_lost_line_is_told_at_once_and_until_something_comes(browser: Browser, host: Host) -> None:
    with embedding(browser, host, "") as page:
        page.route("**/chunks/*", lambda route: None)  # none of them ends
        (host.folder / "index.html").write_text(HEAD + SCRIPT + player(""))
        page.reload()
        page.get_by_text("Loading 0 B").wait_for()
        page.evaluate("() => dispatchEvent(new Event('offline'))")
        page.get_by_text("Connection lost. Trying again…").wait_for(timeout=4000)  # a request fails after 10 s
        page.unroute_all()
        page.evaluate("() => dispatchEvent(new Event('online'))")
        wait_for_picture(page)


def test_the_poster_is_shown_until_there_is_a_picture(browser: Browser, host: Host) -> None:
    names = [entry.id for entry in load_manifest(host.folder / "clouds").chunks]
    waiting = threading.Event()
    with embedding(browser, host, "") as page:
        page.route("**/chunks/*", lambda route: route.continue_() if waiting.is_set() else route.abort())
        (host.folder / "index.html").write_text(HEAD + SCRIPT + player('poster="clouds/thumbnail.jpg"'))
        page.reload()
        poster = page.locator("#one .poster")
        poster.wait_for()
        assert poster.evaluate("(image) => image.decode().then(() => image.naturalWidth)") == 64
        waiting.set()
        page.evaluate("() => dispatchEvent(new Event('online'))")
        poster.wait_for(state="hidden")
        wait_for_picture(page)
        assert len([path for path in host.requests if "/chunks/" in path]) == len(set(names))


def test_a_player_out_of_sight_stands_still_and_goes_on_when_it_is_seen(browser: Browser, host: Host) -> None:
    body = SCRIPT + player("autoplay loop") + '<p style="height: 3000px">Text</p>'
    with embedding(browser, host, body) as page:
        page.wait_for_function("() => one.player && !one.paused && one.currentTime > 0")
        page.evaluate("() => scrollTo(0, 2000)")
        page.wait_for_function("() => one.paused")
        page.evaluate("() => scrollTo(0, 0)")
        page.wait_for_function("() => !one.paused")


def test_a_frame_without_leave_to_fill_the_screen_says_why_it_does_not(browser: Browser, host: Host) -> None:
    (host.folder / "inner.html").write_text(HEAD + SCRIPT + player("controls", width=700, height=400))
    frame = '<iframe name="inner" src="inner.html" width="750" height="450" allow="fullscreen \'none\'"></iframe>'
    with embedding(browser, host, frame) as page:
        inner = page.frame("inner")
        assert inner is not None
        inner.wait_for_function("() => one.player?.manifest")
        inner.get_by_role("button", name="Full screen").click()
        inner.get_by_role("alert").filter(has_text='needs allow="fullscreen"').wait_for()
        assert inner.get_by_role("link", name="All scenes").count() == 0  # no server, no list


def test_damaged_and_missing_chunks_of_a_folder(browser: Browser, host: Host, served_picture: np.ndarray) -> None:
    """A damaged chunk is fetched again and its picture is whole; a missing one is told and the rest is shown."""
    manifest = load_manifest(host.folder / "clouds")
    damaged, missing = manifest.static[0].id, manifest.slices[-1].chunks[0].id
    host.damaged.add(damaged)
    host.missing.add(missing)
    with embedding(browser, host, SCRIPT + player('time="0.4" camera="side"')) as page:
        wait_for_picture(page)
        assert psnr(pixels(page), served_picture) > 60
        page.get_by_role("alert").filter(has_text="damaged and cannot be shown").wait_for()
        assert page.evaluate("() => one.player.statistics.lostChunks") == 1
    assert len([path for path in host.requests if path.endswith(damaged)]) == 2
    assert len([path for path in host.requests if path.endswith(missing)]) == 1


def test_what_is_wrong_with_an_address_is_said_in_the_player(browser: Browser, host: Host) -> None:
    body = SCRIPT + player("").replace("clouds/manifest.json", "none/manifest.json")
    with embedding(browser, host, body) as page:
        alert = page.get_by_role("alert")
        alert.filter(has_text="There is no such scene here.").wait_for()
        page.evaluate("() => { one.src = 'clouds.ply' }")
        alert.filter(has_text="src clouds.ply: not a manifest.json").wait_for()
        page.evaluate("() => { one.src = 'clouds/' }")  # and what is right then plays
        wait_for_picture(page)
        assert alert.count() == 0
