"""How the console's pages look and behave with answers of any kind, on any screen, for anybody."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import pytest

from tests.conftest import REPOSITORY

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page, Route

    from tests.web_client.conftest import Site

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

STAGES = [
    "initialise",
    "sync",
    "cameras",
    "check",
    "masks",
    "points",
    "train",
    "encode",
    "publish",
]  # those of docs/rest.md, in order
PICTURE = REPOSITORY / "docs" / "images" / "report.jpg"
LONG = "a_name_without_any_space_" * 8


def job(name: str, **fields: Any) -> dict[str, Any]:
    """A job as docs/rest.md has it."""
    return {
        "id": name,
        "state": "running",
        "attempt": 1,
        "capture": f"/captures/{name}",
        "title": name,
        "preset": "preview",
        "hold_out": [],
        "config": {},
        "audio": None,
        "stage": None,
        "progress": None,
        "error": None,
        "scene": None,
        "created": 1.0,
        "ends": None,
        "updated": 1.0,
    } | fields


def at_stage(stage: str, done: int = 3, total: int = 16, **figures: float) -> dict[str, Any]:
    return {"stage": stage, "progress": {"stage": stage, "done": done, "total": total, "figures": figures}}


def scene(name: str, **fields: Any) -> dict[str, Any]:
    """A scene as docs/rest.md has it."""
    return {
        "id": name,
        "title": name,
        "created": 1.0,
        "start": 0.0,
        "end": 2.0,
        "bytes_total": 1000,
        "splats_static": 10,
        "splats_dynamic": 5,
        "live": False,
    } | fields


def capture(name: str, **fields: Any) -> dict[str, Any]:
    """A capture as docs/rest.md has it."""
    return {
        "capture": f"/captures/{name}",
        "name": name,
        "layout": "N3DV",
        "cameras": [f"cam{k:02}" for k in range(16)],
        "frames": 60,
        "seconds": 2.0,
        "problem": None,
    } | fields


def _fulfill(answer: Any, route: Route) -> None:
    route.fulfill(json=answer)


@contextmanager
def answering(browser: Browser, site: Site, path: str, answers: dict[str, Any], **options: Any) -> Iterator[Page]:
    """A page with these answers of its server, by patterns of paths below /v1."""
    context = browser.new_context(**options)
    try:
        page = context.new_page()
        page.route("**/events", lambda route: route.fulfill(status=204))
        for pattern, answer in answers.items():
            page.route(f"**/v1/{pattern}", functools.partial(_fulfill, answer))
        page.goto(site.address + path)
        yield page
    finally:
        context.close()


@contextmanager
def listing(
    browser: Browser, site: Site, scenes: list[dict[str, Any]], jobs: list[dict[str, Any]], **options: Any
) -> Iterator[Page]:
    """The list as it shows these scenes and jobs."""
    with answering(browser, site, "/", {"scenes": {"scenes": scenes}, "jobs": {"jobs": jobs}}, **options) as page:
        page.locator(".card, .job, .empty:visible").first.wait_for()
        yield page


@contextmanager
def job_page(
    browser: Browser, site: Site, shown: dict[str, Any], run: dict[str, Any], **options: Any
) -> Iterator[Page]:
    """The page of a job that has trained for a while."""
    points = [
        {
            "attempt": 1,
            "stage": "train",
            "done": done,
            "total": 2000,
            "time": done / 10.0,
            "figures": {"psnr": 30 - 9000 / (done + 600), "loss": 30 / (done + 100), "static": 6000.0 + done},
        }
        for done in range(10, 1000, 10)
    ]
    name = shown["id"]
    answers = {
        f"jobs/{name}": shown,
        f"jobs/{name}/run": {"ahead": None, "picture": None, "report": False, "scene": None} | run,
        f"jobs/{name}/history": {"points": points},
        f"jobs/{name}/log?*": {"lines": ["train begins", "a very long line " * 30], "complete": False},
    }
    with answering(browser, site, f"/job/{name}", answers, **options) as page:
        page.route("**/picture?*", lambda route: route.fulfill(path=PICTURE))
        page.locator(".chart .curve").wait_for()
        for panel in ("Log", "Settings"):
            page.locator("summary", has_text=panel).click()
        page.get_by_text("train begins").wait_for()
        yield page


DESKTOP = {"viewport": {"width": 1280, "height": 800}}
PHONE = {"viewport": {"width": 390, "height": 844}, "device_scale_factor": 3, "has_touch": True, "is_mobile": True}


SCREENS = pytest.mark.parametrize("options", [PHONE, DESKTOP], ids=["phone", "desktop"])
RUNNING = job(
    "a",
    title="Studio",
    updated=99.0,
    ends=219.0,
    **at_stage("train", 990, 2000, psnr=24.3, loss=0.03),
    config={"preset": "preview", "seed": 0, "train": {"iterations": 2000, "rates": {"rgb": 0.005}}, LONG: LONG},
)


def width_of(page: Page) -> int:
    width: int = page.evaluate("() => document.documentElement.scrollWidth")
    return width


@SCREENS
def test_no_long_name_widens_the_page(browser: Browser, site: Site, options: dict[str, Any]) -> None:
    jobs = [
        job("title", title=LONG, **at_stage("train", **{LONG: 1.0})),
        job("capture", title=None, capture=f"/captures/{LONG}"),
        job("error", state="failed", error=f"/captures/{LONG}: cannot be read; replace it"),
        job("stage", **at_stage(LONG)),
    ]
    with listing(browser, site, [scene("scene", title=LONG, live=True)], jobs, **options) as page:
        assert width_of(page) == options["viewport"]["width"]


@SCREENS
def test_no_long_name_widens_the_form(browser: Browser, site: Site, options: dict[str, Any]) -> None:
    captures = [capture(LONG, cameras=[LONG, "b", "c"]), capture("b", problem=LONG)]
    answer = {"captures": captures, "folders": [], "complete": False}
    with answering(browser, site, "/new", {"captures": answer}, **options) as page:
        page.get_by_text("More settings").click()
        page.get_by_role("checkbox").first.wait_for()
        assert width_of(page) == options["viewport"]["width"]


@SCREENS
def test_no_long_name_widens_the_page_of_a_job(browser: Browser, site: Site, options: dict[str, Any]) -> None:
    shown = RUNNING | {"title": LONG, "capture": f"/captures/{LONG}"}
    with job_page(browser, site, shown, {"picture": "1", "report": True, "scene": "a"}, **options) as page:
        assert width_of(page) == options["viewport"]["width"]


def test_a_job_that_ended_without_a_picture_announces_none(browser: Browser, site: Site) -> None:
    ended = RUNNING | {"state": "cancelled"}
    with job_page(browser, site, ended, {"picture": None, "report": False, "scene": None}) as page:
        page.locator(".job-picture").wait_for(state="hidden")


def small_controls(page: Page) -> list[str]:
    """The labels of controls that are smaller than a finger; a box or circle counts with its label."""
    found: list[str] = page.evaluate("""() =>
      [...document.querySelectorAll("a, button, input, select, summary")]
        .map((node) => node.closest("label") ?? node)
        .filter((node) => node.checkVisibility() && !node.matches(".skip"))
        .map((node) => [node.textContent, node.getBoundingClientRect()])
        .filter(([, { width, height }]) => width < 44 || height < 44)
        .map(([text, { width, height }]) => `${text}: ${width} x ${height}`)""")
    return found


def test_controls_are_large_enough_for_fingers(browser: Browser, site: Site) -> None:
    jobs = [job("a", **at_stage("train")), job("b", state="failed"), job("c", state="succeeded", scene="c")]
    scenes = [scene(f"scene {number}") for number in range(9)]
    with listing(browser, site, scenes, jobs, **PHONE) as page:
        page.get_by_role("button", name="More about scene 3").tap()
        assert page.get_by_role("button", name="Rename …").is_visible()
        assert small_controls(page) == []
        page.get_by_role("button", name="Rename …").tap()
        assert small_controls(page) == []
    captures = {"captures": [capture("a"), capture("b")], "folders": [], "complete": True}
    with answering(browser, site, "/new", {"captures": captures}, **PHONE) as page:
        page.get_by_text("a", exact=True).tap()
        page.get_by_text("More settings").tap()
        assert page.get_by_role("checkbox").count() == 0  # 16 cameras are folded away
        page.get_by_text("Choose cameras").tap()
        assert small_controls(page) == []
    with job_page(browser, site, RUNNING, {"report": True, "scene": "a"}, **PHONE) as page:
        assert small_controls(page) == []


AXE = (REPOSITORY / "web_client" / "node_modules" / "axe-core" / "axe.min.js").resolve()


LANDMARKS = ("region", "landmark-one-main", "landmark-no-duplicate-main")


def violations(page: Page) -> list[str]:
    """The serious and critical findings of axe, and those outside of all landmarks, each with an element."""
    if not AXE.is_file():
        pytest.skip("axe-core is not installed: run npm ci in web_client")
    page.evaluate(AXE.read_text())
    found = page.evaluate("() => axe.run()")["violations"]
    grave = [one for one in found if one["impact"] in ("serious", "critical") or one["id"] in LANDMARKS]
    return [f"{one['id']}: {one['help']} {one['nodes'][0]['html']}" for one in grave]


@pytest.mark.parametrize("theme", ["light", "dark"])
@SCREENS
def test_anybody_can_use_the_pages(browser: Browser, site: Site, options: dict[str, Any], theme: str) -> None:
    options = options | {"color_scheme": theme, "reduced_motion": "reduce"}
    jobs = [
        job("a", **at_stage("train", psnr=20.5)),
        job("b", state="failed", error="it failed"),
        job("c", state="succeeded", scene="s0"),
    ]
    with listing(browser, site, [scene(f"s{number}") for number in range(9)], jobs, **options) as page:
        assert violations(page) == []
        page.get_by_role("button", name="More about s3").click()
        page.get_by_role("button", name="Delete …").click()
        assert violations(page) == []
    with listing(browser, site, [], [], **options) as page:
        assert violations(page) == []
    answer = {"captures": [capture("a"), capture("b", problem="is damaged")], "folders": [], "complete": True}
    with answering(browser, site, "/new", {"captures": answer}, **options) as page:
        page.get_by_role("button", name="Start").wait_for()
        page.locator("input[type=radio]").first.check()
        assert violations(page) == []
    with job_page(browser, site, RUNNING, {"picture": "1", "report": True, "scene": "a"}, **options) as page:
        assert violations(page) == []


@pytest.mark.parametrize(("theme", "is_dark"), [("light", False), ("dark", True)])
def test_the_console_follows_the_system_and_the_player_stays_dark(
    browser: Browser, site: Site, theme: str, is_dark: bool
) -> None:
    ground = "() => getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)"
    with listing(browser, site, [scene("a", live=True)], [], color_scheme=theme) as page:
        assert (sum(page.evaluate(ground)) < 200) is is_dark
        page.goto(site.page)
        page.wait_for_function("() => window.hgs !== undefined")
        assert sum(page.evaluate(ground)) < 200


def test_the_list_says_what_to_do_while_it_is_empty(browser: Browser, site: Site) -> None:
    with listing(browser, site, [], []) as page:
        page.get_by_role("heading", name="No scenes yet").wait_for()
        assert not page.get_by_role("heading", name="Jobs", exact=True).is_visible()
        page.route("**/v1/captures", lambda route: route.fulfill(json=NO_CAPTURES))
        page.get_by_role("link", name="Or choose a capture of the server").click()
        page.get_by_role("heading", name="No captures yet").wait_for()


NO_CAPTURES = {
    "captures": [],
    "complete": True,
    "folders": [{"path": "/srv/captures", "exists": True}, {"path": "/srv/missing", "exists": False}],
}


@pytest.mark.parametrize(
    ("folders", "heading", "words"),
    [
        (NO_CAPTURES["folders"], "No captures yet", "into this folder of the server"),
        ([{"path": "/srv/missing", "exists": False}], "No captures yet", "Or make this folder"),
        ([], "This server reads no captures", "hgs serve --captures"),
    ],
)
def test_the_form_says_what_to_do_without_captures(
    browser: Browser, site: Site, folders: list[dict[str, Any]], heading: str, words: str
) -> None:
    with answering(browser, site, "/new", {"captures": NO_CAPTURES | {"folders": folders}}) as page:
        page.get_by_role("heading", name=heading).wait_for()
        assert words in page.locator(".empty").inner_text()
        assert page.locator(".paths code").all_inner_texts() == [folder["path"] for folder in folders[:1]]


def test_a_damaged_capture_says_so_and_cannot_be_chosen(browser: Browser, site: Site) -> None:
    answer = {"captures": [capture("a", problem="row 3 is damaged"), capture("b")], "folders": [], "complete": True}
    with answering(browser, site, "/new", {"captures": answer}) as page:
        damaged = page.get_by_role("radio", name="a row 3 is damaged")
        damaged.wait_for()
        assert damaged.is_disabled()
        assert page.get_by_role("radio", name="b 16 cameras · 60 frames · 2.0 s").is_checked()  # the only one


def test_many_scenes_can_be_searched_and_sorted(browser: Browser, site: Site) -> None:
    scenes = [
        scene(f"s{number}", title=f"Take {number}", end=float(number), created=float(number)) for number in range(9)
    ]
    with listing(browser, site, scenes, []) as page:
        titles = page.locator(".card-title")
        assert titles.first.inner_text() == "Take 8"
        page.get_by_role("combobox", name="Order").select_option("By name")
        assert titles.first.inner_text() == "Take 0"
        page.get_by_role("searchbox", name="Search").fill("take 4")
        assert titles.all_inner_texts() == ["Take 4"]
        page.get_by_role("searchbox", name="Search").fill("nothing")
        page.get_by_text("No scene of that name.").wait_for()
    with listing(browser, site, scenes[:3], []) as page:
        assert not page.get_by_role("searchbox", name="Search").is_visible()


def test_the_actions_of_a_scene_need_no_mouse(browser: Browser, site: Site) -> None:
    with listing(browser, site, [scene("a"), scene("b")], []) as page:
        more = page.get_by_role("button", name="More about a")
        more.focus()
        page.keyboard.press("Enter")
        focused = "(node) => node === document.activeElement"
        assert page.get_by_role("button", name="Copy link").evaluate(focused)
        page.keyboard.press("Escape")
        assert not page.get_by_role("button", name="Copy link").is_visible()
        assert more.evaluate(focused)
        page.keyboard.press("Enter")
        for _ in range(3):  # past the last of the three
            page.keyboard.press("Tab")
        assert not page.get_by_role("button", name="Copy link").is_visible()


def test_a_job_says_how_long_it_takes(browser: Browser, site: Site) -> None:
    with job_page(browser, site, RUNNING, {}) as page:
        page.get_by_text("about 2 min left").wait_for()
        box = page.locator(".chart svg").bounding_box()
        assert box is not None
        page.mouse.move(box["x"] + 50, box["y"] + 50)
        page.get_by_text("at 10", exact=False).first.wait_for()


def test_a_link_can_be_copied_by_hand_where_there_is_no_clipboard(browser: Browser, site: Site) -> None:
    with listing(browser, site, [scene("a")], []) as page:
        page.evaluate("() => Object.defineProperty(navigator, 'clipboard', {value: undefined})")
        page.get_by_role("button", name="More about a").click()
        page.get_by_role("button", name="Copy link").click()
        field = page.get_by_role("dialog").get_by_role("textbox", name="Link")
        assert field.input_value() == f"{site.address}/view/a"


def test_every_stage_has_words_and_a_step(browser: Browser, site: Site) -> None:
    with listing(browser, site, [], [job(stage, **at_stage(stage)) for stage in STAGES]) as page:
        rows = page.locator(".job").all()
        words = [row.locator(".job-state").inner_text() for row in rows]
        steps = [row.locator("[data-state=now]").all_inner_texts() for row in rows]
        assert [f"{step} 3 / 16" for (step,) in steps] == words
        assert [row.locator("[data-state=done]").count() for row in rows] == [0, 0, 0, 0, 1, 2, 3, 4, 5]


def test_an_unknown_stage_shows_its_name_and_its_progress(browser: Browser, site: Site) -> None:
    with listing(browser, site, [], [job("a", **at_stage("depth_maps", 4, 16))]) as page:
        assert page.locator(".job-state").inner_text() == "Depth maps 4 / 16"
        assert page.locator(".job progress").evaluate("(bar) => bar.value / bar.max") == 0.25
        assert not page.locator(".job-steps").is_visible()


def test_only_a_scene_that_lasts_wears_its_length(browser: Browser, site: Site) -> None:
    scenes = [scene("moving"), scene("still", end=0.0, splats_dynamic=0)]
    with listing(browser, site, scenes, []) as page:
        moving, still = page.locator(".card").all()
        assert moving.locator(".card-length").inner_text() == "2.0 s"
        assert still.locator(".card-length").count() == 0
        assert "still" in still.locator(".card-figures").inner_text()


def test_an_address_without_a_page_says_so_and_leads_to_the_list(browser: Browser, site: Site) -> None:
    page = browser.new_page()
    try:
        for path in ("/nothing", "/view", "/view/no/such/page", "/assets/none.js"):
            response = page.goto(site.address + path)
            assert response is not None
            assert response.status == 404
            page.get_by_role("heading", name="There is nothing at this address").wait_for()
            assert page.title() == "Not found · HGS"
        page.get_by_role("link", name="All scenes").click()
        page.get_by_role("heading", name="Clouds").wait_for()
    finally:
        page.close()
