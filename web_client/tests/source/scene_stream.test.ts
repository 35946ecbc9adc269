import { gzipSync } from "node:zlib";
import { encode } from "@msgpack/msgpack";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { fromHex } from "../../src/codec/hex";
import { parseManifest } from "../../src/codec/manifest";
import type { SourceEvents } from "../../src/source/scene_source";
import { SceneStream } from "../../src/source/scene_stream";
import { MANIFEST, PAGED } from "../page_vectors";
import { FakeSocket } from "../socket_double";
import { GROWING, WHOLE } from "../worker_double";

const A = "aa".repeat(32);
const B = "bb".repeat(32);
const C = "cc".repeat(32);
const text = (document: unknown) => new TextEncoder().encode(JSON.stringify(document));

const sockets: FakeSocket[] = [];

function connect(time: number | null = 0.5) {
  const events = {
    manifest: vi.fn(),
    grown: vi.fn(),
    chunk: vi.fn<SourceEvents["chunk"]>(),
    missing: vi.fn(),
    progress: vi.fn(),
    state: vi.fn(),
    failed: vi.fn(),
  };
  const stream = new SceneStream("ws://here/v1/scenes/s/stream", events, { time, rate: 1 }, () => {
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
  it("fetches a chunk again from the server of the stream", async () => {
    const answer = vi.fn().mockResolvedValue(new Response(Uint8Array.of(1)));
    vi.stubGlobal("fetch", answer);
    const { signal } = new AbortController();
    await connect().stream.fetchAgain(A, signal);
    expect(answer).toHaveBeenCalledWith(`http://here/v1/scenes/s/chunks/${A}`, expect.objectContaining({ signal }));
    vi.unstubAllGlobals();
  });

  it("says hello with what it has, its credit and its playhead", () => {
    const { socket } = connect();
    socket.open();
    expect(socket.sent[0]).toMatchObject({ type: "hello", protocol: 1, parts: [], time: 0.5, rate: 1 });
    expect(socket.sent[0].credits).toBeGreaterThanOrEqual(4144);
    expect(socket.binaryType).toBe("arraybuffer");
  });

  it("tells what a scene that grows has become, and comes back with the names of what it has", () => {
    const { socket, events } = connect();
    socket.open();
    expect(socket.sent[0]).toMatchObject({ follow: true });
    socket.welcome(JSON.stringify(GROWING));
    const later = { ...WHOLE, live: 2 };
    const manifest_id = new Uint8Array(32).fill(8);
    socket.receive(encode({ type: "grow", manifest: text(later), manifest_id, remaining: 1 }));
    expect(events.grown.mock.calls).toEqual([[parseManifest(later)]]);
    const added = WHOLE.slices[GROWING.slices.length].chunks[0].id;
    socket.frame(added, 0, 1, Uint8Array.of(9));
    socket.drop(1006);
    vi.advanceTimersByTime(8000);
    const again = sockets[1];
    again.open();
    expect(again.sent[0]).toMatchObject({ have: [fromHex(added)], manifest_id });
    again.welcome(JSON.stringify(WHOLE), 9);
    expect(events.grown.mock.calls[1]).toEqual([parseManifest(WHOLE)]);
    expect([events.manifest.mock.calls.length, events.failed.mock.calls.length]).toEqual([1, 0]);
  });

  it("takes pages from among the chunks, and waits with what comes after one", async () => {
    vi.useRealTimers();
    const { socket, events } = connect();
    const [{ id, bytes }] = PAGED.pages;
    const chunk = MANIFEST.slices[0].chunks[0].id;
    socket.open();
    const manifest_id = new Uint8Array(32).fill(7);
    socket.receive(
      encode({ type: "welcome", protocol: 1, scene: "s", manifest: PAGED.bytes, manifest_id, remaining: 1 }),
    );
    socket.frame(id, 0, bytes.length, bytes.slice(0, 100));
    socket.frame(id, 100, bytes.length, bytes.slice(100));
    socket.frame(chunk, 0, 1, Uint8Array.of(1));
    await vi.waitFor(() => expect(events.chunk).toHaveBeenCalledOnce());
    expect(events.grown.mock.calls[0][0].slices.slice(0, 8)).toEqual(parseManifest(MANIFEST).slices.slice(0, 8));
    expect(events.grown).toHaveBeenCalledBefore(events.chunk);
    expect(events.progress.mock.calls).toEqual([[1]]);
    socket.drop(1006);
    await vi.waitFor(() => expect(sockets.length).toBe(2));
    sockets[1].open();
    const { pages, have } = sockets[1].sent[0] as { pages: [Uint8Array, Uint8Array][]; have: unknown };
    expect([pages.length, pages[0][0], pages[0][1][0], have]).toEqual([1, fromHex(id), 1, undefined]);
  });

  it("fetches a page that is damaged once more, and does without it then", async () => {
    vi.useRealTimers();
    const [{ id, bytes }] = PAGED.pages;
    const answer = vi.fn().mockResolvedValueOnce(new Response(bytes)).mockResolvedValueOnce(new Response("?"));
    vi.stubGlobal("fetch", answer);
    for (const last of ["grown", "missing"] as const) {
      const { stream, events } = connect();
      const socket = sockets[sockets.length - 1];
      socket.open();
      socket.welcome(JSON.stringify(PAGED.index));
      socket.frame(id, 0, 3, Uint8Array.of(1, 2, 3));
      await vi.waitFor(() => expect(events[last]).toHaveBeenCalled());
      expect(events.failed).not.toHaveBeenCalled();
      stream.close();
    }
    expect(answer.mock.calls[0][0]).toBe(`http://here/v1/scenes/s/chunks/${id}`);
    vi.unstubAllGlobals();
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
    expect(events.failed).toHaveBeenCalledExactlyOnceWith("not-understood", expect.stringContaining("chunk"));
    expect(socket.closed).toBe(1000);
  });

  it("grants back what it has received, headers included", () => {
    const { socket } = connect();
    socket.open();
    socket.welcome();
    const payload = new Uint8Array(32 << 10);
    socket.frame(A, 0, payload.length, payload);
    expect(socket.credits()).toBeGreaterThanOrEqual(payload.length + 48);
  });

  it("holds credit back while the decoder is behind", () => {
    const { socket, stream } = connect();
    socket.open();
    socket.welcome();
    const payload = new Uint8Array(20 << 20);
    socket.frame(A, 0, payload.length, payload);
    expect(socket.credits()).toBe(0);
    stream.consumed(payload.length);
    expect(socket.credits()).toBeGreaterThanOrEqual(payload.length + 48);
  });

  it("comes back after a broken connection with what it has, where the playhead is", () => {
    const { socket, stream, events } = connect();
    socket.open();
    socket.welcome();
    socket.frame(A, 0, 1, Uint8Array.of(1));
    socket.frame(B, 0, 2, Uint8Array.of(1)); // half of it
    socket.frame(C, 0, 1, Uint8Array.of(1));
    stream.playheadAt(1.25);
    socket.drop(1006);
    expect(events.state).toHaveBeenLastCalledWith("retrying");
    vi.advanceTimersByTime(2000);
    sockets[1].open();
    expect(sockets[1].sent[0]).toMatchObject({
      have: [fromHex(A), fromHex(C)],
      parts: [[fromHex(B), 1]],
      manifest_id: new Uint8Array(32).fill(7),
      time: 1.25,
    });
    sockets[1].welcome("");
    sockets[1].frame(B, 1, 2, Uint8Array.of(2));
    expect(events.chunk.mock.calls.map(([id, bytes]) => [id, [...bytes]])).toEqual([
      [A, [1]],
      [C, [1]],
      [B, [1, 2]],
    ]);
    expect(events.manifest).toHaveBeenCalledOnce();
  });

  it("names no more parts than a hello may, and takes the rest again", () => {
    const { socket, events } = connect();
    socket.open();
    socket.welcome();
    const id = (k: number) => k.toString(16).padStart(64, "0");
    for (let k = 0; k < 1100; k++) socket.frame(id(k), 0, 2, Uint8Array.of(1));
    socket.drop(1006);
    vi.advanceTimersByTime(2000);
    sockets[1].open();
    expect((sockets[1].sent[0] as { parts: [Uint8Array, number][] }).parts.length).toBe(1024);
    sockets[1].welcome("");
    sockets[1].frame(id(1099), 0, 2, Uint8Array.of(1, 2));
    expect(events.failed).not.toHaveBeenCalled();
    expect(events.chunk).toHaveBeenCalledOnce();
  });

  it("waits with what comes after a compressed index until it has been decompressed", async () => {
    vi.useRealTimers();
    const { socket, events } = connect();
    socket.open();
    const manifest_id = new Uint8Array(32);
    const manifest = gzipSync(JSON.stringify(WHOLE));
    socket.receive(encode({ type: "welcome", protocol: 1, scene: "s", manifest, manifest_id, remaining: 1 }));
    socket.frame(A, 0, 1, Uint8Array.of(1));
    expect(events.chunk).not.toHaveBeenCalled();
    await vi.waitFor(() => expect(events.chunk).toHaveBeenCalledOnce());
    expect(events.manifest.mock.calls).toEqual([[parseManifest(WHOLE)]]);
  });

  it.each([[[0x1f, 0x8b, 3]], [[0x7b]]])("gives up where an index cannot be read: %o", async (manifest) => {
    vi.useRealTimers();
    const { socket, events } = connect();
    socket.open();
    const bytes = Uint8Array.from(manifest);
    const manifest_id = new Uint8Array(32);
    socket.receive(encode({ type: "welcome", protocol: 1, scene: "s", manifest: bytes, manifest_id, remaining: 1 }));
    await vi.waitFor(() => expect(events.failed).toHaveBeenCalledWith("unreadable", expect.any(String)));
  });

  it("goes on without a chunk that the server cannot give, and asks for it again next time", () => {
    const { socket, events } = connect();
    socket.open();
    socket.welcome();
    socket.frame(A, 0, 2, Uint8Array.of(1));
    socket.receive(encode({ type: "missing", id: fromHex(A) }));
    expect(events.missing).toHaveBeenCalledExactlyOnceWith(A);
    socket.drop(1006);
    vi.advanceTimersByTime(2000);
    sockets[1].open();
    expect(sockets[1].sent[0]).toMatchObject({ parts: [] });
    sockets[1].welcome("");
    sockets[1].frame(A, 0, 2, Uint8Array.of(1, 2));
    expect(events.chunk).toHaveBeenCalledOnce();
  });

  it("comes back after a hello that took too long", () => {
    const { socket, events } = connect();
    socket.open();
    socket.receive(encode({ type: "error", code: "hello-timeout", detail: "no hello within 10 s" }));
    socket.drop(4008);
    vi.advanceTimersByTime(2000);
    expect(events.failed).not.toHaveBeenCalled();
    expect(sockets.length).toBe(2);
  });

  it("stays while the server answers", () => {
    const { socket } = connect();
    socket.open();
    socket.welcome();
    for (let k = 0; k < 20; k++) {
      vi.advanceTimersByTime(4700);
      socket.receive(encode({ type: "pong", id: 0 }));
    }
    expect(sockets.length).toBe(1);
    expect(socket.types().filter((type) => type === "ping").length).toBe(21);
  });

  it("does not hold silence against a page that has slept", () => {
    let slept = 0;
    const now = performance.now.bind(performance);
    const clock = vi.spyOn(performance, "now").mockImplementation(() => now() + slept);
    const { socket } = connect();
    socket.open();
    socket.welcome();
    vi.advanceTimersByTime(4500); // it has asked already
    slept = 3600_000;
    vi.advanceTimersByTime(3500);
    expect(sockets.length).toBe(1);
    socket.receive(encode({ type: "pong", id: 0 }));
    vi.advanceTimersByTime(3500);
    expect(sockets.length).toBe(1);
    clock.mockRestore();
  });

  it("waits for nothing when it has everything", () => {
    const { socket } = connect();
    socket.open();
    socket.welcome();
    socket.receive(encode({ type: "end", bytes: 0 }));
    vi.advanceTimersByTime(600_000);
    expect(socket.types()).toEqual(["hello", "ping"]);
    expect(sockets.length).toBe(1);
  });

  it("asks at once when the network is back", () => {
    const { socket, stream } = connect();
    socket.open();
    socket.welcome();
    stream.wake();
    stream.wake();
    expect(socket.types()).toEqual(["hello", "ping", "ping"]);
    vi.advanceTimersByTime(5100);
    expect(sockets.length).toBe(2);
  });

  it("tells twenty places a second while the playhead is dragged, and the last one", () => {
    const { socket, stream } = connect();
    socket.open();
    socket.welcome();
    for (let k = 1; k <= 240; k++) {
      stream.pause(k / 100);
      stream.seek(k / 100);
      vi.advanceTimersByTime(1000 / 240);
    }
    vi.advanceTimersByTime(100);
    const seeks = socket.sent.filter(({ type }) => type === "seek");
    expect(seeks.length).toBeGreaterThan(15);
    expect(seeks.length).toBeLessThan(23);
    expect(socket.sent.slice(-2)).toEqual([
      { type: "pause", time: 2.4 },
      { type: "seek", time: 2.4 },
    ]);
  });

  it("comes back soon again once a chunk has come", () => {
    const random = vi.spyOn(Math, "random").mockReturnValue(0.999);
    connect();
    for (const longest of [500, 1000]) {
      sockets[sockets.length - 1].drop(1006);
      vi.advanceTimersByTime(longest);
    }
    sockets[2].open();
    sockets[2].welcome();
    sockets[2].frame(A, 0, 1, Uint8Array.of(1));
    sockets[2].drop(1006);
    vi.advanceTimersByTime(500);
    expect(sockets.length).toBe(4);
    random.mockRestore();
  });

  it("does not come back when the server says why not", () => {
    const { socket, events } = connect();
    socket.open();
    socket.receive(encode({ type: "error", code: "scene-not-found", detail: "scene x: no such scene" }));
    socket.drop(4004);
    vi.advanceTimersByTime(60000);
    expect(events.failed).toHaveBeenCalledExactlyOnceWith("no-scene", "scene x: no such scene");
    expect(sockets.length).toBe(1);
  });

  it("tells that the server restarts until it is back, however often nobody answers", () => {
    const { socket, events } = connect();
    socket.open();
    socket.welcome();
    socket.drop(1012);
    expect(events.state).toHaveBeenLastCalledWith("restarting");
    vi.advanceTimersByTime(2000);
    sockets[1].drop(1006);
    vi.advanceTimersByTime(2000);
    expect(events.state).toHaveBeenLastCalledWith("restarting");
    sockets[2].open();
    sockets[2].welcome();
    expect(events.state).toHaveBeenLastCalledWith("open");
    sockets[2].drop(1006);
    expect(events.state).toHaveBeenLastCalledWith("retrying");
  });

  it("says so when the scene is another one after coming back", () => {
    const { socket, events } = connect();
    socket.open();
    socket.welcome();
    socket.drop(1012);
    vi.advanceTimersByTime(2000);
    sockets[1].open();
    sockets[1].welcome(JSON.stringify({ ...WHOLE, title: "Another" }), 8);
    expect(events.failed).toHaveBeenCalledExactlyOnceWith("scene-changed", expect.any(String));
  });

  it("tells the server how fast the line is", () => {
    const { socket } = connect();
    socket.open();
    for (let k = 0; k < 60; k++) {
      vi.advanceTimersByTime(50);
      socket.frame(k.toString(16).padStart(64, "0"), 0, 100_000, new Uint8Array(452));
    }
    expect(socket.sent.filter(({ type }) => type === "limits")).toEqual([{ type: "limits", measured: 10_000 }]);
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

  it("asks for sound when a piece is wanted, and once more on the next connection, with what has come", async () => {
    const { events, stream, socket } = connect();
    socket.open();
    socket.welcome(JSON.stringify({ ...WHOLE, audio: { pieces: [{ id: B }, { id: C }] } }));
    const asked = stream.fetchAgain(B, new AbortController().signal, "default");
    expect(socket.sent.at(-1)).toEqual({ type: "limits", audio: true });
    socket.frame(B, 0, 3, Uint8Array.of(1, 2, 3));
    expect(await asked).toEqual(Uint8Array.of(1, 2, 3));
    expect(events.chunk).not.toHaveBeenCalled();
    expect(events.progress).not.toHaveBeenCalled();
    socket.drop(1006);
    vi.advanceTimersByTime(1000);
    const next = sockets[1];
    next.open();
    expect(next.sent[0]).toMatchObject({ type: "hello", audio: true, have: [fromHex(B)] });
  });
});
