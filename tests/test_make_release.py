"""The lists of a release, made of reports as pip 23 and npm 10 write them."""

from __future__ import annotations

import base64
import subprocess
import sys
from pathlib import Path
from typing import Any

from scripts.make_release import IMPORTED, list_of_parts, pinned
from tests.conftest import REPOSITORY


def installed(name: str, version: str, file: str, **metadata: str) -> dict[str, Any]:
    facts = {"url": f"file:///somewhere/{file}", "archive_info": {"hashes": {"sha256": name[0] * 64}}}
    return {"download_info": facts, "metadata": {"name": name, "version": version, **metadata}}


REPORT = {
    "install": [
        installed("hgs", "0.1.0", "hgs-0.1.0-py3-none-linux_x86_64.whl", license_expression="Apache-2.0"),
        installed("h11", "0.16.0", "h11-0.16.0-py3-none-any.whl", license="MIT"),
        installed("DBOS", "3.4.0", "dbos-3.4.0-py3-none-any.whl"),
    ]
}
LOCK = {
    "packages": {
        "": {"name": "@hgs/player", "peerDependencies": {"vue": "*"}},
        "node_modules/@noble/hashes": {"version": "2.4.0", "integrity": f"sha512-{base64.b64encode(b'n').decode()}"},
        "node_modules/vite": {"version": "8.0.0", "integrity": "sha512-dg=="},
        "node_modules/vue": {"version": "3.5.0", "integrity": "sha512-dg=="},
        "node_modules/vite/node_modules/@noble/hashes": {"version": "1.0.0", "integrity": "sha512-dg=="},
    }
}


def test_every_package_is_pinned_by_its_digest_and_the_wheel_by_its_file() -> None:
    assert pinned(REPORT, Path("/made/dist")).splitlines() == [
        f"./dist/hgs-0.1.0-py3-none-linux_x86_64.whl --hash=sha256:{'h' * 64}",
        f"DBOS==3.4.0 --hash=sha256:{'D' * 64}",
        f"h11==0.16.0 --hash=sha256:{'h' * 64}",
    ]


def test_the_list_of_parts_has_python_packages_and_those_of_the_viewer() -> None:
    made = list_of_parts(REPORT, LOCK, {"@noble/hashes", "vue"})
    assert (made["bomFormat"], made["specVersion"]) == ("CycloneDX", "1.6")
    assert made["metadata"]["component"]["purl"] == "pkg:pypi/hgs@0.1.0"
    found = {one["purl"]: one for one in made["components"]}
    assert list(found) == ["pkg:pypi/h11@0.16.0", "pkg:pypi/dbos@3.4.0", "pkg:npm/%40noble/hashes@2.4.0"]
    assert found["pkg:pypi/h11@0.16.0"]["hashes"] == [{"alg": "SHA-256", "content": "h" * 64}]
    assert found["pkg:pypi/h11@0.16.0"]["licenses"] == [{"license": {"name": "MIT"}}]
    assert found["pkg:npm/%40noble/hashes@2.4.0"]["hashes"] == [{"alg": "SHA-512", "content": b"n".hex()}]
    assert made["dependencies"][0]["dependsOn"] == list(found)
    assert list_of_parts(REPORT, LOCK, {"@noble/hashes", "vue"}) == made  # equal parts, equal bytes


def test_a_folder_that_is_there_is_refused(tmp_path: Path) -> None:
    command = [sys.executable, REPOSITORY / "scripts" / "make_release.py", tmp_path]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 2
    assert f"{tmp_path} is there already; give another folder" in ended.stderr


def test_the_viewers_imports_are_found() -> None:
    assert IMPORTED.findall('import { x } from "@noble/hashes/sha2.js"; import("three"); from "./own.js"') == [
        "@noble/hashes",
        "three",
    ]
