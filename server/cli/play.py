"""`hgs play URL --stats`: receive and play a scene of a server without drawing it, and tell how that went."""

from __future__ import annotations

import argparse
import asyncio
import os
import re
import sys
from typing import Any
from urllib.parse import parse_qsl, urlencode, urlsplit, urlunsplit

from hgs_core.base.errors import InputError
from server.cli.json_output import JsonOutput
from server.cli.server_client import ServerClient, add_patience_option

__all__ = ["add_parser"]

NO_WEBSOCKETS = (
    "this site does not pass WebSockets; the scene is loaded over HTTP instead. See docs/deploy.md of the server"
)
_FOLDER = re.compile(r".*/(?:[^/]*\.(?:json|hgs)|(?<=[^/]/))")  # or what is in it; at the root are a server's scenes


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "play",
        help="play a scene without a picture, and tell how its stream went",
        description="Receive a scene as a player does, and tell when it began, how often it waited, and what came.",
    )
    parser.add_argument(
        "url",
        metavar="URL",
        help="a scene's page, http://HOST/view/NAME, with its ?link= if it has one; its stream, ws://...; or its "
        "folder on a web server, http://HOST/.../; HGS_KEY is the key that the server may ask for",
    )
    parser.add_argument("--stats", action="store_true", help="tell how the stream went; there is no picture to show")
    parser.add_argument("--seconds", metavar="S", type=float, default=None, help="to watch; default: the scene once")
    add_patience_option(parser)
    parser.add_argument(
        "--json",
        metavar="FILE",
        nargs="?",
        const="-",
        help="write JSON to FILE, or to standard output in place of text",
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    url = _scene(options.url)
    if not options.stats:
        raise InputError("hgs play", "draws no pictures", "give --stats, or open the page in a browser")
    if options.seconds is not None and not 0 < options.seconds < float("inf"):
        raise InputError("--seconds", f"{options.seconds} is not a time to watch", "give a number above 0")
    output = JsonOutput(options.json)
    if server := _server(url):
        with ServerClient(server, options.patience) as client:  # a stream would be tried for ever
            client.request("GET", "/v1/health")
    from server.client.stream_client import StreamRefusedError
    from server.client.viewing import play

    try:
        watched = asyncio.run(play(url, options.seconds, os.environ.get("HGS_KEY", "")))
    except StreamRefusedError as error:
        raise InputError(options.url, str(error), "open the list of the server's scenes") from error
    if watched.over_http and url.startswith("ws"):
        print(f"hgs: {NO_WEBSOCKETS}", file=sys.stderr)
    report = watched.to_json()
    begins = (
        "did not play" if watched.start is None else f"plays after {watched.start:.2f} s, {watched.start_bytes} bytes"
    )
    text = f"{begins}; waited {watched.stalls} times, {watched.waited:.1f} s; {watched.bytes} bytes of chunks came"
    output.show(report, f"{text}, {watched.twice} of them twice")
    return 0


def _server(stream: str) -> str:
    """Return the address of the server of a stream, "" if it does not tell."""
    parts = urlsplit(stream)
    before, found, _ = parts.path.partition("/v1/scenes/")
    return urlunsplit((parts.scheme.replace("ws", "http"), parts.netloc, before, "", "")) if found else ""


def _scene(url: str) -> str:
    """Return the address of the stream of a scene's page; a stream, and a folder of a web server, as they are.

    Raises:
        InputError: it is none of them.
    """
    try:
        parts = urlsplit(url)
    except ValueError:  # a bracket that is not closed
        parts = urlsplit("")
    if parts.scheme in ("ws", "wss") and parts.netloc:
        return url
    if parts.scheme in ("http", "https") and parts.netloc:
        before, view, scene = parts.path.rstrip("/").rpartition("/view/")
        if view and scene and "/" not in scene:
            link = urlencode([pair for pair in parse_qsl(parts.query) if pair[0] == "link"])
            path = f"{before}/v1/scenes/{scene}/stream"
            return urlunsplit((parts.scheme.replace("http", "ws"), parts.netloc, path, link, ""))
        if _FOLDER.fullmatch(parts.path):
            return urlunsplit((*parts[:4], ""))
    cure = (
        "give http://HOST/view/NAME, ws://HOST/v1/scenes/NAME/stream, or a scene's folder, as http://HOST/NAME/ or, at "
        "the root, http://HOST/manifest.json"
    )
    raise InputError(url, "is not the address of a scene", cure)
