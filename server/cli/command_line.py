"""A parser of command lines that refuses in one line, with the word that was probably meant."""

from __future__ import annotations

import argparse
import contextlib
import math
import sys
from pathlib import Path
from typing import Any, NoReturn

from hgs_core.base.storable_text import is_storable
from hgs_core.base.wording import did_you_mean

__all__ = ["BAD_INPUT", "CommandLine"]

BAD_INPUT = 2

_MOST_DIGITS = 15


class CommandLine(argparse.ArgumentParser):
    """An `ArgumentParser` with subparsers of the same class; numbers are finite and paths not empty."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        """Accept the arguments of `ArgumentParser`."""
        super().__init__(*arguments, **named)
        for kind, read in ((None, _text), (float, _number), (int, _whole_number), (Path, _path)):
            self.register("type", kind, read)

    def add_subparsers(self, **named: Any) -> Any:
        """Take the rest of the line as it is: its options read it."""
        action = super().add_subparsers(**named)
        action.type = str  # paths included
        return action

    def error(self, message: str) -> NoReturn:
        """Print one line and exit with status 2."""
        line = " ".join(message.split())
        print(f"hgs: {line[0].lower()}{line[1:]}; see {self.prog} --help", file=sys.stderr)
        raise SystemExit(BAD_INPUT)

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[Any, list[str]]:
        """Parse, and refuse an unknown argument in the subcommand where it stands."""
        parsed, unknown = super().parse_known_args(args, namespace)
        if unknown:
            known = [option for option in self._option_string_actions if option.startswith("--")]
            self.error(f"unknown argument {unknown[0]!r}{_meant(unknown[0].partition('=')[0], known)}")
        return parsed, unknown

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a value that is none of the choices."""
        choices = None if action.choices is None else [str(choice) for choice in action.choices]
        if choices is not None and value not in action.choices:  # type: ignore[operator]
            near = _meant(str(value), choices) or f"; choose from {', '.join(choices)}"
            raise argparse.ArgumentError(action, f"unknown choice {str(value)[:40]!r}{near}")


def _meant(word: str, known: list[str]) -> str:
    near = did_you_mean(word, known)
    return f"; {near}" if near else ""


def _text(text: str) -> str:
    """Return text that every database and line can hold; only paths may be bytes of another encoding."""
    with contextlib.suppress(UnicodeError):  # Python reads bytes in the C locale
        text = text.encode("utf-8", "surrogateescape").decode("utf-8")
    if not is_storable(text):
        raise argparse.ArgumentTypeError(f"{text[:40]!a} is not UTF-8 text")
    return text


def _number(text: str) -> float:
    """Return a finite number: no option means anything by NaN."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a finite number")
    return number


def _whole_number(text: str) -> int:
    digits = text.strip().removeprefix("-")
    if not (digits.isascii() and digits.isdecimal()):
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a whole number")
    if len(digits) > _MOST_DIGITS:
        raise argparse.ArgumentTypeError(f"a number of {len(digits)} digits is too large")
    return int(text)


def _path(text: str) -> Path:
    """Return a path; an empty one, as of a variable that is not set, would be the folder that one stands in."""
    if not text:
        raise argparse.ArgumentTypeError("the path is empty; . is the folder you are in")
    return Path(text)
