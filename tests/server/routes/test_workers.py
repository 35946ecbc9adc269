from __future__ import annotations

from typing import Any

from jobs.records.worker_register import Worker


def test_the_workers_and_their_slots(server: Any) -> None:
    server.jobs.alive = (
        Worker("node-1-7-ab", "node-1", 7, "0", "studio-1", "", 1.0, 2.0),
        Worker("node-2-8-cd", "node-2", 8, "", "", "the home is away", 1.0, 2.0),
    )
    answer = server.get("/v1/workers").json()
    assert (answer["slots"], answer["busy"]) == (2, 1)
    assert answer["workers"] == [
        {
            "id": "node-1-7-ab",
            "host": "node-1",
            "pid": 7,
            "device": "0",
            "job": "studio-1",
            "idle_because": None,
            "started": 1.0,
            "seen": 2.0,
        },
        {
            "id": "node-2-8-cd",
            "host": "node-2",
            "pid": 8,
            "device": None,
            "job": None,
            "idle_because": "the home is away",
            "started": 1.0,
            "seen": 2.0,
        },
    ]
