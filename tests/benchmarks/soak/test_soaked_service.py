from __future__ import annotations

from benchmarks.soak.soaked_service import Extras


def test_it_is_said_what_is_left_out() -> None:
    assert len(Extras().missing()) == 3
    assert Extras(old_revision="HEAD~1", small_disk=True, clocks=True).missing() == []
