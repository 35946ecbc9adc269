"""The demo: the bundled capture through the real queue, trainer and server, to a page on which it plays.

Its run is kept in .hgs: a second start plays at once, and goes on with what was stopped.
"""

from __future__ import annotations

import argparse
import contextlib
import http.client
import json
import math
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from tqdm import tqdm

REPOSITORY = Path(__file__).resolve().parent.parent
TITLE = "Studio"
HOLD_OUT = "cam00"
CHECK_PSNR = 40.0  # dB between the page's canvas and the CPU renderer
PROCESSOR_SECONDS = 520.0  # processor time of the whole job (time scripts/demo --check, 2026-11-25)
USED = 0.85  # share of the cores that are busy on average
LINE_EVERY = 4.0  # seconds


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/demo", description=__doc__)
    parser.add_argument("--port", type=int, default=0, help="port of the page (default: a free one)")
    parser.add_argument("--check", action="store_true", help="compare the page with the CPU renderer and end")
    options = parser.parse_args()
    port = options.port or free_port()
    home = REPOSITORY / ".hgs"
    started = time.monotonic()
    server = start_server(home, port)
    try:
        address = f"http://127.0.0.1:{port}"
        with waiting("starting the server"):
            wait_for(address, server, home / "demo.log")
        job, kept = scene_of(address)
        page = f"{address}/view/{job['scene']}"
        if options.check:
            with waiting("comparing the page with the CPU renderer"):
                return check(home / "runs" / job["id"] / "scene", page, None if kept else time.monotonic() - started)
        print(
            f"\n  The scene plays at  {page}\n  All scenes and jobs {address}\n  Ctrl-C ends the demo.\n",
            flush=True,
        )
        return server.wait()
    except KeyboardInterrupt:
        say("stopped; scripts/demo goes on from here")
        return 0
    finally:
        stop(server)


def say(line: str) -> None:
    tqdm.write(line, file=sys.stderr)


@contextlib.contextmanager
def waiting(what: str) -> Iterator[None]:
    """Print the cause of a wait, at once and then every few seconds."""
    done, started = threading.Event(), time.monotonic()

    def tell() -> None:
        while not done.wait(LINE_EVERY):
            say(f"  {what}: {time.monotonic() - started:.0f} s")

    say(what)
    thread = threading.Thread(target=tell, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def start_server(home: Path, port: int) -> subprocess.Popen[bytes]:
    home.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "server.cli", "serve", "--port", str(port), "--workers", "1"]
    command += ["--captures", str(REPOSITORY / "samples")]
    with (home / "demo.log").open("wb") as log:
        return subprocess.Popen(
            command, cwd=REPOSITORY, stdout=log, stderr=log, env=os.environ | {"HGS_HOME": str(home)}
        )


def stop(server: subprocess.Popen[bytes]) -> None:
    server.terminate()
    try:
        server.wait(20)
    except subprocess.TimeoutExpired:
        server.kill()
        server.wait()


def call(address: str, path: str, body: Any = None) -> Any:
    data = None if body is None else json.dumps(body).encode()
    # Not urllib: it closes every connection, as proxies do, from which a server without keys takes nothing.
    with contextlib.closing(http.client.HTTPConnection(urlsplit(address).netloc, timeout=30)) as connection:
        connection.request("GET" if data is None else "POST", path, data, {"Content-Type": "application/json"})
        answer = connection.getresponse()
        if answer.status >= 400:
            raise SystemExit(f"the server refused {path}: {answer.read().decode(errors='replace')}")
        return json.load(answer)


def wait_for(address: str, server: subprocess.Popen[bytes], log: Path, seconds: float = 120.0) -> None:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if server.poll() is not None:
            said = log.read_text(errors="replace").strip().splitlines()[-5:]
            raise SystemExit("\n".join([*said, f"the server ended with status {server.returncode}; {log} says more"]))
        try:
            call(address, "/v1/health")
            return
        except (http.client.HTTPException, ConnectionError, TimeoutError):
            time.sleep(0.1)
    raise SystemExit(f"the server did not answer within {seconds:.0f} seconds; {log} may say why")


def scene_of(address: str) -> tuple[Any, bool]:
    """Return the job with the demo's scene, and whether it was there already; else wait until it is made."""
    job = own_job(address)
    if job is not None and job["state"] == "succeeded":
        say("the scene is there already")
        return job, True
    if job is None:
        job = submit(address)
        say(f"training {TITLE}: {estimate(os.cpu_count() or 1)}; page at {address}/view/{job['id']}")
    else:
        say(f"going on with what was stopped; page at {address}/view/{job['id']}")
    return follow(address, str(job["id"])), False


def estimate(cores: int) -> str:
    cores = min(cores, 8)  # beyond, more of them help little
    minutes = max(1, math.ceil(PROCESSOR_SECONDS / 60 / cores / USED - 0.5))
    return f"about {minutes} minute{'s' * (minutes > 1)} on {cores} idle core{'s' * (cores > 1)}"


def own_job(address: str) -> Any | None:
    """The last demo's job, if its scene is still there or it can still make one."""
    scenes = {scene["id"] for scene in call(address, "/v1/scenes")["scenes"]}
    own = [job for job in call(address, "/v1/jobs")["jobs"] if job["title"] == TITLE]
    done = [job for job in own if job["state"] == "succeeded" and job["scene"] in scenes]
    return next(iter(done + [job for job in own if job["state"] in ("running", "queued", "waiting")]), None)


def submit(address: str) -> Any:
    """Ask for the demo's job and return it, once the server has looked at the capture."""
    body = {"capture": "studio", "title": TITLE, "preset": "preview", "hold_out": [HOLD_OUT]}
    answer = call(address, "/v1/jobs", body)
    while "attempt" not in answer:
        time.sleep(0.5)
        answer = call(address, f"/v1/submissions/{answer['id']}")
    return answer


def follow(address: str, job_id: str, pause: float = 0.3) -> Any:
    """Show a bar for every stage, which moves at every look, until the job ends."""
    bar = tqdm(total=1, desc="waits for the worker", dynamic_ncols=True, bar_format="{desc}: {elapsed}")
    shown, told = "", time.monotonic()
    live = sys.stderr.isatty()  # elsewhere a line now and then will do
    try:
        while True:
            job = call(address, f"/v1/jobs/{job_id}")
            progress = job["progress"]
            if progress and progress["stage"] != shown:
                bar.close()
                shown = progress["stage"]
                bar = tqdm(total=progress["total"], desc=shown, unit="", dynamic_ncols=True)
            if progress:
                bar.total, bar.n = progress["total"], progress["done"]
                bar.set_postfix({k: f"{v:.4g}" for k, v in progress["figures"].items()}, refresh=False)
            if live or time.monotonic() - told > LINE_EVERY:
                told = time.monotonic()
                bar.refresh()  # its clock goes on where the stage says nothing
            if job["state"] in ("succeeded", "failed", "cancelled"):
                break
            time.sleep(pause)
    finally:
        bar.close()
    if job["state"] != "succeeded":
        raise SystemExit(f"the demo's job {job['state']}: {job['error']}")
    return job


def check(scene_folder: Path, page: str, seconds: float | None) -> int:
    """Compare the page's canvas with the CPU renderer's picture; prints one JSON line.

    `seconds` are what the scene took, None if it was there already.
    """
    import numpy as np
    import torch

    from benchmarks.viewers.browser import capture_canvas, find_chromium, psnr
    from hgs_core.codec import decode_scene, load_manifest
    from hgs_core.render.scene_picture import scene_picture
    from hgs_core.scene.camera import Camera

    manifest = load_manifest(scene_folder / "manifest.json")
    scene = decode_scene(scene_folder).map(torch.from_numpy)
    camera = next(c for c in manifest.cameras if c.name == HOLD_OUT)
    assert isinstance(camera, Camera)
    chromium = find_chromium()
    scores: list[float] = []
    for share in (0.25, 0.75) if chromium else ():
        moment = scene.start + share * (scene.end - scene.start)
        picture = scene_picture(scene, camera, moment, rig=manifest.rig).rgb
        expected = np.rint(picture.clamp(0, 1).permute(1, 2, 0).numpy() * 255).astype(np.uint8)
        url = f"{page}?t={moment}&camera={camera.name}&paused=1&width={camera.width}&height={camera.height}&exact=1"
        scores.append(round(psnr(capture_canvas(url, camera.width, camera.height, chromium), expected), 2))
    passed = all(score >= CHECK_PSNR for score in scores)
    print(
        json.dumps(
            {
                "ok": passed,
                "seconds_to_scene": None if seconds is None else round(seconds, 1),
                "canvas_psnr": scores or None,
                "chromium": chromium,
                "splats_static": len(scene.static),
                "splats_dynamic": scene.dynamic_splats,
            }
        )
    )
    return 0 if passed else 1


if __name__ == "__main__":
    sys.path.insert(0, str(REPOSITORY))
    raise SystemExit(main())
