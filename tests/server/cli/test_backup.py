"""`hgs backup` and `hgs restore`, of the home of a server that runs."""

from __future__ import annotations

import os
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import httpx
import pytest

from jobs.home.home import Home
from jobs.records.keys import KeyTable, Scope
from server.cli import main
from tests.server.cli.test_serve import REPOSITORY, serving


def hgs(home: Path, *arguments: object) -> str:
    command = [sys.executable, "-m", "server.cli", *map(str, arguments)]
    environment = os.environ | {"HGS_HOME": str(home)}
    return subprocess.run(command, env=environment, cwd=REPOSITORY, capture_output=True, text=True, check=True).stdout


@pytest.mark.slow
def test_a_server_on_the_restored_home_plays_its_scenes_to_the_same_keys_and_links(
    scene_folder: Path, tmp_path: Path, chunks: list[bytes]
) -> None:
    home, backup, elsewhere = tmp_path / "home", tmp_path / "backup", tmp_path / "other" / "home"
    with closing(KeyTable(Home.at(home))) as table:
        key = table.add("anna", {Scope.SUBMIT})
    bearer = {"Authorization": f"Bearer {key}"}
    with serving(home, scene_folder, "--workers", 0) as (_, page):
        link = hgs(home, "keys", "link", "studio-run").strip().partition("?")[2]
        upload = {"name": "a", "files": 1, "bytes": 5}
        address = page.partition("/view")[0]
        begun = httpx.post(f"{address}/v1/uploads", json=upload, headers=bearer).json()
        told = hgs(home, "backup", backup)
        assert told.startswith(f"{backup}: ")
    assert str(elsewhere) in hgs(elsewhere, "restore", backup)
    with (
        serving(elsewhere, "--workers", 0) as (_, page),
        httpx.Client(base_url=page.rstrip("/"), headers=bearer) as client,
    ):
        manifest = client.get("/v1/scenes/studio-run/manifest").raise_for_status().json()
        assert manifest["title"] == "Studio"
        for entry in manifest["static"]:
            assert client.get(f"/v1/chunks/{entry['id']}").content in chunks
        assert httpx.get(f"{page.rstrip('/')}/v1/scenes/studio-run/manifest?{link}").status_code == 200
        assert httpx.get(f"{page.rstrip('/')}/v1/scenes/studio-run/manifest").status_code == 401
        assert client.get(f"/v1/uploads/{begun['id']}").json()["state"] == "receiving"


def test_bad_input_is_one_line(home: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["backup", str(tmp_path / "copy")]) == 2
    assert "holds no home; give the HGS_HOME of the server" in capsys.readouterr().err
