"""The audit of dependencies, on answers as pip-audit 2.10 and npm 10 print them."""

from __future__ import annotations

import json
import sys
from typing import Any

import pytest

from scripts import audit_dependencies as audit

SOUND = {"name": "h11", "version": "0.16.0", "vulns": []}
FAULTY = {"name": "h11", "version": "0.14.0", "vulns": [{"id": "CVE-2025-43859", "fix_versions": ["0.16.0"]}]}
UNKNOWN = {"name": "hgs", "skip_reason": "distribution marked as editable"}
NPM_SOUND: dict[str, Any] = {"vulnerabilities": {}, "metadata": {"dependencies": {"total": 120}}}
NPM_FAULTY = NPM_SOUND | {"vulnerabilities": {"vite": {"range": "<8.0.1", "severity": "high"}}}


def prints(told: object, status: int = 0) -> list[str]:
    text = told if isinstance(told, str) else json.dumps(told)
    return [
        sys.executable,
        "-c",
        f"import sys; print({text!r}); print('no route', file=sys.stderr); sys.exit({status})",
    ]


@pytest.mark.parametrize(
    ("pip", "npm", "status", "line"),
    [
        ([SOUND, UNKNOWN], NPM_SOUND, 0, "pip-audit: 1 packages, 0 with advisories"),
        ([FAULTY], NPM_SOUND, 1, "h11 0.14.0: CVE-2025-43859; install 0.16.0"),
        ([SOUND], NPM_FAULTY, 1, "vite <8.0.1: high; npm audit fix in web_client"),
    ],
)
def test_an_advisory_fails_and_is_named(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    pip: list[dict[str, Any]],
    npm: dict[str, Any],
    status: int,
    line: str,
) -> None:
    monkeypatch.setattr(audit, "PIP", prints({"dependencies": pip}, status))
    monkeypatch.setattr(audit, "NPM", prints(npm, status))
    assert audit.main() == status
    assert line in capsys.readouterr().out.splitlines()


@pytest.mark.parametrize(
    ("pip", "npm", "lines"),
    [
        (
            prints("", 1),
            ["/no/such/npm"],
            ["pip-audit is skipped: no route", "npm audit is skipped: /no/such/npm is not"],
        ),
        (
            prints({"dependencies": [UNKNOWN]}),
            prints({"message": "405 Method Not Allowed"}, 1),
            ["pip-audit is skipped: no advisories are known for any", "npm audit is skipped: 405 Method Not Allowed"],
        ),
    ],
)
def test_an_audit_without_an_answer_is_skipped_and_says_so(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    pip: list[str],
    npm: list[str],
    lines: list[str],
) -> None:
    monkeypatch.setattr(audit, "PIP", pip)
    monkeypatch.setattr(audit, "NPM", npm)
    assert audit.main() == 0
    told = capsys.readouterr()
    assert told.out == ""
    for line in lines:
        assert line in told.err
