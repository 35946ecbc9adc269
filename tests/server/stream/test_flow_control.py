from __future__ import annotations

import pytest

from server.protocol.messages import HEADER_BYTES, MAX_BALANCE, MAX_PAYLOAD, MIN_PAYLOAD, ProtocolError
from server.stream.flow_control import FAST, SHORT_PAYLOAD, UNKNOWN_BYTES, FlowControl


@pytest.fixture
def flow() -> FlowControl:
    """Credit for two of the longest frames, on a fast line."""
    flow = FlowControl()
    flow.measured = FAST
    flow.grant(2 * (MAX_PAYLOAD + HEADER_BYTES))
    return flow


def test_a_frame_costs_its_header_too(flow: FlowControl) -> None:
    assert flow.spend(100, 0.0) == 100
    assert flow.balance == 2 * (MAX_PAYLOAD + HEADER_BYTES) - 100 - HEADER_BYTES
    assert flow.sent_bytes == 100


def test_a_frame_that_is_not_sent_is_paid_back(flow: FlowControl) -> None:
    before = flow.balance
    assert flow.spend(1000, 0.0) == 1000
    flow.refund(1000)
    assert (flow.balance, flow.sent_bytes) == (before, 0)


def test_frames_are_cut_to_the_longest_and_to_the_credit(flow: FlowControl) -> None:
    assert flow.spend(5 * MAX_PAYLOAD, 0.0) == MAX_PAYLOAD
    flow.spend(1000, 0.0)
    assert flow.spend(5 * MAX_PAYLOAD, 0.0) == MAX_PAYLOAD - 1000 - HEADER_BYTES
    assert flow.balance == 0
    assert flow.spend(1, 0.0) is None


def test_frames_are_short_on_lines_that_are_slow_or_not_known_yet() -> None:
    """The smallest window, of 64 KiB, holds several of them: credit comes back while the next are on their way."""
    flow = FlowControl()
    flow.grant(MAX_BALANCE)
    while flow.sent_bytes < UNKNOWN_BYTES:
        assert flow.spend(1 << 30, 0.0) == SHORT_PAYLOAD <= (64 << 10) / 4
    assert flow.spend(1 << 30, 0.0) == MAX_PAYLOAD
    flow.measured = FAST - 1
    assert flow.spend(1 << 30, 0.0) == SHORT_PAYLOAD
    flow.measured = FAST
    assert flow.spend(1 << 30, 0.0) == MAX_PAYLOAD


def test_credit_for_less_than_the_least_frame_waits_for_more() -> None:
    flow = FlowControl()
    flow.grant(HEADER_BYTES + MIN_PAYLOAD - 1)
    assert flow.spend(MIN_PAYLOAD, 0.0) is None
    assert flow.spend(MIN_PAYLOAD - 1, 0.0) == MIN_PAYLOAD - 1


def test_a_limited_rate_is_kept_and_no_more_than_an_eighth_of_a_second_goes_at_once(flow: FlowControl) -> None:
    flow.bytes_per_second = 80_000
    clock, sent = 100.0, 0
    while clock < 101.0:
        if (wait := flow.wait(clock)) is not None:
            clock += wait
            continue
        length = flow.spend(1 << 30, clock)
        assert length is not None
        assert length <= 10_000
        sent += length + HEADER_BYTES
    assert 80_000 <= sent <= 80_000 + 2 * (10_000 + HEADER_BYTES)


def test_credit_beyond_the_largest_balance_is_refused() -> None:
    flow = FlowControl()
    flow.grant(MAX_BALANCE)
    with pytest.raises(ProtocolError) as caught:
        flow.grant(1)
    assert (caught.value.closing.code, caught.value.closing.error) == (4009, "credit-overflow")
    assert flow.balance == MAX_BALANCE
