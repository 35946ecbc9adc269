"""`hgs play URL --stats`: receive and play a scene of a server without drawing it, and tell how that went."""

from __future__ import annotations

import argparse
import asyncio
from typing import Any
from urllib.parse import urlsplit, urlunsplit

from hgs_core.base.errors import InputError
from server.cli.json_output import JsonOutput
from server.cli.server_client import ServerClient, add_patience_option

__all__ = ["add_parser"]


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "play",
        help="play a scene without a picture, and tell how its stream went",
        description="Receive a scene as a player does, and tell when it began, how often it waited, and what came.",
    )
    parser.add_argument("url", metavar="URL", help="a scene's page, http://HOST/view/NAME, or its stream, ws://...")
    parser.add_argument("--stats", action="store_true", help="tell how the stream went; there is no picture to show")
    parser.add_argument("--seconds", metavar="S", type=float, default=None, help="to watch; default: the scene once")
    add_patience_option(parser)
    parser.add_argument(
        "--json", metavar="FILE", nargs="?", const="-",
        help="write JSON to FILE, or to standard output in place of text",
    )  # fmt: skip
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    url, server = _stream(options.url)
    if not options.stats:
        raise InputError("hgs play", "draws no pictures", "give --stats, or open the page in a browser")
    if options.seconds is not None and not 0 < options.seconds < float("inf"):
        raise InputError("--seconds", f"{options.seconds} is not a time to watch", "give a number above 0")
    output = JsonOutput(options.json)
    with ServerClient(server, options.patience) as client:  # a stream would be tried for ever
        client.request("GET", "/v1/health")
    from server.client import StreamRefusedError
    from server.viewing import play

    try:
        watched = asyncio.run(play(url, options.seconds))
    except StreamRefusedError as error:
        raise InputError(options.url, str(error), "open the list of the server's scenes") from error
    report = watched.to_json()
    begins = (
        "did not play" if watched.start is None else f"plays after {watched.start:.2f} s, {watched.start_bytes} bytes"
    )
    text = f"{begins}; waited {watched.stalls} times, {watched.waited:.1f} s; {watched.bytes} bytes of chunks came"
    output.show(report, f"{text}, {watched.twice} of them twice")
    return 0


def _stream(url: str) -> tuple[str, str]:
    """Return the address of the stream of a scene's page, and that of its server.

    Raises:
        InputError: it is neither.
    """
    try:
        parts = urlsplit(url)
    except ValueError:  # a bracket that is not closed
        parts = urlsplit("")
    if parts.scheme in ("ws", "wss") and parts.netloc:
        before = parts.path.partition("/v1/scenes/")[0]
        return url, urlunsplit((parts.scheme.replace("ws", "http"), parts.netloc, before, "", ""))
    before, view, scene = parts.path.rstrip("/").rpartition("/view/")
    if parts.scheme not in ("http", "https") or not view or not scene:
        raise InputError(
            url, "is not the address of a scene", "give http://HOST/view/NAME or ws://HOST/v1/scenes/NAME/stream"
        )
    stream = (parts.scheme.replace("http", "ws"), parts.netloc, f"{before}/v1/scenes/{scene}/stream", "", "")
    return urlunsplit(stream), urlunsplit((parts.scheme, parts.netloc, before, "", ""))
