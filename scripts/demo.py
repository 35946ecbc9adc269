"""The demo: the bundled capture through the real queue, trainer and server, to a page on which it plays."""

from __future__ import annotations

import argparse
import http.client
import json
import os
import socket
import subprocess
import sys
import tempfile
import time
from contextlib import closing
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from tqdm import tqdm

REPOSITORY = Path(__file__).resolve().parent.parent
HOLD_OUT = "cam00"
CHECK_PSNR = 40.0  # dB between the page's canvas and the CPU renderer


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/demo", description=__doc__)
    parser.add_argument("--port", type=int, default=0, help="port of the page (default: a free one)")
    parser.add_argument("--check", action="store_true", help="compare the page with the CPU renderer and end")
    options = parser.parse_args()
    port = options.port or free_port()
    with tempfile.TemporaryDirectory(prefix="hgs-demo-") as scratch:
        home = Path(scratch) if options.check else REPOSITORY / ".hgs"
        started = time.monotonic()
        server = start_server(home, port)
        try:
            address = f"http://127.0.0.1:{port}"
            wait_for(address, server)
            job = existing_job(address) or follow(address, submit(address))
            page = f"{address}/view/{job['scene']}"
            seconds = round(time.monotonic() - started, 1)
            if options.check:
                return check(home / "runs" / job["id"] / "scene", page, seconds)
            print(
                f"\n  The scene plays at  {page}\n  All scenes and jobs {address}\n  Ctrl-C ends the demo.\n",
                flush=True,
            )
            return server.wait()
        except KeyboardInterrupt:
            return 0
        finally:
            stop(server)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def start_server(home: Path, port: int) -> subprocess.Popen[bytes]:
    home.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "server.cli", "serve", "--port", str(port), "--workers", "1"]
    command += ["--captures", str(REPOSITORY / "samples")]
    with (home / "demo.log").open("ab") as log:
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
    with closing(http.client.HTTPConnection(urlsplit(address).netloc, timeout=30)) as connection:
        connection.request("GET" if data is None else "POST", path, data, {"Content-Type": "application/json"})
        answer = connection.getresponse()
        if answer.status >= 400:
            raise SystemExit(f"the server refused {path}: {answer.read().decode(errors='replace')}")
        return json.load(answer)


def wait_for(address: str, server: subprocess.Popen[bytes]) -> None:
    for _ in range(300):
        if server.poll() is not None:
            raise SystemExit(f"the server ended with status {server.returncode}; see demo.log in its home")
        try:
            call(address, "/v1/health")
            return
        except (http.client.HTTPException, ConnectionError, TimeoutError):
            time.sleep(0.1)
    raise SystemExit("the server did not answer within 30 seconds")


def existing_job(address: str) -> Any | None:
    """The last demo's job, if its scene is still there."""
    scenes = {scene["id"] for scene in call(address, "/v1/scenes")["scenes"]}
    jobs = call(address, "/v1/jobs")["jobs"]
    return next((job for job in jobs if job["state"] == "succeeded" and job["scene"] in scenes), None)


def submit(address: str) -> str:
    body = {"capture": "studio", "title": "Studio", "preset": "preview", "hold_out": [HOLD_OUT]}
    answer = call(address, "/v1/jobs", body)
    while "attempt" not in answer:  # the capture is still being looked at
        time.sleep(0.5)
        answer = call(address, f"/v1/submissions/{answer['id']}")
    return str(answer["id"])


def follow(address: str, job_id: str) -> Any:
    """Show a progress bar for every stage until the job ends."""
    bar: tqdm[Any] | None = None
    while True:
        job = call(address, f"/v1/jobs/{job_id}")
        progress = job["progress"]
        if progress:
            if bar is None or bar.desc != progress["stage"]:
                if bar is not None:
                    bar.close()
                bar = tqdm(total=progress["total"], desc=progress["stage"], unit="", dynamic_ncols=True)
            bar.total = progress["total"]
            bar.set_postfix({k: f"{v:.4g}" for k, v in progress["figures"].items()}, refresh=False)
            bar.update(progress["done"] - bar.n)
        if job["state"] in ("succeeded", "failed", "cancelled"):
            if bar is not None:
                bar.close()
            if job["state"] != "succeeded":
                raise SystemExit(f"the demo's job {job['state']}: {job['error']}")
            return job
        time.sleep(0.3)


def check(scene_folder: Path, page: str, seconds: float) -> int:
    """Compare the page's canvas with the CPU renderer's picture; prints one JSON line."""
    import numpy as np
    import torch

    from hgs_core.bench.browser import capture_canvas, find_chromium, psnr
    from hgs_core.codec import decode_scene, load_manifest
    from hgs_core.render import rasterize
    from hgs_core.scene.camera import Camera

    manifest = load_manifest(scene_folder / "manifest.json")
    scene = decode_scene(scene_folder).map(torch.from_numpy)
    camera = next(c for c in manifest.cameras if c.name == HOLD_OUT)
    assert isinstance(camera, Camera)
    chromium = find_chromium()
    scores: list[float] = []
    for share in (0.25, 0.75) if chromium else ():
        moment = scene.start + share * (scene.end - scene.start)
        segment = scene.segment_at(moment)
        picture = rasterize(
            scene.static, segment.dynamic, camera, segment.normalised(moment),
            background=scene.background, gradients="none", antialiased=scene.antialiased,
        ).rgb  # fmt: skip
        expected = np.rint(picture.clamp(0, 1).permute(1, 2, 0).numpy() * 255).astype(np.uint8)
        url = f"{page}?t={moment}&camera={camera.name}&paused=1&width={camera.width}&height={camera.height}&exact=1"
        scores.append(round(psnr(capture_canvas(url, camera.width, camera.height, chromium), expected), 2))
    passed = all(score >= CHECK_PSNR for score in scores)
    print(json.dumps({
        "ok": passed,
        "seconds_to_scene": seconds,
        "canvas_psnr": scores or None,
        "chromium": chromium,
        "splats_static": len(scene.static),
        "splats_dynamic": scene.dynamic_splats,
    }))  # fmt: skip
    return 0 if passed else 1


if __name__ == "__main__":
    sys.path.insert(0, str(REPOSITORY))
    raise SystemExit(main())
