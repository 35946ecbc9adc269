"""The npm package as `npm pack` writes it: its files, its scripts in Node, its declarations in programs of others."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from benchmarks.viewers.browser import canvas_pixels
from tests.web_client.conftest import HEIGHT, REPOSITORY, WIDTH
from tests.web_client.test_embedding import HEAD, hosting, pixels, player, served_picture, wait_for_picture

if TYPE_CHECKING:
    from playwright.sync_api import Browser

    from tests.web_client.conftest import Site

__all__ = ["served_picture"]

CLIENT = REPOSITORY / "web_client"
NPM = shutil.which("npm") or "npm"
STRICT = {  # finds modules as Node does
    "module": "nodenext",
    "target": "es2022",
    "lib": ["es2022", "dom", "dom.iterable"],
    "types": [],
    "jsx": "react-jsx",
    "strict": True,
    "noEmit": True,
}
FRAMEWORKS = ("@types/react", "playcanvas", "react", "react-dom", "svelte", "vue")


@pytest.fixture(scope="module")
def tarball(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if shutil.which("npm") is None or not (CLIENT / "node_modules").is_dir():
        pytest.skip("needs npm and web_client/node_modules")
    folder = tmp_path_factory.mktemp("packed")
    pack = [NPM, "pack", "--silent", "--pack-destination", str(folder)]
    packed = subprocess.run(pack, cwd=CLIENT, check=True, capture_output=True, text=True)
    return folder / packed.stdout.split()[-1]


@pytest.fixture
def project(tarball: Path, tmp_path: Path) -> Path:
    """A folder with the package, three.js and the frameworks in its `node_modules`."""
    (tmp_path / "package.json").write_text('{"type": "module"}')
    (tmp_path / "tsconfig.json").write_text(json.dumps({"compilerOptions": STRICT}))
    modules = tmp_path / "node_modules"
    with tarfile.open(tarball) as archive:
        archive.extractall(modules / "@hgs", filter="data")
    (modules / "@hgs" / "package").rename(modules / "@hgs" / "player")
    for name in ("three", *FRAMEWORKS):
        (modules / name).parent.mkdir(exist_ok=True)
        (modules / name).symlink_to(CLIENT / "node_modules" / name)
    return tmp_path


def check_types(project: Path) -> None:
    """Have strict TypeScript accept the project's programs."""
    compiler = [str(CLIENT / "node_modules" / ".bin" / "tsc"), "--project", str(project)]
    done = subprocess.run(compiler, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_the_licence_is_the_projects() -> None:
    assert (CLIENT / "LICENSE").read_bytes() == (REPOSITORY / "LICENSE").read_bytes()


def test_the_tarball_has_what_its_entries_name_and_nothing_of_the_project_beside(project: Path) -> None:
    package = project / "node_modules" / "@hgs" / "player"
    assert sorted(path.name for path in package.iterdir()) == ["LICENSE", "README.md", "dist", "package.json"]
    entries = json.loads((package / "package.json").read_text())["exports"]
    files = [name for entry in entries.values() for name in (entry.values() if isinstance(entry, dict) else [entry])]
    assert [name for name in files if not (package / name).is_file()] == []


def test_publint_has_nothing_to_say(tarball: Path) -> None:
    lint = [shutil.which("npx") or "npx", "--no-install", "publint", "--strict", str(tarball)]
    without_colours = {**{key: value for key, value in os.environ.items() if key != "FORCE_COLOR"}, "NO_COLOR": "1"}
    done = subprocess.run(lint, cwd=CLIENT, env=without_colours, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert done.stdout.splitlines()[-1].endswith("All good!")


def test_links_of_the_readme_lead_somewhere_on_npm() -> None:
    links = re.findall(r"\]\(([^)]*)\)", (CLIENT / "README.md").read_text())
    assert [link for link in links if not link.startswith("https://")] == []


def test_the_public_interface_is_that_of_the_report(tarball: Path, tmp_path: Path) -> None:
    """A change of a public name or type is seen in web_client/api.txt, which `npm run api` writes."""
    report = tmp_path / "api.txt"
    subprocess.run([NPM, "run", "--silent", "api", "--", str(report)], cwd=CLIENT, check=True, capture_output=True)
    assert report.read_text() == (CLIENT / "api.txt").read_text()


def test_every_entry_can_be_imported_by_a_server(project: Path) -> None:
    """Node has no HTMLElement, and no registry of custom elements."""
    script = """
        import manifest from "@hgs/player/package.json" with { type: "json" };
        const entries = Object.keys(manifest.exports).filter((entry) => !entry.endsWith(".json"));
        for (const entry of entries) {
          const names = Object.keys(await import(`@hgs/player${entry.slice(1)}`));
          if (names.length > 0) console.log(entry);
        }
        console.log(globalThis.HTMLElement, globalThis.customElements);
    """
    (project / "server.js").write_text(script)
    done = subprocess.run(["node", "--no-warnings", "server.js"], cwd=project, capture_output=True, text=True)
    assert done.stderr == ""
    assert done.stdout.split() == [
        ".",
        "./element",
        "./react",
        "./svelte",
        "./vue",
        "./three",
        "./three-webgpu",
        "./playcanvas",
        "undefined",
        "undefined",
    ]


def test_declarations_of_the_package_are_those_of_its_scripts(project: Path) -> None:
    (project / "page.ts").write_text(
        """
        import { createPlayer, HgsPlayer, type Viewing } from "@hgs/player";
        import "@hgs/player/element";
        const player: HgsPlayer = createPlayer(document.body, { src: "a/", loop: true });
        player.addEventListener("error", ({ detail }) => { const words: string = detail.message; console.log(words); });
        const view: Viewing | null = player.camera.view;
        const element = document.createElement("hgs-player");
        element.playbackRate = view ? 2 : 1;
        // @ts-expect-error times are numbers
        element.currentTime = "1";
        """
    )
    check_types(project)


def test_react_knows_the_element_in_jsx(project: Path) -> None:
    (project / "scene.tsx").write_text(
        """
        import "@hgs/player/react";
        import type { HgsPlayerElement } from "@hgs/player/element";
        import { useRef } from "react";
        export function Scene() {
          const element = useRef<HgsPlayerElement>(null);
          return <hgs-player ref={element} className="wide" src="a/" controls muted time={1.5} camera="left"
            onready={() => element.current?.play()} onerror={({ detail }) => console.log(detail.message.length)} />;
        }
        // @ts-expect-error volumes are numbers
        export const loud = <hgs-player volume="loud" />;
        // @ts-expect-error React calls its own `onPlay` for its own elements
        export const uncalled = <hgs-player onPlay={() => {}} />;
        """
    )
    check_types(project)


def test_svelte_and_vue_know_the_element_in_templates(project: Path) -> None:
    (project / "svelte.ts").write_text(
        """
        import "@hgs/player/svelte";
        import type { SvelteHTMLElements } from "svelte/elements";
        type Attributes = SvelteHTMLElements["hgs-player"];
        export const right: Attributes = { class: "wide", onerror: ({ detail }) => void detail.message.length };
        // @ts-expect-error volumes are numbers
        export const wrong: Attributes = { volume: "loud" };
        """
    )
    (project / "vue.ts").write_text(
        """
        import "@hgs/player/vue";
        import type { GlobalComponents } from "vue";
        type Attributes = InstanceType<GlobalComponents["hgs-player"]>["$props"];
        export const right: Attributes = { class: "wide", onError: ({ detail }) => void detail.message.length };
        // @ts-expect-error volumes are numbers
        export const wrong: Attributes = { volume: "loud" };
        """
    )
    check_types(project)


REACT = """
import "@hgs/player/react";
import { createElement } from "react";
import { createRoot } from "react-dom/client";
const onready = () => (window.heard = "ready");
const attributes = { id: "one", src: "clouds/manifest.json", volume: 0.5, controls: true, loop: false, onready };
createRoot(document.getElementById("app")).render(createElement("hgs-player", attributes));
"""
SVELTE = """
import "@hgs/player/svelte";
import { mount } from "svelte";
import Scene from "./Scene.svelte";
mount(Scene, { target: document.getElementById("app") });
"""
SCENE = """
<script>const onready = () => (window.heard = "ready")</script>
<hgs-player id="one" src="clouds/manifest.json" volume={0.5} controls loop={false} {onready}></hgs-player>
"""
VITE = """
import { compile } from "svelte/compiler";
const transform = (source, name) => (name.endsWith(".svelte") ? compile(source, {}).js : null);
export default { plugins: [{ name: "svelte", transform }] };
"""
VUE = """
import "@hgs/player/vue";
import { createApp, h } from "vue";
const onReady = () => (window.heard = "ready");
const attributes = { id: "one", src: "clouds/manifest.json", volume: 0.5, controls: true, loop: false, onReady };
createApp({ render: () => h("hgs-player", attributes) }).mount("#app");
"""


@pytest.mark.browser
@pytest.mark.timeout(180)
@pytest.mark.parametrize("page", [REACT, SVELTE, VUE], ids=["react", "svelte", "vue"])
def test_a_page_of_a_framework_that_vite_has_built_plays(
    browser: Browser, site: Site, project: Path, page: str
) -> None:
    (project / "index.html").write_text(f'{HEAD}<div id="app"></div><script type="module" src="page.js"></script>')
    for name, text in {"page.js": page, "Scene.svelte": SCENE, "vite.config.js": VITE}.items():
        (project / name).write_text(text)
    vite = [str(CLIENT / "node_modules" / ".bin" / "vite"), "build", "--logLevel", "error"]
    subprocess.run(vite, cwd=project, check=True, capture_output=True)
    shutil.copytree(site.folder, project / "dist" / "clouds")
    with hosting(project / "dist") as host:
        shown = browser.new_page()
        try:
            shown.goto(host.address)
            shown.wait_for_function("() => window.heard === 'ready'")
            assert shown.evaluate("() => [one.volume, one.controls, one.loop]") == [0.5, True, False]
        finally:
            shown.close()


@pytest.mark.slow
@pytest.mark.browser
@pytest.mark.timeout(180)
def test_the_packed_package_plays_in_an_empty_project_on_a_plain_web_server(
    browser: Browser, site: Site, served_picture: np.ndarray, tarball: Path, tmp_path: Path
) -> None:
    """Ten lines of HTML, `npm install` of the tarball, `python -m http.server`."""
    project = tmp_path / "project"
    project.mkdir()
    (project / "package.json").write_text('{"name": "page", "private": true}')
    install = [NPM, "install", "--offline", "--no-audit", "--no-fund", str(tarball)]
    subprocess.run(install, cwd=project, check=True, capture_output=True)
    assert sorted(path.name for path in (project / "node_modules").iterdir() if path.name[0] != ".") == ["@hgs"]
    shutil.copytree(site.folder, project / "clouds")
    element = player('time="0.4" camera="side"')
    script = '<script type="module" src="node_modules/@hgs/player/dist/element.js"></script>'
    (project / "index.html").write_text(HEAD + script + element)
    (project / "module.html").write_text(
        HEAD
        + f"""<div id="stage" style="width: {WIDTH}px; height: {HEIGHT}px"></div><script type="module">
          import {{ createPlayer }} from "./node_modules/@hgs/player/dist/index.js";
          window.heard = [];
          const src = "clouds/";
          const player = createPlayer(document.getElementById("stage"), {{ src, time: 0.4, camera: "side" }});
          for (const type of ["loadstart", "manifest", "firstpicture", "ready", "seeked", "play", "pause"])
            player.addEventListener(type, () => heard.push(type));
          player.addEventListener("ready", () => {{ window.hgs = player }});
        </script>"""
    )
    command = [sys.executable, "-u", "-m", "http.server", "0", "--bind", "127.0.0.1", "--directory", str(project)]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    page = browser.new_page()
    try:
        assert server.stdout is not None
        port = re.search(r"port (\d+)", server.stdout.readline())
        assert port is not None
        page.goto(f"http://127.0.0.1:{port[1]}/")
        wait_for_picture(page)
        assert np.array_equal(pixels(page), served_picture)
        page.goto(f"http://127.0.0.1:{port[1]}/module.html")
        page.wait_for_function("() => window.hgs")
        assert np.array_equal(canvas_pixels(page), served_picture)
        page.evaluate("async () => { hgs.play(); await hgs.seek(1.2); hgs.pause(); await hgs.seek(1.2) }")
        heard = page.evaluate("() => heard")
        assert [type for type in heard if type != "seeked"][:4] == ["manifest", "firstpicture", "ready", "play"]
        size = page.evaluate("async () => (await createImageBitmap(await hgs.screenshot())).width")
        assert size == WIDTH
        page.evaluate("() => hgs.dispose()")
        assert page.evaluate("() => document.getElementById('stage').childElementCount") == 0
    finally:
        page.close()
        server.terminate()
        server.communicate(timeout=30)
