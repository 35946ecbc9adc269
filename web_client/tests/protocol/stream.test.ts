import { decode, encode } from "@msgpack/msgpack";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { fromHex } from "../../src/protocol/messages";
import { SceneStream, type Socket, type StreamEvents } from "../../src/protocol/stream";

const A = "aa".repeat(32);
const B = "bb".repeat(32);

/** A socket whose other end is the test. */
class FakeSocket implements Socket {
  binaryType: BinaryType = "blob";
  onopen: ((event: Event) => void) | null = null;
  onmessage: ((event: MessageEvent) => void) | null = null;
  onclose: ((event: CloseEvent) => void) | null = null;
  readonly sent: Record<string, unknown>[] = [];
  closed: number | undefined;

  send(data: Uint8Array): void {
    this.sent.push(decode(data) as Record<string, unknown>);
  }

  close(code?: number): void {
    this.closed = code;
  }

  open(): void {
    this.onopen?.(new Event("open"));
  }

  receive(bytes: Uint8Array): void {
    this.onmessage?.({ data: bytes.slice().buffer } as MessageEvent);
  }

  welcome(manifest = "{}"): void {
    const bytes = new TextEncoder().encode(manifest);
    this.receive(encode({ type: "welcome", protocol: 1, scene: "s", manifest: bytes, remaining: 0 }));
  }

  frame(id: string, offset: number, size: number, payload: Uint8Array): void {
    const bytes = new Uint8Array(48 + payload.length);
    const view = new DataView(bytes.buffer);
    view.setUint8(0, 1);
    view.setUint32(4, offset, true);
    view.setUint32(8, size, true);
    bytes.set(fromHex(id), 16);
    bytes.set(payload, 48);
    this.receive(bytes);
  }

  drop(code: number): void {
    this.onclose?.({ code } as CloseEvent);
  }

  credits(): number {
    return this.sent.filter(({ type }) => type === "credit").reduce((sum, { bytes }) => sum + (bytes as number), 0);
  }
}

const sockets: FakeSocket[] = [];

function connect(time: number | null = 0.5) {
  const events = {
    manifest: vi.fn(),
    chunk: vi.fn<StreamEvents["chunk"]>(),
    progress: vi.fn(),
    state: vi.fn(),
    failed: vi.fn(),
  };
  const stream = new SceneStream("ws://here", events, { time, rate: 1 }, () => {
    sockets.push(new FakeSocket());
    return sockets[sockets.length - 1];
  });
  return { stream, events, socket: sockets[0] };
}

beforeEach(() => {
  sockets.length = 0;
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

describe("SceneStream", () => {
  it("says hello with what it has, its credit and its playhead", () => {
    const { socket } = connect();
    socket.open();
    expect(socket.sent[0]).toMatchObject({ type: "hello", protocol: 1, have: [], time: 0.5, rate: 1 });
    expect(socket.sent[0].credits).toBeGreaterThanOrEqual(4144);
    expect(socket.binaryType).toBe("arraybuffer");
  });

  it("leaves the time to the server where it knows none", () => {
    const { socket } = connect(null);
    socket.open();
    expect(socket.sent[0]).not.toHaveProperty("time");
  });

  it("puts interleaved frames together", () => {
    const { socket, events } = connect();
    socket.open();
    socket.welcome();
    socket.frame(A, 0, 3, Uint8Array.of(1, 2));
    socket.frame(B, 0, 1, Uint8Array.of(9));
    socket.frame(A, 2, 3, Uint8Array.of(3));
    expect(events.chunk.mock.calls.map(([id, bytes]) => [id, [...bytes]])).toEqual([
      [B, [9]],
      [A, [1, 2, 3]],
    ]);
  });

  it("gives up on a frame that does not follow the one before", () => {
    const { socket, events } = connect();
    socket.open();
    socket.welcome();
    socket.frame(A, 0, 9, Uint8Array.of(1, 2));
    socket.frame(A, 3, 9, Uint8Array.of(3));
    expect(events.failed).toHaveBeenCalledOnce();
    expect(socket.closed).toBe(1000);
  });

  it("grants back what it has received, headers included", () => {
    const { socket, stream } = connect();
    socket.open();
    socket.welcome();
    const payload = new Uint8Array(1 << 19);
    socket.frame(A, 0, payload.length, payload);
    stream.consumed(payload.length);
    expect(socket.credits()).toBe(payload.length + 48);
  });

  it("holds credit back while the decoder is behind", () => {
    const { socket, stream } = connect();
    socket.open();
    socket.welcome();
    const payload = new Uint8Array(20 << 20);
    socket.frame(A, 0, payload.length, payload);
    expect(socket.credits()).toBe(0);
    stream.consumed(payload.length);
    expect(socket.credits()).toBe(payload.length + 48);
  });

  it("comes back after a broken connection with what it has, where the playhead is", () => {
    const { socket, stream, events } = connect();
    socket.open();
    socket.welcome();
    socket.frame(A, 0, 1, Uint8Array.of(1));
    socket.frame(B, 0, 2, Uint8Array.of(1)); // half of it: must come again
    stream.playheadAt(1.25);
    socket.drop(1006);
    expect(events.state).toHaveBeenLastCalledWith("retrying");
    vi.advanceTimersByTime(2000);
    sockets[1].open();
    expect(sockets[1].sent[0]).toMatchObject({ have: [fromHex(A)], time: 1.25 });
    sockets[1].welcome();
    sockets[1].frame(B, 0, 2, Uint8Array.of(1, 2));
    expect(events.chunk).toHaveBeenCalledTimes(2);
    expect(events.manifest).toHaveBeenCalledOnce();
  });

  it("waits longer after each failure", () => {
    connect();
    for (const wait of [500, 1000, 2000]) {
      const attempts = sockets.length;
      sockets[attempts - 1].drop(1006);
      vi.advanceTimersByTime(wait * 0.7);
      expect(sockets.length).toBe(attempts);
      vi.advanceTimersByTime(wait * 0.6);
      expect(sockets.length).toBe(attempts + 1);
    }
  });

  it("does not come back when the server says why not", () => {
    const { socket, events } = connect();
    socket.open();
    socket.receive(encode({ type: "error", code: "scene-not-found", detail: "scene x: no such scene" }));
    socket.drop(4004);
    vi.advanceTimersByTime(60000);
    expect(events.failed).toHaveBeenCalledExactlyOnceWith("scene x: no such scene");
    expect(sockets.length).toBe(1);
  });

  it("says so when the scene is another one after coming back", () => {
    const { socket, events } = connect();
    socket.open();
    socket.welcome("{}");
    socket.drop(1012);
    vi.advanceTimersByTime(2000);
    sockets[1].open();
    sockets[1].welcome('{"a": 1}');
    expect(events.failed).toHaveBeenCalledOnce();
  });

  it("keeps the last seek for the hello if it is not connected yet", () => {
    const { socket, stream } = connect();
    stream.seek(1.5);
    expect(socket.sent).toEqual([]);
    socket.open();
    expect(socket.sent[0]).toMatchObject({ type: "hello", time: 1.5 });
  });

  it("leaves for good when closed", () => {
    const { socket, stream } = connect();
    socket.open();
    stream.close();
    vi.advanceTimersByTime(60000);
    expect(socket.closed).toBe(1000);
    expect(sockets.length).toBe(1);
  });
});
