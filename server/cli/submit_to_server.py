"""`hgs submit CAPTURE --to URL`: sends a capture to a server, has it checked there, and makes a job of it."""

from __future__ import annotations

import argparse
import secrets
import sys
import time
from pathlib import Path
from typing import Any
from urllib.parse import quote

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, StageStopped, interruptible
from hgs_core.check.findings import CameraResult, CaptureCheck, Finding
from hgs_core.check.require_sound_capture import require_sound
from hgs_core.runs.sound_choice import NO_SOUND, OWN_SOUND, camera_of_sound
from server.cli.capture_files import archive_ending, capture_files, opened_capture
from server.cli.interrupts import Interrupts
from server.cli.job_options import job_options
from server.cli.job_words import no_worker
from server.cli.progress_bars import ProgressBars
from server.cli.send_capture import send_capture
from server.cli.server_client import RefusedError, ServerClient
from server.cli.training_options import job_settings
from server.uploads.upload_limits import UploadLimits

__all__ = ["submit_to_server"]

POLL_SECONDS = 0.5
INTERRUPTED = 130


def submit_to_server(options: argparse.Namespace) -> int:
    """Run `hgs submit --to` and return the exit status.

    Raises:
        InputError: the capture cannot be sent, or the check stops it; the capture stays on the server then.
    """
    asked = job_options(options)
    key = asked.pop("key") or secrets.token_hex(16)
    settings = job_settings(options) | asked
    for name, given, place in (
        ("--masks", options.masks, "masks/"),
        ("--depth", options.depth, "depth/"),
        ("--mesh", options.mesh, "mesh.ply, mesh.obj or mesh.glb"),
    ):
        if given is not None:
            raise InputError(name, "what is given is sent with the capture", f"put it into the folder, as {place}")
    if (audio := _sent_sound(options)) != OWN_SOUND:
        settings["audio"] = audio
    archive_ending(options.capture)  # ahead of any request
    with (
        ServerClient(options.to, options.patience) as client,
        Interrupts() as interrupts,
        ProgressBars(interrupts) as bars,
        interruptible(),  # whatever it waits for: what the server has stays there
    ):

        def show(done: int, total: int) -> None:
            bars(Progress("sending MB", done // 1_000_000, max(1, total // 1_000_000)))

        try:
            limits = _limits(client)
            with opened_capture(options.capture, limits) as (name, folder):
                capture = send_capture(client, name, capture_files(folder), show)
            bars.close()
            print(f"the capture is {capture} on the server", file=sys.stderr)
            capture = _trainable(client, capture)
            found = _checked(client, capture, bars)
            if found is not None and not settings["config"].get("capture.trust_poses"):
                require_sound(found, Path(capture), settings["hold_out"])
            job = _queue(client, key, {"capture": capture, "title": options.title, **settings})
            print(job["id"], flush=True)
            workers = client.request("GET", "/v1/workers").value["workers"]
            if line := no_worker([job], workers, client.url):
                bars.close()
                print(line, file=sys.stderr)
            return _follow(client, job["id"], bars) if options.wait else 0
        except StageStopped:
            bars.close()
            print("stopped; run the same command again to go on", file=sys.stderr)
            return INTERRUPTED


def _queue(client: ServerClient, key: str, asked: dict[str, Any]) -> dict[str, Any]:
    """Make the job, once the server has looked at the capture, and return it."""
    place = ""
    while True:
        try:
            if not place:
                # A request whose answer was lost is sent again: with its key it is no second job.
                answer = client.request("POST", "/v1/jobs", headers={"Idempotency-Key": key}, json_body=asked)
            else:
                answer = client.request("GET", place)
        except RefusedError as error:
            if error.code != "submission-not-found":
                raise
            place = ""  # the server was started anew meanwhile
            continue
        if answer.status != 202:
            job: dict[str, Any] = answer.value
            return job
        place = f"/v1/submissions/{answer.value['id']}"
        time.sleep(POLL_SECONDS)


def _limits(client: ServerClient) -> UploadLimits:
    """Return how much the server takes: the first question, which another program's server cannot answer."""
    try:
        return UploadLimits(**client.request("GET", "/v1/uploads").value["limits"])
    except (KeyError, TypeError) as error:
        raise InputError(client.url, "is no server of HGS, or one of another version", "check the address") from error


def _sent_sound(options: argparse.Namespace) -> str:
    """Return the request of --audio: a file by its path in the capture that is sent."""
    audio: str = options.audio
    if audio in (OWN_SOUND, NO_SOUND) or camera_of_sound(audio) is not None:
        return audio
    capture = options.capture.resolve()
    for file in (Path(audio).resolve(), (capture / audio).resolve()):
        if file.is_file() and file.is_relative_to(capture):
            return file.relative_to(capture).as_posix()
    raise InputError(f"--audio {audio}", "sound is sent with the capture", "put the file into the capture's folder")


def _trainable(client: ServerClient, uploaded: str) -> str:
    """Return the capture among the sent files: the folder itself, or one inside it."""
    while True:
        listed = client.request("GET", "/v1/captures").value["captures"]
        inside = [one for one in listed if one["capture"] == uploaded or one["capture"].startswith(f"{uploaded}/")]
        if not any(one.get("looking") for one in inside):
            break
        time.sleep(POLL_SECONDS)
    whole = [one for one in inside if one["problem"] is None]
    if len(whole) > 1:
        names = ", ".join(one["name"] for one in whole)
        raise InputError(uploaded, f"holds several captures: {names}", "send the folder of one")
    if not whole and inside:
        raise InputError("the capture", inside[0]["problem"])
    return str(whole[0]["capture"]) if whole else uploaded


def _checked(client: ServerClient, capture: str, bars: ProgressBars) -> CaptureCheck | None:
    """Return the result of a check of the capture, and show it; None if its poses are found later."""
    listed = {one["capture"]: one for one in client.request("GET", "/v1/captures").value["captures"]}
    if listed.get(capture, {}).get("layout") == "videos without poses":
        print("nothing says where the cameras stand: the job finds that out from the videos first", file=sys.stderr)
        return None
    check = client.request("POST", "/v1/captures/check", json_body={"capture": capture}).value
    while check["state"] in ("waiting", "running"):
        bars(Progress("check", 0, 1))
        time.sleep(POLL_SECONDS)
        check = client.request("GET", f"/v1/captures/check?capture={quote(capture, safe='')}").value
    bars.close()
    if check["error"]:
        raise InputError("the capture", check["error"])
    found = _result(check["found"])
    print(found.table(), file=sys.stderr)
    return found


def _result(found: dict[str, Any]) -> CaptureCheck:
    findings = tuple(Finding(**one | {"cameras": tuple(one["cameras"])}) for one in found["findings"])
    cameras = tuple(CameraResult(**one) for one in found["cameras"])
    return CaptureCheck(cameras, findings, (), tuple(found["frames"]), found["width"])


def _follow(client: ServerClient, job_id: str, bars: ProgressBars) -> int:
    """Draw the job's progress until it is finished; return 0 if it succeeded."""
    while (job := client.request("GET", f"/v1/jobs/{job_id}").value)["state"] in ("queued", "running", "waiting"):
        if progress := job["progress"]:
            left = job["ends"] and job["ends"] - time.time()
            bars(Progress(progress["stage"], progress["done"], progress["total"], progress["figures"]), left)
        time.sleep(POLL_SECONDS)
    bars.close()
    if job["state"] != "succeeded":
        print(f"hgs: job {job_id}: {job['state']}{': ' + job['error'] if job['error'] else ''}", file=sys.stderr)
        return 1
    print(f"{client.url}/view/{job['scene']}", file=sys.stderr)
    return 0
