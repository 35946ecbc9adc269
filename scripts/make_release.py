#!/usr/bin/env python3
"""Build a release: the wheel, its dependencies pinned by digest for this platform, and a list of its parts.

    scripts/make_release.py dist
    pip install --require-hashes -r dist/requirements.txt     # on the other machine, in dist's parent folder

`dist/hgs-VERSION.cdx.json` is a CycloneDX 1.6 list of the Python packages, and of the npm packages of the viewer.
"""

from __future__ import annotations

import argparse
import base64
import hashlib
import json
import re
import subprocess
import sys
import uuid
from pathlib import Path
from typing import Any

REPOSITORY = Path(__file__).resolve().parent.parent
PIP = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q"]

IMPORTED = re.compile(r"(?:from|import)\(?\s*\"((?:@[\w.-]+/)?[\w-][\w.-]*)")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="a folder that is not there yet")
    out: Path = parser.parse_args().out
    if out.exists():
        parser.error(f"{out} is there already; give another folder")
    if not (REPOSITORY / "server" / "viewer" / "index.html").exists():
        parser.error("server/viewer is not built; run scripts/install")
    subprocess.run([*PIP, "wheel", "--no-deps", "-w", out, REPOSITORY], check=True)
    (wheel,) = out.glob("*.whl")
    resolve = ["install", "--dry-run", "--ignore-installed", "--only-binary", ":all:", "--report", "-", wheel]
    report = json.loads(subprocess.run([*PIP, *resolve], check=True, capture_output=True, text=True).stdout)
    (out / "requirements.txt").write_text(pinned(report, out))
    lock = json.loads((REPOSITORY / "web_client" / "package-lock.json").read_text())
    sources = (path.read_text() for path in (REPOSITORY / "web_client" / "src").rglob("*.ts"))
    parts = list_of_parts(report, lock, {name for text in sources for name in IMPORTED.findall(text)})
    (out / f"{'-'.join(wheel.name.split('-')[:2])}.cdx.json").write_text(json.dumps(parts, indent=1))
    return 0


def pinned(report: dict[str, Any], folder: Path) -> str:
    """Return requirements that pip takes with --require-hashes: one file for each package, the wheel in `folder`."""
    lines = []
    for one in report["install"]:
        wanted = f"{one['metadata']['name']}=={one['metadata']['version']}"
        if one["metadata"]["name"] == "hgs":
            wanted = f"./{folder.name}/{one['download_info']['url'].rpartition('/')[2]}"
        lines.append(f"{wanted} --hash=sha256:{_digest(one)}\n")
    return "".join(sorted(lines, key=str.lower))


def list_of_parts(report: dict[str, Any], lock: dict[str, Any], imported: set[str]) -> dict[str, Any]:
    """Return the CycloneDX document; of the locked npm packages those `imported` by the viewer's sources are in it."""
    components = [_component("pypi", one["metadata"], {"SHA-256": _digest(one)}) for one in report["install"]]
    (own,) = (one for one in components if one["name"] == "hgs")
    elsewhere = lock["packages"][""].get("peerDependencies", {})  # the embedding page's own
    for path, one in lock["packages"].items():
        name = path.rpartition("node_modules/")[2]
        if path == f"node_modules/{name}" and name in imported and name not in elsewhere:
            digest = base64.b64decode(one["integrity"].removeprefix("sha512-")).hex()
            components.append(_component("npm", one | {"name": name}, {"SHA-512": digest}))
    parts = [one for one in components if one is not own]
    text = json.dumps(components, sort_keys=True)
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "serialNumber": f"urn:uuid:{uuid.UUID(bytes=hashlib.sha256(text.encode()).digest()[:16], version=4)}",
        "version": 1,
        "metadata": {"component": own | {"type": "application"}},
        "components": parts,
        "dependencies": [{"ref": own["bom-ref"], "dependsOn": [one["bom-ref"] for one in parts]}],
    }


def _digest(one: dict[str, Any]) -> str:
    return str(one["download_info"]["archive_info"]["hashes"]["sha256"])


def _component(kind: str, told: dict[str, Any], digests: dict[str, str]) -> dict[str, Any]:
    name, version = told["name"], told["version"]
    where = f"pkg:{kind}/{name.lower().replace('@', '%40')}@{version}"
    licence = told.get("license_expression") or told.get("license")
    return {
        "type": "library",
        "bom-ref": where,
        "name": name,
        "version": version,
        "purl": where,
        "hashes": [{"alg": algorithm, "content": digest} for algorithm, digest in digests.items()],
        **({"licenses": [{"license": {"name": licence.splitlines()[0][:100]}}]} if licence else {}),
    }


if __name__ == "__main__":
    sys.exit(main())
