import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { ChunkIntake } from "../../src/scene/chunk_intake";

const ID = "aa".repeat(32);
const DAMAGED = Uint8Array.of(1, 2, 3);
const RIGHT = Uint8Array.of(1, 2, 4);

function intake(fetchChunk: (id: string, signal: AbortSignal) => Promise<Uint8Array<ArrayBuffer>>) {
  const events = { decode: vi.fn(), consumed: vi.fn(), lost: vi.fn() };
  return { events, chunks: new ChunkIntake(events, fetchChunk) };
}

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

describe("ChunkIntake", () => {
  it("hands a chunk of the stream on and gives its credit back when it is decoded", () => {
    const { events, chunks } = intake(vi.fn());
    chunks.arrived(ID, RIGHT);
    expect(events.decode).toHaveBeenCalledExactlyOnceWith(ID, RIGHT);
    expect(events.consumed).not.toHaveBeenCalled();
    chunks.done(ID);
    expect(events.consumed).toHaveBeenCalledExactlyOnceWith(3);
  });

  it("fetches a damaged chunk again, which costs no credit", async () => {
    const fetchChunk = vi.fn().mockResolvedValue(RIGHT);
    const { events, chunks } = intake(fetchChunk);
    chunks.arrived(ID, DAMAGED);
    void chunks.damaged(ID, "wrong hash");
    await vi.runAllTimersAsync();
    chunks.done(ID);
    expect(fetchChunk).toHaveBeenCalledOnce();
    expect(events.decode).toHaveBeenLastCalledWith(ID, RIGHT);
    expect(events.consumed).toHaveBeenCalledExactlyOnceWith(3);
    expect(events.lost).not.toHaveBeenCalled();
  });

  it("fetches twice and then goes on without it", async () => {
    const fetchChunk = vi.fn().mockResolvedValue(DAMAGED);
    const { events, chunks } = intake(fetchChunk);
    events.decode.mockImplementation((id: string) => void chunks.damaged(id, "wrong hash"));
    chunks.arrived(ID, DAMAGED);
    await vi.runAllTimersAsync();
    expect(fetchChunk).toHaveBeenCalledTimes(2);
    expect(events.lost).toHaveBeenCalledExactlyOnceWith(ID, "wrong hash");
  });

  it("tries once more when the server cannot be reached", async () => {
    const fetchChunk = vi.fn().mockRejectedValueOnce(new Error("no server")).mockResolvedValueOnce(RIGHT);
    const { events, chunks } = intake(fetchChunk);
    void chunks.damaged(ID, "wrong hash");
    await vi.runAllTimersAsync();
    expect(events.decode).toHaveBeenCalledExactlyOnceWith(ID, RIGHT);
    expect(events.lost).not.toHaveBeenCalled();
  });

  it("keeps silent once it is disposed of", async () => {
    const { events, chunks } = intake(vi.fn().mockResolvedValue(RIGHT));
    void chunks.damaged(ID, "wrong hash");
    chunks.dispose();
    await vi.runAllTimersAsync();
    expect(events.decode).not.toHaveBeenCalled();
    expect(events.lost).not.toHaveBeenCalled();
  });
});
