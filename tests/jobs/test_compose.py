"""The services of `docker compose up` as processes, started at the same moment on an empty Postgres."""

from __future__ import annotations

import json
import re
import subprocess
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
import yaml
from composition import DATABASE, FILE, SECRETS, Composition, substituted
from postgres_server import PostgresServer
from s3_server import running_s3_server

from jobs.home.stage_limits import StageLimits
from jobs.process.process_tree import THREADS_EACH
from tests.test_configuration_page import variables

Poll = Callable[[Callable[[], bool], str], None]


@pytest.fixture
def store() -> Iterator[str]:
    """An S3 server with the bucket that the file names; returns its address."""
    with running_s3_server() as server:
        urllib.request.urlopen(urllib.request.Request(f"{server.address}/hgs", method="PUT")).close()
        yield server.address


@pytest.fixture
def composition(tcp_server: PostgresServer, tmp_path: Path, port: int, store: str) -> Iterator[Composition]:
    composition = Composition(tmp_path, ("127.0.0.1", tcp_server.port), port, store)
    composition.captures.mkdir()
    user = composition.services[DATABASE]["environment"]
    assert user["POSTGRES_USER"] == "hgs"  # the test's server accepts every password
    tcp_server.new_database(user["POSTGRES_DB"])
    yield composition
    composition.stop()
    tcp_server.execute("postgres", f"DROP DATABASE {user['POSTGRES_DB']} WITH (FORCE)")


def ask(port: int, path: str, body: dict[str, Any] | None = None) -> Any:
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(
        f"http://127.0.0.1:{port}{path}", data, headers={"Content-Type": "application/json"}
    )
    with urllib.request.urlopen(request) as answer:
        return json.load(answer)


def services(**variables: str) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = yaml.safe_load(substituted(FILE.read_text(), {**SECRETS, **variables}))[
        "services"
    ]
    return found


OURS = ("api", "worker", "worker-gpu", "gc")


def test_our_services_agree_with_each_other_and_with_the_others() -> None:
    found = services()
    assert set(found) == {*OURS, DATABASE, "store", "bucket"}
    for service in OURS:
        assert found[service]["environment"] == found["api"]["environment"]
        assert found[service]["volumes"] == found["api"]["volumes"]
        assert found[service]["restart"] == "unless-stopped"
        assert found[service]["depends_on"] == {
            DATABASE: {"condition": "service_healthy"},
            "bucket": {"condition": "service_completed_successfully"},
        }
    environment, database = found["api"]["environment"], found[DATABASE]["environment"]
    url = sa.make_url(environment["HGS_DATABASE_URL"])
    assert (url.username, url.password, url.database) == (
        database["POSTGRES_USER"],
        database["POSTGRES_PASSWORD"],
        database["POSTGRES_DB"],
    )
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        assert environment[name] == found["store"]["environment"][name]
    assert environment["HGS_STORE_URL"].startswith("s3://hgs/")
    assert "s3.bucket.create -name hgs" in found["bucket"]["command"][0]


@pytest.mark.parametrize("name", sorted(SECRETS))
def test_no_secret_has_a_default(name: str) -> None:
    with pytest.raises(KeyError, match=name):
        services(**{name: ""})


def test_nothing_listens_to_other_machines_unless_that_is_asked_for() -> None:
    for service in services().values():
        assert all(port.startswith("127.0.0.1:") for port in service.get("ports", ()))
    ports = services(HGS_PRIVATE_ADDRESS="10.0.0.1")[DATABASE]["ports"]
    assert ports == ["10.0.0.1:5432:5432"]


def test_logs_do_not_grow_without_end() -> None:
    for service in services().values():
        assert service["logging"] == {"driver": "json-file", "options": {"max-size": "10m", "max-file": "5"}}


def test_processes_and_files_of_ours_are_bounded_beyond_what_stages_may_have() -> None:
    for service in OURS:
        found = services()[service]
        assert int(found["pids_limit"]) > StageLimits().processes.of("train") * THREADS_EACH
        assert found["ulimits"]["nofile"] > StageLimits().files.of("train")
        assert found["ulimits"]["core"] == 0
        assert found["init"] is True  # or those that lost their parent would count for ever
    assert services(HGS_PIDS="50000")["worker"]["pids_limit"] == 50000


def test_a_gpu_is_asked_for_by_its_profile_alone() -> None:
    found = services(HGS_GPU="1")
    assert [name for name in found if "profiles" in found[name] or "deploy" in found[name]] == ["worker-gpu"]
    assert found["worker-gpu"]["profiles"] == ["gpu"]
    (device,) = found["worker-gpu"]["deploy"]["resources"]["reservations"]["devices"]
    assert device == {"driver": "nvidia", "device_ids": ["1"], "capabilities": ["gpu"]}
    assert found["worker-gpu"]["build"]["args"] == {"TORCH": "cuda"}
    assert found["worker-gpu"]["image"] != found["worker"]["image"]


def test_torch_for_the_cpu_comes_from_its_own_index() -> None:
    text = (FILE.parent / "Dockerfile").read_text()
    assert "ARG TORCH=cpu" in text
    (line,) = [line for line in text.splitlines() if line.strip().startswith("cpu)")]
    assert "--index-url" in line
    assert line.split("--index-url ")[1].split(";")[0].endswith("/cpu")


def test_every_setting_of_jobs_can_be_given() -> None:
    settings = set(variables("Home", "Stages", "Webhooks and tidying")) - {"HGS_PIPELINE"}
    assert settings - services()["worker"]["environment"].keys() == set()
    given = services(HGS_STAGE_MEMORY="8G,train=24G")["worker"]["environment"]
    assert given["HGS_STAGE_MEMORY"] == "8G,train=24G"


PAGE = FILE.parent / "docs" / "deploy-several-machines.md"


def test_the_page_for_several_machines_has_seven_commands_that_fit_the_file() -> None:
    first, others = re.findall(r"```\n(.*?)```", PAGE.read_text(), re.DOTALL)
    commands = (*first.splitlines(), *others.splitlines())
    assert len(commands) == 5  # and two from anywhere
    for command in commands:
        assert subprocess.run(["sh", "-n", "-c", command], check=False).returncode == 0
    settings = dict(re.findall(r"(HGS_[A-Z_]+)=([^\\]+)", first.split("printf")[1].split("'")[1]))
    assert {name for name, value in settings.items() if value == "%s"} == set(SECRETS)
    found = services(**settings | SECRETS)
    assert found["worker-gpu"]["environment"]["AWS_ENDPOINT"] == "http://10.0.0.1:8333"
    assert "@10.0.0.1:5432/" in found["worker-gpu"]["environment"]["HGS_DATABASE_URL"]
    assert found["worker-gpu"]["volumes"] == ["data:/data", "./captures:/captures:ro"]
    assert found["worker-gpu"]["environment"]["HGS_RUN_STATE"] == "store"
    assert found["api"]["environment"]["HGS_OPEN"] == "0"
    assert {*found[DATABASE]["ports"], *found["store"]["ports"]} == {"10.0.0.1:5432:5432", "10.0.0.1:8333:8333"}
    for name in re.findall(r"HGS_[A-Z_]+(?==)", PAGE.read_text()):
        assert name == "HGS_KEY" or f"${{{name}:" in FILE.read_text(), f"{name} is no setting of docker-compose.yml"
    for service in re.findall(r"--scale (\w+)=|--no-deps ([\w-]+)|compose (?:run --rm|exec) (\w+)", PAGE.read_text()):
        assert "".join(service) in found


@pytest.mark.parametrize("apart", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_it_becomes_healthy_and_runs_a_job(
    composition: Composition, port: int, wait_until: Poll, tmp_path: Path, apart: bool
) -> None:
    """On one machine, or on three that share no folder."""
    processes = []
    for number, service in enumerate(("api", "worker", "worker")):
        changed = {"HGS_PIPELINE": "counting_pipeline"}  # the only thing that is not as in the file
        if apart:
            changed |= {"HGS_RUN_STATE": "store", "HGS_HOME": str(tmp_path / f"data-{number}")}
        processes.append(composition.start(service, **changed))
    (composition.captures / "take").mkdir()
    (composition.captures / "take" / "behaviour").write_text("count")

    def healthy() -> bool:
        assert all(process.poll() is None for process in processes), composition.log()
        return composition.healthy("api")

    wait_until(healthy, "the health check")
    job = ask(port, "/v1/jobs", {"capture": "take", "config": {"train.iterations": 5}})

    def finished() -> bool:
        nonlocal job
        job = ask(port, f"/v1/jobs/{job['id']}")
        return job["state"] not in ("queued", "running", "waiting")

    wait_until(finished, "the end of the job")
    assert (job["state"], job["error"]) == ("succeeded", None)
    assert [scene["id"] for scene in ask(port, "/v1/scenes")["scenes"]] == [job["id"]]
    assert all(process.poll() is None for process in processes)
    wait_until(lambda: composition.healthy("worker"), "the worker's health check")
