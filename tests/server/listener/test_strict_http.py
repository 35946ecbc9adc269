from __future__ import annotations

import itertools

import h11
import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.listener.strict_http import BadRequestError, StrictConnection

LINES = [b"POST /v1/jobs HTTP/1.1", b"Host: localhost", b"X-Name: value", b"Content-Length: 5"]


def read(*pieces: bytes) -> list[h11.Event]:
    """The events of a connection over which this comes."""
    connection, events = StrictConnection(), []
    for piece in filter(None, pieces):  # an empty one would be the end
        connection.receive_data(piece)
        while not isinstance(event := connection.next_event(), type):
            events.append(event)
    return events


def refused(*pieces: bytes) -> BadRequestError:
    with pytest.raises(BadRequestError) as caught:
        read(*pieces)
    return caught.value


def whole(*lines: bytes) -> bytes:
    return b"\r\n".join((*lines, b"", b""))


@given(st.lists(st.integers(1, 90), max_size=6))
def test_a_decent_request_is_read_however_it_is_cut(places: list[int]) -> None:
    text = whole(*LINES) + b"hello"
    cuts = sorted({0, len(text), *places})
    request, *rest = read(*(text[a:b] for a, b in itertools.pairwise(cuts)))
    assert isinstance(request, h11.Request)
    assert request.headers[2] == (b"content-length", b"5")
    assert b"".join(event.data for event in rest if isinstance(event, h11.Data)) == b"hello"
    assert isinstance(rest[-1], h11.EndOfMessage)


@given(st.sampled_from(range(len(LINES) + 1)), st.sampled_from([b"\n", b"\r", b"\n\r"]), st.integers(1, 90))
def test_a_line_that_does_not_end_with_both_is_refused(broken: int, end: bytes, cut: int) -> None:
    ends = [b"\r\n"] * (len(LINES) + 1)
    ends[broken] = end
    text = b"".join(line + end for line, end in zip((*LINES, b""), ends, strict=True)) + b"hello\r\n\r\n"
    assert "CR LF" in str(refused(text[:cut], text[cut:]))


@pytest.mark.parametrize("space", [b" ", b"\t", b" \t "])
def test_a_folded_line_is_refused(space: bytes) -> None:
    assert "continues on the next line" in str(refused(whole(*LINES, space + b"folded: 1")))
    assert "continues on the next line" in str(refused(whole(LINES[0], space + b"Host: localhost")))


@pytest.mark.parametrize("name", [b"Transfer-Encoding", b"transfer-encoding", b"TRANSFER-ENCODING"])
@pytest.mark.parametrize("value", [b"chunked", b"identity", b"x, chunked", b""])
def test_a_length_beside_chunks_is_refused(name: bytes, value: bytes) -> None:
    for more in ([*LINES, name + b": " + value], [LINES[0], name + b": " + value, *LINES[1:]]):
        assert "may have only one" in str(refused(whole(*more) + b"0\r\n\r\n"))


def test_chunks_of_an_old_version_are_refused() -> None:
    lines = (b"POST / HTTP/1.0", b"Host: localhost", b"Transfer-Encoding: chunked")
    assert "HTTP/1.0" in str(refused(whole(*lines)))


def test_chunks_alone_are_read_with_their_trailers() -> None:
    lines = (b"POST / HTTP/1.1", b"Host: localhost", b"Transfer-Encoding: chunked")
    events = read(whole(*lines) + b"5\r\nhello\r\n0\r\nX-Sum: 1\r\n\r\n")
    assert isinstance(events[-1], h11.EndOfMessage)
    assert "CR LF" in str(refused(whole(*lines) + b"5\r\nhello\r\n0\r\nX-Sum: 1\n\r\n\r\n"))


@pytest.mark.parametrize("cut", [1, 70_000])
def test_heads_are_bounded(cut: int) -> None:
    first = (b"GET / HTTP/1.1", b"Host: localhost")
    many = whole(*first, *[b"X: 1"] * 128)
    assert refused(many[:cut], many[cut:]).error_status_hint == 431
    long = whole(*first, b"X: " + b"x" * 65_536)
    assert refused(long[:cut], long[cut:]).error_status_hint == 431
    assert refused(long[:cut], long[cut:-4]).error_status_hint == 431  # incomplete yet
    path = whole(b"GET /" + b"x" * 8_200 + b" HTTP/1.1", first[1])
    assert refused(path[:cut], path[cut:]).error_status_hint == 414
    assert isinstance(read(whole(*first, *[b"X: " + b"x" * 400] * 126))[0], h11.Request)


def test_a_second_request_is_looked_at_as_the_first() -> None:
    connection = StrictConnection()
    connection.receive_data(whole(b"GET / HTTP/1.1", b"Host: a") + b"GET / HTTP/1.1\nHost: a\n\n")
    assert isinstance(connection.next_event(), h11.Request)
    assert isinstance(connection.next_event(), h11.EndOfMessage)
    connection.send(h11.Response(status_code=204, headers=[]))
    connection.send(h11.EndOfMessage())
    connection.start_next_cycle()
    with pytest.raises(BadRequestError, match="CR LF"):
        connection.next_event()
    assert connection.refusal is not None
