"""`hgs keys`: access to the server of a home."""

from __future__ import annotations

import argparse
import json
import math
import re
import time
from contextlib import closing
from datetime import UTC, datetime
from typing import Any
from urllib.parse import quote

from hgs_core.base.errors import InputError

__all__ = ["add_parser"]

_UNITS = {"s": 1, "m": 60, "h": 3600, "d": 86400}
_LONGEST_KEY_DAYS = 36500  # a century
_SCOPES = ("view", "submit", "publish", "admin")


def add_parser(commands: Any) -> None:
    """Add the subcommand."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "keys",
        help="let people and programs in",
        description="Make, list and revoke the keys of a server's home, and links to single scenes. Where there are "
        "keys, the server asks for one; changes hold at once, without a restart.",
    )
    actions = parser.add_subparsers(metavar="ACTION", required=True)
    add = actions.add_parser("add", help="make a key and print it: it is shown this once")
    add.add_argument("name", metavar="NAME", help="whose or what for")
    add.add_argument(
        "--scope",
        action="append",
        choices=_SCOPES,
        default=[],
        dest="scopes",
        help="may be repeated; submit and publish allow to view, admin allows everything (default: view)",
    )
    add.add_argument(
        "--for", metavar="TIME", dest="duration", help="how long it holds, such as 30d or 12h (default: ever)"
    )
    add.set_defaults(run=_add)
    shown = actions.add_parser("ls", help="list the keys")
    shown.add_argument("--json", action="store_true", help="print JSON")
    shown.set_defaults(run=_list)
    revoke = actions.add_parser("revoke", help="take a key back, with the links and sessions made with it")
    revoke.add_argument("name", metavar="NAME")
    revoke.set_defaults(run=_revoke)
    link = actions.add_parser("link", help="print a link with which anybody can watch a scene for a while")
    link.add_argument("scene", metavar="SCENE", help="the scene's id")
    link.add_argument("--for", metavar="TIME", dest="duration", default="1d", help="such as 45m, 12h, 7d (default: 1d)")
    link.set_defaults(run=_link)


def _add(options: argparse.Namespace) -> int:
    from jobs.home.home import Home
    from jobs.records.keys import KeyTable, Scope

    expires = None if options.duration is None else time.time() + seconds(options.duration)
    with closing(KeyTable(Home.from_environment())) as table:
        print(table.add(options.name, {Scope(one) for one in options.scopes} or {Scope.VIEW}, expires))
    return 0


def _list(options: argparse.Namespace) -> int:
    from jobs.home.home import Home
    from jobs.records.keys import KeyTable

    with closing(KeyTable(Home.from_environment())) as table:
        keys = table.all()
    if options.json:
        fields = [
            {"name": k.name, "id": k.id, "scopes": sorted(k.scopes), "created": k.created, "expires": k.expires}
            for k in keys
        ]
        print(json.dumps(fields, indent=1))
        return 0
    for key in keys:
        until = "" if key.expires is None else f"  until {_date(key.expires)}"
        until += "" if key.valid(time.time()) else " (expired)"
        print(f"{key.name:20}  {' '.join(sorted(key.scopes)):24}  since {_date(key.created)}{until}")
    return 0


def _revoke(options: argparse.Namespace) -> int:
    from jobs.home.home import Home
    from jobs.records.keys import KeyTable

    with closing(KeyTable(Home.from_environment())) as table:
        table.revoke(options.name)
    return 0


def _link(options: argparse.Namespace) -> int:
    from jobs.artifacts.artifact_store import ArtifactStore
    from jobs.home.home import Home
    from jobs.records.keys import KeyTable
    from server.access.link_lifetime import LONGEST_LINK_DAYS
    from server.access.signed_tokens import SignedToken, sign_token
    from server.http.site_root import configured_root

    home = Home.from_environment()
    expires = int(time.time() + seconds(options.duration, LONGEST_LINK_DAYS))
    if ArtifactStore(home.store_url).scene_entry(options.scene) is None:
        raise InputError(f"scene {options.scene}", "no such scene in the store", "give the id that hgs publish printed")
    with closing(KeyTable(home)) as table:
        token = sign_token(SignedToken("link", expires, "", options.scene), table.secret())
    print(f"{quote(configured_root())}/view/{options.scene}?link={token}")
    return 0


def seconds(text: str, longest: int = _LONGEST_KEY_DAYS) -> float:
    """Return the seconds of a time such as 90s, 45m, 12h or 7d.

    Raises:
        InputError: it is none, no time at all, or more than `longest` days.
    """
    found = re.fullmatch(r"(\d{1,9}(?:\.\d{1,3})?)([smhd])", text)
    value = float(found[1]) * _UNITS[found[2]] if found else math.nan
    if not value > 0:
        raise InputError("--for", f"{text!r} is no length of time", "give a number with s, m, h or d, such as 12h")
    if value > longest * _UNITS["d"]:
        raise InputError("--for", f"{text} is too long", f"give {longest}d at most")
    return value


def _date(moment: float) -> str:
    return datetime.fromtimestamp(moment, UTC).strftime("%Y-%m-%d %H:%M UTC")
