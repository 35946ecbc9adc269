from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from jobs.home.home import Home
from jobs.queue.liveness import FileLiveness, PostgresLiveness, open_liveness

HOLDER = """
import sys
from pathlib import Path
from jobs.queue.liveness import FileLiveness
FileLiveness(Path(sys.argv[1])).hold("other", lambda: None)
print("holds", flush=True)
sys.stdin.read()
"""


def is_dead(liveness: FileLiveness, executor: str) -> bool:
    with liveness.claim_dead(executor) as dead:
        return dead


def test_a_worker_is_alive_until_its_process_is_killed(tmp_path: Path) -> None:
    command = [sys.executable, "-c", HOLDER, str(tmp_path)]
    liveness = FileLiveness(tmp_path)
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"holds\n"
        assert not is_dead(liveness, "other")
        process.kill()
        process.wait()
        assert is_dead(liveness, "other")


def test_a_worker_that_left_no_file_is_dead(tmp_path: Path) -> None:
    assert is_dead(FileLiveness(tmp_path), "nobody")


def test_only_one_can_claim_a_dead_worker_at_a_time(tmp_path: Path) -> None:
    (tmp_path / "other").touch()
    with FileLiveness(tmp_path).claim_dead("other") as first, FileLiveness(tmp_path).claim_dead("other") as second:
        assert (first, second) == (True, False)


def test_starting_sweeps_the_files_of_the_dead(tmp_path: Path) -> None:
    (tmp_path / "other").touch()
    liveness = FileLiveness(tmp_path)
    liveness.hold("me", lambda: None)
    assert [path.name for path in tmp_path.iterdir()] == ["me"]
    assert not is_dead(FileLiveness(tmp_path), "me")


def test_the_kind_follows_the_database(tmp_path: Path) -> None:
    assert isinstance(open_liveness(Home.at(tmp_path)), FileLiveness)
    postgres = Home(tmp_path, "postgresql://localhost/hgs", "file:///")
    assert isinstance(open_liveness(postgres), PostgresLiveness)
