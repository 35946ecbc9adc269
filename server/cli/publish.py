"""`hgs publish RUN`: puts the scene of a finished run into the store of the service, or into a folder for the web."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from server.cli.progress_bars import ProgressBars
from server.cli.training_options import add_audio_option

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "publish",
        help="publish a finished run",
        description="Publish a finished run in the service's store and print the scene's id; or, with --to, write a "
        "folder that any web server can serve, with a page that plays the scene.",
    )
    parser.add_argument("run_folder", metavar="RUN", type=Path, help="folder of the run")
    parser.add_argument("--id", default="", help="the scene's id in the store; default: the name of the run's folder")
    parser.add_argument("--to", metavar="DIR", type=Path, help="a new folder, an empty one, or one of the same scene")
    parser.add_argument("--replace", action="store_true", help="with --to: DIR may hold another scene, which goes")
    parser.add_argument("--data-only", action="store_true", help="with --to: write neither the player nor index.html")
    add_audio_option(parser, None, "default: as the run has it")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.audio is not None:
        from hgs_core.runs.folder import RunFolder
        from hgs_core.runs.sound import replace_sound

        RunFolder(options.run_folder).read_spec()  # a wrong path is told at once
        with RunFolder(options.run_folder).exclusive():
            replace_sound(options.run_folder, options.audio)
    if options.to is not None:
        return _to_folder(options)
    for name, given in (("--replace", options.replace), ("--data-only", options.data_only)):
        if given:
            raise InputError(name, "needs --to", "give the folder to write, or leave it out")
    from jobs.artifacts import open_store
    from jobs.home import Home
    from server.publishing import publish_run

    with ProgressBars() as bars:
        scene_id = publish_run(open_store(Home.from_environment()), options.run_folder, options.id, bars)
    print(scene_id)
    return 0


def _to_folder(options: argparse.Namespace) -> int:
    if options.id:
        raise InputError("--id", f"{options.id!r} names a scene in the store, --to writes a folder", "leave one out")
    from server.viewer import VIEWER
    from server.web_folder import PLAYER, publish_to_folder

    player = None if options.data_only else VIEWER / PLAYER
    with ProgressBars() as bars:
        publish_to_folder(options.run_folder, options.to, player=player, replace=options.replace, progress=bars)
    print(options.to)
    return 0
