import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { ReconnectingSocket } from "../../src/source/reconnecting_socket";
import { FakeSocket } from "../socket_double";

const sockets: FakeSocket[] = [];

function connect() {
  const events = { connecting: vi.fn(), open: vi.fn(), message: vi.fn(), retrying: vi.fn(), refused: vi.fn() };
  const open = () => {
    sockets.push(new FakeSocket());
    return sockets[sockets.length - 1];
  };
  return { line: new ReconnectingSocket(open, events), events, socket: sockets[0] };
}

beforeEach(() => {
  sockets.length = 0;
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
});

it("comes back anywhere in a span that grows with each failure", () => {
  const random = vi.spyOn(Math, "random").mockReturnValue(0.999);
  connect();
  for (const longest of [500, 1000, 2000, 4000, 8000, 8000]) {
    const attempts = sockets.length;
    sockets[attempts - 1].drop(1006);
    vi.advanceTimersByTime(longest * 0.99);
    expect(sockets.length).toBe(attempts);
    vi.advanceTimersByTime(longest * 0.01);
    expect(sockets.length).toBe(attempts + 1);
  }
  random.mockReturnValue(0);
  sockets[sockets.length - 1].drop(1006);
  vi.advanceTimersByTime(1);
  expect(sockets.length).toBe(8);
});

it("comes back soon again once a connection has brought what it should", () => {
  vi.spyOn(Math, "random").mockReturnValue(0.999);
  const { line } = connect();
  for (const longest of [500, 1000, 2000]) {
    sockets[sockets.length - 1].drop(1006);
    vi.advanceTimersByTime(longest);
  }
  expect(sockets.length).toBe(4);
  line.succeeded();
  sockets[3].drop(1006);
  vi.advanceTimersByTime(500);
  expect(sockets.length).toBe(5);
});

it.each([1003, 1009, 4000, 4004])("does not come back where the server closes with %i", (code) => {
  const { events, socket } = connect();
  socket.drop(code);
  vi.advanceTimersByTime(60_000);
  expect(events.refused).toHaveBeenCalledExactlyOnceWith(code);
  expect(events.retrying).not.toHaveBeenCalled();
  expect(sockets.length).toBe(1);
});

it.each([1006, 1012, 4008])("comes back where the connection ends with %i", (code) => {
  const { events, socket } = connect();
  socket.drop(code);
  expect(events.retrying).toHaveBeenCalledOnce();
  vi.advanceTimersByTime(500);
  expect(sockets.length).toBe(2);
  expect(events.connecting).toHaveBeenCalledTimes(2);
  expect(events.refused).not.toHaveBeenCalled();
});

it("asks after four silent seconds, and connects anew after eight", () => {
  const { socket, events } = connect();
  socket.open();
  vi.advanceTimersByTime(3400);
  expect(socket.types()).toEqual(["ping"]); // the one that measures the line
  vi.advanceTimersByTime(1100);
  expect(socket.types()).toEqual(["ping", "ping"]);
  vi.advanceTimersByTime(3000);
  expect(sockets.length).toBe(1);
  vi.advanceTimersByTime(2000);
  expect(socket.closed).toBe(1000);
  expect(events.retrying).toHaveBeenCalledOnce();
  expect(sockets.length).toBe(2);
});

it("gives a line more time after each silence, until it brings what it should", () => {
  const { line } = connect();
  for (const seconds of [8, 16, 32, 64, 64]) {
    const attempts = sockets.length;
    vi.advanceTimersByTime(seconds * 1000 - 600);
    expect(sockets.length).toBe(attempts);
    vi.advanceTimersByTime(9000);
    expect(sockets.length).toBe(attempts + 1);
    sockets[attempts].open(); // the connection alone is no sign that it will do
  }
  line.succeeded();
  sockets[5].drop(1006);
  vi.advanceTimersByTime(500);
  vi.advanceTimersByTime(9000);
  expect(sockets.length).toBe(8);
});

it("connects at once when the network is back", () => {
  vi.spyOn(Math, "random").mockReturnValue(0.999);
  const { socket, line } = connect();
  socket.drop(1006);
  line.wake();
  expect(sockets.length).toBe(2);
  vi.advanceTimersByTime(3000);
  expect(sockets.length).toBe(2);
});

it("stays away once it is closed, even while it was to come back", () => {
  const { socket, line } = connect();
  socket.drop(1006);
  line.close();
  line.wake();
  vi.advanceTimersByTime(60_000);
  expect(sockets.length).toBe(1);
});
