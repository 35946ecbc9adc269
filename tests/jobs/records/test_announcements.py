from __future__ import annotations

import json
import time

import pytest
import sqlalchemy as sa

from jobs.records import announcements as webhook_table
from jobs.records.announcements import Announcement, WebhookTable
from jobs.records.job import Job
from jobs.records.job_table import JobTable


@pytest.fixture
def table(engine: sa.Engine) -> JobTable:
    table = JobTable(engine)
    with engine.begin() as connection:
        job = Job("a", "A", "/captures/a", {}, webhook="https://hooks.example.org/x", labels=("night",))
        table.insert(connection, job)
        table.insert(connection, Job("quiet", "B", "/captures/b", {}))
    return table


@pytest.fixture
def webhooks(engine: sa.Engine) -> WebhookTable:
    return WebhookTable(engine)


def taken(webhooks: WebhookTable) -> Announcement:
    one = webhooks.take()
    assert one is not None
    return one


def kept(webhooks: WebhookTable) -> Announcement:
    one = webhooks.of("a")
    assert one is not None
    return one


def test_the_end_of_a_job_is_to_be_told(table: JobTable, webhooks: WebhookTable) -> None:
    table.start("a", 1)
    assert webhooks.take() is None
    table.succeed("a", 1, "a")
    one = taken(webhooks)
    assert (one.job_id, one.attempt, one.url) == ("a", 1, "https://hooks.example.org/x")
    body = json.loads(one.body)
    assert (body["type"], body["timestamp"]) == ("job.succeeded", one.ended)
    assert body["data"] == {
        "id": "a",
        "attempt": 1,
        "state": "succeeded",
        "title": "A",
        "labels": ["night"],
        "capture": "/captures/a",
        "scene": "a",
        "error": None,
    }


def test_an_end_is_told_once(table: JobTable, webhooks: WebhookTable) -> None:
    table.cancel("a", 1)
    table.fail("a", 1, "too late")
    table.cancel("quiet", 1)
    assert json.loads(taken(webhooks).body)["type"] == "job.cancelled"
    assert webhooks.take() is None


def test_what_a_dead_process_took_is_taken_again(
    table: JobTable, webhooks: WebhookTable, monkeypatch: pytest.MonkeyPatch
) -> None:
    table.cancel("a", 1)
    first = taken(webhooks)
    monkeypatch.setattr(time, "time", lambda now=time.time(): now + webhook_table.LEASE + 1)  # noqa: B008
    second = taken(webhooks)
    webhooks.delivered(first)  # it lived after all: the later one counts
    assert kept(webhooks).delivered == 0
    webhooks.delivered(second)
    assert kept(webhooks).delivered > 0


def test_the_pauses_grow_and_end_after_three_days(
    table: JobTable, webhooks: WebhookTable, monkeypatch: pytest.MonkeyPatch
) -> None:
    table.cancel("a", 1)
    now = began = time.time()
    monkeypatch.setattr(time, "time", lambda: now)
    pauses = []
    while (one := webhooks.take()) is not None:
        webhooks.failed(one, "nobody listens")
        later = kept(webhooks).next_try
        if later is None:
            break
        pauses.append(later - now)
        now = later
    assert pauses[:5] == pytest.approx([5, 10, 20, 40, 80])
    assert max(pauses) == pytest.approx(3600)
    assert 2.9 * 86400 < now - began <= 3 * 86400
    assert (kept(webhooks).error, kept(webhooks).tries) == ("nobody listens", len(pauses) + 1)


def test_what_is_no_use_is_given_up_at_once(table: JobTable, webhooks: WebhookTable) -> None:
    table.cancel("a", 1)
    webhooks.failed(taken(webhooks), "gone", for_good=True)
    assert kept(webhooks).next_try is None
