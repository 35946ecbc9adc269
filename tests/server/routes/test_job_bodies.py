"""Bodies that mean harm, against the real queue on SQLite: a job is there if and only if the answer is 201."""

from __future__ import annotations

import asyncio
import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import httpx
import pytest
from fastapi import FastAPI
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hgs_core.base.config_fields import flat_fields
from hgs_core.runs.run_config import RunConfig
from jobs.home.home import Home
from jobs.queue.client import JobClient
from server.app import create_app
from server.captures.capture_folders import CaptureFolders

MODULES = Path(__file__).parents[1] / "modules"


@dataclasses.dataclass
class Queue:
    """An application on a home of its own."""

    app: FastAPI
    client: JobClient

    def request(self, method: str, path: str, body: bytes = b"") -> httpx.Response:
        async def send() -> httpx.Response:
            transport = httpx.ASGITransport(self.app, raise_app_exceptions=False)
            async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
                return await client.request(method, path, content=body, headers={"Content-Type": "application/json"})

        return asyncio.run(send())

    def get(self, path: str) -> httpx.Response:
        return self.request("GET", path)

    def post(self, body: bytes) -> httpx.Response:
        return self.request("POST", "/v1/jobs", body)

    def stored(self) -> tuple[int, int]:
        """Return how many jobs and how many run folders there are."""
        return len(self.client.list(1000)), len(list(self.client.home.runs.iterdir()))


@pytest.fixture
def queue(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Queue]:
    monkeypatch.syspath_prepend(MODULES)
    (tmp_path / "captures" / "studio" / "scene").mkdir(parents=True)
    home = dataclasses.replace(Home.at(tmp_path / "home"), pipeline="ready_pipeline")
    with JobClient(home) as client:
        captures = CaptureFolders(((tmp_path / "captures").resolve(),))
        yield Queue(create_app(home, captures=captures, job_client=client), client)


NUMBERS = ["Infinity", "-Infinity", "NaN", "1e300", "1e400", "-1e400", "9" * 400, "-" + "9" * 400, "9" * 5000]
FIELDS = list(flat_fields(RunConfig().to_json()))
PARTS = ["capture", "points", "train", "encode", "train.density", "train.labels", "train.learning_rates"]
RATES = list(RunConfig().to_json()["train"]["learning_rates"])
STRINGS = [r'"\ud800"', r'"a\udfffb"', r'"a\u0000b"']
PLACES = [
    *(f'{{"capture": "studio", "config": {{"{name}": %s}}}}' for name in (*FIELDS, *PARTS)),
    *(f'{{"capture": "studio", "config": {{"train": {{"learning_rates": {{"{name}": %s}}}}}}}}' for name in RATES),
    '{"capture": %s}',
    *(f'{{"capture": "studio", "{name}": %s}}' for name in ("title", "preset", "hold_out", "config", "masks", "x")),
    '{"capture": "studio", "hold_out": [%s]}',
    '{"capture": "studio", "config": {"capture.hold_out": [%s]}}',
    "%s",
    "[%s]",
]
NAMES = ['{%s: "studio"}', '{"capture": "studio", "config": {%s: 1}}']


def test_no_bad_value_in_any_place_is_queued_or_breaks_the_server(queue: Queue) -> None:
    for place, value in (
        *((place, value) for place in PLACES for value in (*NUMBERS, *STRINGS)),
        *((place, value) for place in NAMES for value in STRINGS),
    ):
        answer = queue.post((place % value).encode())
        assert answer.status_code == 422, (place, value[:20], answer.text)
        assert answer.headers["content-type"] == "application/problem+json"
        answer.json()["detail"].encode()
    assert queue.stored() == (0, 0)


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ('{"capture": "studio", "config": {"train.learning_rates.rgb": Infinity}}', "config.train.learning_rates.rgb"),
        ('{"capture": "studio", "config": {"train.learning_rates": {"rgb": 11}}}', "config.train.learning_rates.rgb"),
        ('{"capture": "studio", "config": {"train.iterations": %s}}' % ("9" * 400), "config.train.iterations"),
        ('{"capture": "studio", "config": {"train.iterations": 1e300}}', "config.train.iterations"),
        ('{"capture": "studio", "config": {"train.checkpoint_every": 1000000000}}', "config.train.checkpoint_every"),
        (r'{"capture": "studio", "title": "a\u0000b"}', "title"),
        (r'{"capture": "studio", "title": "two\nlines"}', "title"),
        ('{"capture": "studio", "title": "%s"}' % ("x" * 201), "title"),
        (r'{"capture": "studio", "hold_out": ["cam00", "\ud800"]}', "hold_out.1"),
        ('{"capture": "studio", "hold_out": ["%s"]}' % ("x" * 256), "hold_out"),
        (r'{"capture": "studio", "config": {"\ud800": 1}}', "config"),
        ('{"capture": "studio", "preset": "imported"}', "preset"),
    ],
)
def test_the_field_is_named(queue: Queue, body: str, field: str) -> None:
    answer = queue.post(body.encode())
    assert (answer.status_code, answer.json()["field"]) == (422, field)
    assert queue.stored() == (0, 0)


texts = st.text(st.characters(), max_size=8)  # halves of surrogate pairs and NUL among them
json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | texts,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=6,
)
fields = st.sampled_from([*FIELDS, *PARTS])
rates = st.sampled_from(RATES)
bodies = st.one_of(
    json_values,
    st.fixed_dictionaries(
        {"capture": st.just("studio") | json_values},
        optional={
            "title": json_values,
            "preset": st.sampled_from(["preview", "best"]) | json_values,
            "hold_out": st.lists(texts, max_size=3) | json_values,
            "config": json_values
            | st.dictionaries(fields, json_values, max_size=2)
            | st.fixed_dictionaries({"learning_rates": st.dictionaries(rates, json_values, max_size=2)}),
        },
    ),
)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(body=bodies)
def test_a_job_is_there_if_and_only_if_the_answer_is_201(queue: Queue, body: Any) -> None:
    before = queue.stored()
    answer = queue.post(json.dumps(body).encode())
    assert answer.status_code < 500, answer.text
    queued = int(answer.status_code == 201)
    assert queue.stored() == (before[0] + queued, before[1] + queued)
    if queued:
        assert queue.get(f"/v1/{answer.headers['location']}").json() == answer.json()


def test_a_row_that_no_answer_could_hold_breaks_neither_the_list_nor_its_job(queue: Queue) -> None:
    job = queue.post(b'{"capture": "studio"}').json()
    config = {"preset": "best", "train": {"iterations": float("inf")}, "capture": {"hold_out": ["\ud800"]}}
    with queue.client._engine.begin() as connection:  # a row beyond JSON
        connection.exec_driver_sql("UPDATE hgs_job SET config = ?, state = 'failed'", (json.dumps(config),))
    (listed,) = queue.get("/v1/jobs").json()["jobs"]
    assert listed == queue.get(f"/v1/jobs/{job['id']}").json()
    assert (listed["config"]["train"]["iterations"], listed["hold_out"]) == (None, ["\ufffd"])
    assert json.dumps(listed["title"]) in queue.get(f"/v1/jobs/{job['id']}/events").text


def test_pages_of_the_list_are_all_jobs_once_and_the_running_one_first(queue: Queue) -> None:
    ids = [queue.post(b'{"capture": "studio"}').json()["id"] for _ in range(7)]
    queue.client._table.start(ids[0], 1)
    pages = [queue.get("/v1/jobs?limit=3").json()]
    while pages[-1]["next"]:
        pages.append(queue.get(f"/v1/jobs?limit=3&after={quote(pages[-1]['next'])}").json())
    assert [[job["id"] for job in page["jobs"]] for page in pages] == [[ids[0], ids[6], ids[5]], ids[4:1:-1], [ids[1]]]


@pytest.mark.parametrize("value", ["Infinity", "-Infinity", "NaN", "1e300", "1e400", "9" * 400])
def test_a_number_out_of_range_is_refused_with_its_name_and_its_range(queue: Queue, value: str) -> None:
    told = queue.post(b'{"capture": "studio", "config": {"train.iterations": %s}}' % value.encode()).json()
    assert (told["code"], told["field"]) == ("config-invalid", "config.train.iterations")
    shown = {"Infinity": "inf", "-Infinity": "-inf", "NaN": "nan", "1e300": "1e+300"}.get(value, "inf")
    assert told["detail"] == (
        f"config.train.iterations: {shown} is out of range; give a whole number from 1 to 1000000"
    )
