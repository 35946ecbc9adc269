"""`hgs serve [RUN ...]`: the API, the viewer's page and the workers."""

from __future__ import annotations

import argparse
import os
import re
import signal
import sys
from contextlib import closing
from ipaddress import ip_address
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hgs_core.base.errors import InputError
from server.cli.progress_bars import ProgressBars

if TYPE_CHECKING:
    from server.access.visitors import Asking

__all__ = ["add_parser"]

MOST_DRAIN = 300
_ORIGIN = re.compile(r"https?://[^\s/?#]+")


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "serve",
        help="serve scenes and run jobs",
        description="Publish the given runs, then serve the API and the viewer and run queued jobs until stopped.",
    )
    parser.add_argument("run_folders", metavar="RUN", type=Path, nargs="*", help="finished runs to publish first")
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="address to listen on; any but one of this machine alone needs keys, or --open",
    )
    parser.add_argument(
        "--open",
        action="store_true",
        help="ask nobody for a key: whoever can reach the server can use all of it; HGS_OPEN=1 means the same",
    )
    parser.add_argument("--port", type=int, default=8000, help="0 lets the system choose")
    parser.add_argument("--workers", type=int, default=1, help="worker processes to run; 0 for none")
    parser.add_argument(
        "--captures",
        metavar="FOLDERS",
        default="",
        help="folders that jobs may read, separated as in PATH; default: HGS_CAPTURES, else captures/ in the home",
    )
    parser.add_argument(
        "--uploads",
        metavar="LIMITS",
        default="",
        help="how much may be sent to this server, as in quota=2T,upload=200G,file=100G,files=20000,open=16,client=4,"
        "free=10G,hours=48,share=100G, of which all may be left out; or off; default: HGS_UPLOADS (docs/upload.md)",
    )
    parser.add_argument(
        "--allow-origin",
        metavar="ORIGIN",
        dest="origins",
        action="append",
        default=[],
        help="a page of another host that may read scenes, e.g. https://example.org; * for all; may be repeated",
    )
    parser.add_argument(
        "--allow-host",
        metavar="NAME",
        dest="hosts",
        action="append",
        default=[],
        help="a name that people reach this server by, beside localhost and IP addresses; may be repeated; "
        "HGS_ALLOW_HOSTS holds more, separated by commas",
    )
    parser.add_argument(
        "--connections-per-address",
        metavar="N",
        type=int,
        default=None,
        help="connections that one address may have open; give more if it is a proxy's (default: a quarter of all)",
    )
    parser.add_argument(
        "--max-streams",
        metavar="N",
        type=int,
        default=None,
        help="streams that may be open at once; others are told to come again (default: as many as it can carry)",
    )
    parser.add_argument(
        "--requests-per-second",
        metavar="N",
        type=float,
        default=None,
        help="requests that one key, or one address without a key, may make; four seconds' worth at once "
        "(default: no limit)",
    )
    parser.add_argument(
        "--drain",
        metavar="SECONDS",
        type=float,
        default=5.0,
        help="over which streams are ended when the server stops, so that their clients do not all come back at once",
    )
    parser.add_argument(
        "--root-path",
        metavar="PATH",
        default="",
        help="the path under which a proxy passes requests on as they came, such as /hgs; default: HGS_ROOT_PATH; "
        "not for a proxy that takes the path off (docs/deploy.md)",
    )
    parser.add_argument(
        "--access-log",
        action="store_true",
        help="write a line of JSON to stderr for every request, not for deletions alone",
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.workers < 0:
        raise InputError("--workers", f"{options.workers} is negative", "give 0 or more")
    if options.connections_per_address is not None and options.connections_per_address < 1:
        raise InputError("--connections-per-address", f"{options.connections_per_address} is too few", "give 1 or more")
    if options.max_streams is not None and options.max_streams < 1:
        raise InputError("--max-streams", f"{options.max_streams} is too few", "give 1 or more")
    rate = options.requests_per_second
    if rate is not None and rate <= 0:
        raise InputError("--requests-per-second", f"{rate} is no limit", "give a number above 0, or leave it out")
    if not 0 <= options.drain <= MOST_DRAIN:
        raise InputError("--drain", f"{options.drain} is no number of seconds", f"give 0 to {MOST_DRAIN}")
    for origin in options.origins:
        if origin != "*" and not _ORIGIN.fullmatch(origin):
            raise InputError("--allow-origin", f"{origin!r} is no origin", "give it as in https://example.org, or *")
    for folder in filter(None, options.captures.split(os.pathsep)):
        if not Path(folder).is_dir():
            raise InputError("--captures", f"{folder} is not a folder", "make it first, or give another")
    from jobs.artifacts.artifact_store import open_store
    from jobs.artifacts.publish_run import publish_run
    from jobs.home.home import Home
    from jobs.process.sandbox import missing_from_sandbox
    from jobs.process.stage_environment import keep_secrets
    from jobs.records.keys import KeyTable
    from jobs.worker_processes import WorkerProcesses
    from server.access.allowed_hosts import AllowedHosts
    from server.access.visitors import Access
    from server.app import create_app
    from server.captures.capture_folders import CaptureFolders
    from server.http.log_lines import configure_log
    from server.http.request_log import configure_access_log
    from server.http.site_root import configured_root
    from server.listener.connection_limits import ConnectionLimits, open_file_limit, raise_open_file_limit
    from server.listener.http_server import HttpServer, bind, spare_collector
    from server.uploads.upload_limits import UploadLimits

    keep_secrets()
    configure_log()
    configure_access_log(deletions_only=not options.access_log)
    raise_open_file_limit()
    limits = ConnectionLimits.for_files(open_file_limit(), options.connections_per_address)
    hosts = AllowedHosts.configured(options.host, options.hosts)
    root = configured_root(options.root_path)
    home = Home.from_environment()
    uploads = UploadLimits.configured(options.uploads)
    with bind(options.host, options.port) as listener, closing(KeyTable(home)) as keys:
        opened = options.open or os.environ.get("HGS_OPEN") == "1"
        asking, line = _asking(listener.getsockname()[0], opened, bool(keys.all()))
        store = open_store(home)
        with ProgressBars() as bars:
            scenes = [publish_run(store, run, progress=bars) for run in options.run_folders]
        if line:
            print(line, file=sys.stderr)
        if lacking := missing_from_sandbox():
            print(f"hgs: {lacking}", file=sys.stderr)
        captures = CaptureFolders.configured(home.folder, options.captures)
        app = create_app(
            home,
            captures=captures,
            uploads=uploads,
            origins=options.origins,
            hosts=hosts,
            artifacts=store,
            access=Access(keys, asking),
            max_streams=options.max_streams,
            requests_per_second=rate,
            root=root,
        )
        host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(options.host, options.host)
        host = f"[{host}]" if ":" in host else host
        address = f"http://{host}:{listener.getsockname()[1]}"
        pages = [f"{address}/view/{scene}" for scene in scenes] or [f"{address}/"]

        def announce() -> None:
            print(*pages, sep="\n", flush=True)
            spare_collector()

        server = HttpServer(app, limits=limits, drain=options.drain, on_ready=announce)
        # Uvicorn handles the signals while it serves, and raises them again after its shutdown.
        signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
        with WorkerProcesses(home, options.workers):
            server.run([listener])
    return 0


def _asking(address: str, opened: bool, any_keys: bool) -> tuple[Asking, str]:
    """Return the rule for keys, and a line about access to the server; "" where keys decide.

    Raises:
        InputError: others can reach the server, and it is said neither that it is open nor who may use it.
    """
    from server.access.visitors import Asking

    here = ip_address(address.partition("%")[0]).is_loopback
    if opened:
        reached = "hgs: open: whoever can reach this server can use all of it, without a key"
        return Asking.NEVER, "" if here else reached
    if here:
        cure = "before a proxy passes others on, make a key: hgs keys add NAME --scope admin"
        line = f"hgs: no keys: whoever asks from this machine can use all of this server; {cure}"
        return Asking.IF_ANY, "" if any_keys else line
    if not any_keys:
        cure = "make a key with hgs keys add NAME --scope admin, or say --open"
        raise InputError("--host", f"{address} is reached by others, and there are no keys", cure)
    return Asking.ALWAYS, ""
