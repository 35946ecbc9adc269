#!/usr/bin/env python3
"""Compare the installed Python packages and web_client's locked npm packages with published advisories.

The status is 1 where one of them has an advisory. Advisories come over the network: an audit without an answer is
skipped, and says so.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

REPOSITORY = Path(__file__).resolve().parent.parent

PIP = [sys.executable, "-m", "pip_audit", "--skip-editable", "--progress-spinner", "off", "--format", "json"]
NPM = ["npm", "audit", "--json", "--prefix", "web_client"]
SECONDS = 300  # longest wait for an answer


class NoAnswerError(Exception):
    """No advisories came; the message says why."""


def main() -> int:
    found: list[str] = []
    for name, command, read in (("pip-audit", PIP, read_pip), ("npm audit", NPM, read_npm)):
        try:
            packages, faults = read(answer(command))
        except NoAnswerError as error:
            print(f"{name} is skipped: {error}", file=sys.stderr)
            continue
        print(f"{name}: {packages} packages, {len(faults)} with advisories")
        found += faults
    print("\n".join(found), end="\n" if found else "")
    return bool(found)


def answer(command: list[str]) -> dict[str, Any]:
    """Return the JSON that a program prints, with any exit status."""
    try:
        ended = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, timeout=SECONDS, check=False)
        told = json.loads(ended.stdout)
    except FileNotFoundError:
        raise NoAnswerError(f"{command[0]} is not installed") from None
    except subprocess.TimeoutExpired:
        raise NoAnswerError(f"it did not end in {SECONDS} s") from None
    except ValueError:
        lines = [line for line in ended.stderr.splitlines() if line.strip()]
        raise NoAnswerError(lines[-1] if lines else "it printed no JSON") from None
    return dict(told)


def read_pip(told: dict[str, Any]) -> tuple[int, list[str]]:
    """Return the number of packages that were compared, and a line for each advisory."""
    compared = [one for one in told["dependencies"] if "skip_reason" not in one]
    if not compared:
        raise NoAnswerError("no advisories are known for any package")
    faults = [
        f"{one['name']} {one['version']}: {fault['id']}; install {' or '.join(fault['fix_versions']) or 'another'}"
        for one in compared
        for fault in one["vulns"]
    ]
    return len(compared), faults


def read_npm(told: dict[str, Any]) -> tuple[int, list[str]]:
    """Return the number of packages that were compared, and a line for each with an advisory."""
    if "vulnerabilities" not in told:
        raise NoAnswerError(str(told.get("message") or told.get("error") or "it named no packages"))
    faults = [
        f"{name} {one['range']}: {one['severity']}; npm audit fix in web_client"
        for name, one in told["vulnerabilities"].items()
    ]
    return int(told["metadata"]["dependencies"]["total"]), faults


if __name__ == "__main__":
    sys.exit(main())
