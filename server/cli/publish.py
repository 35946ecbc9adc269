"""`hgs publish RUN`: puts the scene of a finished run into the store of the service, or into a folder or bucket for the
web.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.writable import require_writable_folder
from server.cli.progress_bars import ProgressBars
from server.cli.training_options import add_audio_option

__all__ = ["add_parser"]

_ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+:/")  # two letters at least: C:/ is a folder


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "publish",
        help="publish a finished run",
        description="Publish a finished run in the service's store and print the scene's id; or, with --to, write a "
        "folder that any web server can serve, or to a prefix of an S3 bucket, with a page that plays the scene. What "
        "lies there already is not written or sent again.",
    )
    parser.add_argument("run_folder", metavar="RUN", type=Path, help="folder of the run")
    parser.add_argument("--id", default="", help="the scene's id in the store; default: the name of the run's folder")
    parser.add_argument(
        "--to",
        metavar="DIR|s3://BUCKET/PREFIX",
        help="a folder or a prefix of a bucket: a new one, an empty one, or one of the same scene; the bucket's "
        "endpoint, region and credentials are AWS_ENDPOINT, AWS_REGION, AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY",
    )
    parser.add_argument("--replace", action="store_true", help="with --to: another scene may lie there, which goes")
    parser.add_argument("--data-only", action="store_true", help="with --to: write neither the player nor index.html")
    add_audio_option(parser, None, "default: as the run has it")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.audio is not None:
        from hgs_core.runs.run_folder import RunFolder
        from hgs_core.runs.sound import replace_sound

        RunFolder(options.run_folder).read_spec()  # a wrong path is told at once
        with RunFolder(options.run_folder).exclusive():
            replace_sound(options.run_folder, options.audio)
    if options.to is not None:
        return _to_files(options)
    for name, given in (("--replace", options.replace), ("--data-only", options.data_only)):
        if given:
            raise InputError(name, "needs --to", "give the folder or bucket to write, or leave it out")
    from jobs.artifacts.artifact_store import open_store
    from jobs.artifacts.publish_run import publish_run
    from jobs.home.home import Home

    with ProgressBars() as bars:
        scene_id = publish_run(open_store(Home.from_environment()), options.run_folder, options.id, bars)
    print(scene_id)
    return 0


def _to_files(options: argparse.Namespace) -> int:
    if options.id:
        raise InputError("--id", f"{options.id!r} names a scene in the store, --to writes files", "leave one out")
    from server.publishing.static_folder import PLAYER
    from server.publishing.web_bucket import publish_to_bucket
    from server.publishing.web_folder import publish_to_folder
    from server.routes.viewer_pages import VIEWER
    from server.uploads.upload_limits import bytes_for_people

    run, to = options.run_folder, options.to
    if not _ADDRESS.match(to) and (Path(to).is_dir() or not Path(to).exists()):
        require_writable_folder(Path(to))
    player = None if options.data_only else VIEWER / PLAYER
    with ProgressBars() as bars:
        if _ADDRESS.match(to):
            done = publish_to_bucket(run, to, player=player, replace=options.replace, progress=bars)
        else:
            done = publish_to_folder(run, Path(to), player=player, replace=options.replace, progress=bars)
    written = f"{done.files} files written, {bytes_for_people(done.bytes)}"
    print(f"{written}; {done.kept} already there" if done.kept else written, file=sys.stderr)
    print(to)
    return 0
