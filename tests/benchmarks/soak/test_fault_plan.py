from __future__ import annotations

from benchmarks.soak.fault_plan import CALM, Fault, plan_faults


def test_a_seed_decides_everything() -> None:
    assert plan_faults(7, 300) == plan_faults(7, 300)
    assert plan_faults(7, 300) != plan_faults(8, 300)


def test_an_hour_has_every_kind_and_more_than_a_hundred() -> None:
    plan = plan_faults(1, 3600)
    assert {fault.kind for fault in plan} == set(Fault)
    assert len(plan) > 100


def test_every_fault_ends_with_the_soak() -> None:
    assert all(fault.at + fault.seconds <= 600 for fault in plan_faults(3, 600))


def test_api_and_workers_live_on_in_the_last_part() -> None:
    late = {fault.kind for fault in plan_faults(1, 3600) if fault.at > CALM * 3600}
    assert Fault.KILL_STAGE in late
    assert not late & {Fault.KILL_API, Fault.KILL_WORKER, Fault.STOP_API, Fault.STOP_WORKER}
