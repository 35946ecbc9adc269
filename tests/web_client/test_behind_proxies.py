"""The pages in a browser behind a real nginx: without WebSockets, below paths, and both."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import pytest

from tests.conftest import REPOSITORY
from tests.nginx import free_ports, running_nginx
from tests.web_client.conftest import Site, serving
from tests.web_client.test_access import give, hgs
from tests.web_client.test_console import write_capture
from tests.web_client.test_embedding import hosting

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = [pytest.mark.browser, pytest.mark.timeout(300)]

READY = "() => window.hgs?.ready.then(() => true)"
OVER_HTTP = "() => window.hgs?.state.stream === 'over-http'"
REMARK = "hgs: this site does not pass WebSockets; the scene is loaded over HTTP instead."
UPGRADE = 'proxy_http_version 1.1; proxy_set_header Upgrade $http_upgrade; proxy_set_header Connection "upgrade";'
HOST = "proxy_set_header Host $http_host;"
KINDS = (
    "bare",
    "two in a row",
    "gateway",
    "page",
    "stripped",
    "kept",
    "told",
    "stripped without Upgrade",
    "kept without Upgrade",
    "guarded",
    "shipped",
)
PREFIXED = ("stripped", "kept", "told", "stripped without Upgrade", "kept without Upgrade", "shipped")


@dataclass(frozen=True)
class Proxies:
    """The address of each kind of proxy, without a slash at its end; and the key of the guarded server."""

    addresses: dict[str, str]
    key: str
    link: str  # a path with a query


@pytest.fixture(scope="module")
def proxies(site: Site, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Proxies]:
    run = [site.folder.parent]
    homes = [tmp_path_factory.mktemp(name) for name in ("open", "kept", "guarded")]
    key = hgs(homes[2], "keys", "add", "anna", "--scope", "submit", "--scope", "publish")
    with (
        serving(run, homes[0], "--open") as [plain],
        serving(run, homes[1], "--open", "--root-path", "/my%20scenes/hgs") as [kept],
        serving(run, homes[2]) as [guarded],
    ):
        link = hgs(homes[2], "keys", "link", "clouds", "--for", "1h")
        at = {name: f"http://{urlsplit(page).netloc}" for name, page in zip("pkg", (plain, kept, guarded), strict=True)}
        ports = dict(zip((*KINDS, "first"), free_ports(len(KINDS) + 1), strict=True))
        shipped = (REPOSITORY / "deploy" / "nginx-prefix.conf").read_text().replace("http://127.0.0.1:8000", at["p"])
        blocks = {
            "bare": f"location / {{ proxy_pass {at['p']}; }}",
            "two in a row": f"location / {{ proxy_pass http://127.0.0.1:{ports['bare']}; }}",
            "gateway": f"location / {{ proxy_pass {at['p']}; }} location ~ /stream$ {{ return 502; }}",
            "page": f"location / {{ proxy_pass {at['p']}; }} location ~ /stream$ {{ return 200 hello; }}",
            "stripped": f"location /hgs/ {{ proxy_pass {at['p']}/; {UPGRADE} {HOST} }}",
            "kept": f'location "/my scenes/hgs/" {{ proxy_pass {at["k"]}; {UPGRADE} {HOST} }}',
            "told": f'location "/view/a b/" {{ proxy_pass {at["p"]}/; {UPGRADE} {HOST}'
            "proxy_set_header X-Forwarded-Prefix /view/a%20b; }",
            "stripped without Upgrade": f"location /a/b/c/ {{ proxy_pass {at['p']}/; {HOST} }}",
            "kept without Upgrade": f'location "/my scenes/" {{ proxy_pass {at["k"]}; {HOST} }}',
            "guarded": f"location /hgs/ {{ proxy_pass {at['g']}/; {HOST} proxy_set_header X-Forwarded-Prefix /hgs; }}",
            "shipped": shipped,
        }
        folder = tmp_path_factory.mktemp("nginx")
        text = "access_log off; client_max_body_size 0; absolute_redirect off; types {} default_type text/plain;"
        text += "".join(f"server {{ listen 127.0.0.1:{ports[kind]}; {block} }}" for kind, block in blocks.items())
        roots = {
            "stripped": "/hgs",
            "kept": "/my%20scenes/hgs",
            "told": "/view/a%20b",
            "stripped without Upgrade": "/a/b/c",
            "kept without Upgrade": "/my%20scenes/hgs",
            "guarded": "/hgs",
            "shipped": "/hgs",
        }
        with running_nginx(folder, text, [ports[kind] for kind in KINDS]):
            yield Proxies({kind: f"http://127.0.0.1:{ports[kind]}{roots.get(kind, '')}" for kind in KINDS}, key, link)


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    context = browser.new_context(viewport={"width": 1000, "height": 700})
    context.set_default_timeout(60_000)
    yield context.new_page()
    context.close()


def lost(page: Page) -> list[str]:
    """The failed requests of the page from now on, streams left aside."""
    failed: list[str] = []

    def note(status: int, url: str) -> None:
        if status >= 400 and not url.endswith("/stream"):
            failed.append(f"{status} {url}")

    page.on("response", lambda answer: note(answer.status, answer.url))
    return failed


@pytest.mark.parametrize(
    ("kind", "over_http"),
    [
        ("bare", True),
        pytest.param("two in a row", True, marks=pytest.mark.slow),  # twin: "bare"
        ("gateway", True),
        ("page", True),
        ("stripped without Upgrade", True),
        ("kept without Upgrade", True),
        ("stripped", False),
        ("kept", False),
        ("told", False),
        ("shipped", False),
    ],
)
def test_a_scene_plays_and_says_calmly_what_is_missing(
    page: Page, proxies: Proxies, kind: str, over_http: bool
) -> None:
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text) if message.type == "info" else None)
    failed = lost(page)
    page.goto(f"{proxies.addresses[kind]}/view/clouds?paused=1")
    page.wait_for_function(READY)
    page.wait_for_function("() => window.hgs.state.complete")
    assert page.evaluate("() => window.hgs.state.stream") == (
        "over-http" if over_http else "closed"
    )  # all files are here
    assert [line.startswith(REMARK) for line in said] == ([True] if over_http else [])
    assert page.locator(".notice >> visible=true").count() == 0
    assert failed == []


@pytest.mark.parametrize(
    "kind",  # pages open no stream: those without Upgrade are twins
    [pytest.param(kind, marks=pytest.mark.slow if "without" in kind else ()) for kind in PREFIXED],
)
def test_the_pages_lead_to_one_another_below_a_path(page: Page, proxies: Proxies, kind: str) -> None:
    root, failed = proxies.addresses[kind], lost(page)
    page.goto(f"{root}/")
    page.get_by_role("link", name="Clouds").first.click()
    page.wait_for_function(READY)
    assert page.url == f"{root}/view/clouds"
    page.goto(f"{root}/new/")
    page.get_by_role("link", name="Cancel").click()
    page.get_by_role("link", name="New scene").click()
    assert page.url == f"{root}/new"
    page.get_by_role("link", name="HGS").first.click()
    page.get_by_role("link", name="Clouds").first.wait_for()
    assert page.url == f"{root}/"
    assert failed == []
    page.goto(f"{root}/no/such/page")
    page.get_by_role("heading", name="There is nothing at this address").wait_for()
    assert page.get_by_role("link", name="All scenes").get_attribute("href") == f"{urlsplit(root).path}/"
    assert page.locator("main img").evaluate("(image) => image.decode().then(() => image.naturalWidth > 0)")
    assert len(failed) == 1


@pytest.mark.parametrize("kind", ["told", "kept without Upgrade"])
def test_a_capture_is_sent_and_its_job_shown_below_a_path(
    page: Page, proxies: Proxies, kind: str, tmp_path: Path
) -> None:
    root, failed = proxies.addresses[kind], lost(page)
    name = f"studio-{kind.split()[0]}"
    write_capture(tmp_path / name, None)
    page.goto(f"{root}/new")
    page.locator("input[webkitdirectory]").set_input_files(tmp_path / name)
    page.get_by_text(re.compile("Everything has arrived|check", re.IGNORECASE)).first.wait_for()
    page.locator(f"input[value*='{name}'], option[value*='{name}']").first.wait_for(state="attached")
    page.get_by_role("button", name=re.compile("Make|Start|Train|Create")).click()
    page.wait_for_url(re.compile(rf"^{re.escape(root)}/job/"))
    page.get_by_text(re.compile("[Qq]ueued|[Ww]ait")).first.wait_for()
    assert failed == []


def test_a_key_is_kept_for_the_path_alone_and_links_lead_below_it(page: Page, proxies: Proxies) -> None:
    root = proxies.addresses["guarded"]
    page.goto(f"{root}/view/clouds?paused=1")
    give(page, proxies.key)
    page.wait_for_function(OVER_HTTP)  # the cookie is needed, too
    [cookie] = page.context.cookies()
    assert cookie["path"] == "/hgs/"
    page.goto(f"{root}/")
    page.evaluate("() => { Object.defineProperty(navigator, 'clipboard', { value: undefined }) }")
    page.get_by_role("button", name="More about Clouds").click()
    page.get_by_role("button", name="Copy link").click()
    shared = page.get_by_label("Link", exact=True).input_value()
    assert shared.startswith(f"{root}/view/clouds?link=")
    page.context.clear_cookies()
    page.goto(f"{shared}&paused=1")
    page.wait_for_function(READY)
    assert page.evaluate("() => window.hgs.state.stream") == "over-http"
    page.goto(f"{root}{proxies.link}x")
    page.get_by_role("heading", name="This link has expired").wait_for()


@pytest.mark.parametrize("kind", ["stripped", "kept without Upgrade"])
def test_a_scene_below_a_path_plays_in_a_frame_of_another_site(
    page: Page, proxies: Proxies, kind: str, tmp_path: Path
) -> None:
    source = f"{proxies.addresses[kind]}/view/clouds?paused=1"
    (tmp_path / "index.html").write_text(f'<!doctype html><iframe src="{source}" width="600" height="400"></iframe>')
    with hosting(tmp_path) as host:
        page.goto(f"{host.address.replace('127.0.0.1', 'localhost')}/index.html")
        frame = page.frame(url=source)
        assert frame is not None
        frame.wait_for_function(READY)


def test_a_published_folder_plays_below_a_path(page: Page, site: Site, tmp_path: Path) -> None:
    from server.cli import main

    assert main(["publish", str(site.folder.parent), "--to", str(tmp_path / "my scenes" / "a" / "clouds")]) == 0
    [port] = free_ports(1)
    types = (
        "types { text/html html; text/javascript js; application/wasm wasm; application/json json; image/jpeg jpg; }"
    )
    text = f"access_log off; {types} server {{ listen 127.0.0.1:{port}; root {tmp_path}; }}"
    (tmp_path / "nginx").mkdir()
    with running_nginx(tmp_path / "nginx", text.replace(str(tmp_path), f'"{tmp_path}"'), [port]):
        failed = lost(page)
        page.goto(f"http://127.0.0.1:{port}/my%20scenes/a/clouds/")
        page.wait_for_function("() => document.querySelector('hgs-player')?.player?.manifest")
        page.wait_for_function("() => document.querySelector('hgs-player').player.statistics.complete")
        assert failed == []
