import { createHash } from "node:crypto";
import { beforeEach, describe, expect, it } from "vitest";
import { ApiError } from "../../src/protocol/http";
import type { Upload } from "../../src/protocol/uploads";
import { arranged } from "../../src/upload/chosen_files";
import { Transfer, type UploadRequests } from "../../src/upload/transfer";

const MIB = 1 << 20;
const LARGE = 20 * MIB;

const hashOf = async (file: File): Promise<string> =>
  createHash("sha256")
    .update(Buffer.from(await file.arrayBuffer()))
    .digest("hex");

/** What docs/upload.md says of a server, in memory; `fault` may stand in the way of a request. */
class FakeServer implements UploadRequests {
  readonly files_ = new Map<string, { sha256: string; size: number; data: Buffer }>();
  readonly requests: string[] = [];
  waits: number[] = [];
  begun = 0;
  fault: (request: string) => void = () => {};

  #ask(request: string, signal: AbortSignal): void {
    signal.throwIfAborted();
    this.requests.push(request);
    this.fault(request);
    signal.throwIfAborted();
  }

  readonly #upload = {
    id: "u",
    name: "studio",
    state: "receiving",
    files: 2,
    bytes: 0,
    received: 0,
    expires: 1,
  } as const;

  finished: Upload[] = [];
  async uploads(signal: AbortSignal) {
    this.#ask("uploads", signal);
    return this.finished;
  }
  async begin(_: unknown, signal: AbortSignal) {
    this.#ask("begin", signal);
    return { upload: { ...this.#upload, capture: null }, resumed: this.begun++ > 0 };
  }
  async files(_: string, signal: AbortSignal) {
    this.#ask("files", signal);
    return [...this.files_].map(([path, { sha256, size, data }]) => ({
      path,
      sha256,
      offset: data.length,
      verified: data.length === size,
    }));
  }
  async announce(
    _: string,
    { path, size, sha256 }: { path: string; size: number; sha256: string },
    signal: AbortSignal,
  ) {
    this.#ask(`announce ${path}`, signal);
    if (this.files_.get(path)?.sha256 !== sha256) this.files_.set(path, { sha256, size, data: Buffer.alloc(0) });
    return { location: path, offset: this.files_.get(path)?.data.length ?? 0 };
  }
  async offset(location: string, signal: AbortSignal) {
    this.#ask(`offset ${location}`, signal);
    return this.#file(location).data.length;
  }
  async send(location: string, offset: number, piece: Blob, onBytes: (bytes: number) => void, signal: AbortSignal) {
    const file = this.#file(location);
    const bytes = Buffer.from(await piece.arrayBuffer());
    const before = this.requests.length;
    try {
      this.#ask(`send ${location} ${offset / MIB}`, signal);
    } catch (error) {
      if (this.requests.length > before) file.data = Buffer.concat([file.data, bytes.subarray(0, MIB)]); // what came before the cut
      throw error;
    }
    if (offset !== file.data.length) throw new ApiError("elsewhere", 409, "offset-mismatch");
    onBytes(piece.size);
    file.data = Buffer.concat([file.data, bytes]);
    if (file.data.length === file.size && createHash("sha256").update(file.data).digest("hex") !== file.sha256) {
      file.data = Buffer.alloc(0);
      throw new ApiError("changed", 422, "checksum-mismatch");
    }
    return file.data.length;
  }
  async finish(_: string, signal: AbortSignal) {
    this.#ask("finish", signal);
    const capture = "/captures/studio";
    this.finished = [{ ...this.#upload, bytes: LARGE + 5, state: "finished", capture }];
    return { ...this.#upload, state: "finished", capture: "/captures/studio" } as const;
  }
  async wait(seconds: number) {
    this.waits.push(seconds);
  }
  #file(location: string) {
    const file = this.files_.get(location);
    if (!file) throw new Error("not announced");
    return file;
  }
}

let server: FakeServer;
const content = Buffer.alloc(LARGE, "a video ");
const chosen = arranged([
  { path: "studio/cam00.mp4", file: new File([content], "cam00.mp4") },
  { path: "studio/sparse/0/a.txt", file: new File(["poses"], "a.txt") },
]);
const transferTo = (requests: UploadRequests) => new Transfer(chosen, requests, hashOf, () => {});

beforeEach(() => {
  server = new FakeServer();
});

describe("a transfer", () => {
  it("sends every byte, and is a capture then", async () => {
    const transfer = transferTo(server);
    await transfer.run();
    expect(transfer.state).toBe("done");
    expect(transfer.upload?.capture).toBe("/captures/studio");
    expect(server.files_.get("cam00.mp4")?.data.equals(content)).toBe(true);
    expect(transfer.sent).toBe(LARGE + 5);
    expect(server.requests.filter((request) => request.startsWith("send cam00"))).toEqual([
      "send cam00.mp4 0",
      "send cam00.mp4 8",
      "send cam00.mp4 16",
    ]);
  });

  it("waits after a cut, longer each time, and goes on behind what came", async () => {
    let cuts = 3;
    server.fault = (request) => {
      if (request === "send cam00.mp4 8" && cuts-- > 0) throw new ApiError("The server cannot be reached.");
      if (request.startsWith("offset") && cuts-- > 0) throw new ApiError("down", 503);
    };
    const transfer = transferTo(server);
    await transfer.run();
    expect(transfer.state).toBe("done");
    expect(server.files_.get("cam00.mp4")?.data.equals(content)).toBe(true);
    expect(server.requests).toContain("send cam00.mp4 9");
    expect(server.waits).toEqual([0.5, 1, 2]);
  });

  it("pauses and goes on without sending what is there", async () => {
    const transfer = transferTo(server);
    server.fault = (request) => {
      if (request === "send cam00.mp4 8") transfer.pause();
    };
    await transfer.run();
    expect(transfer.state).toBe("paused");
    server.fault = () => {};
    server.requests.length = 0;
    await transfer.run();
    expect(transfer.state).toBe("done");
    expect(server.requests).not.toContain("send cam00.mp4 0");
    expect(server.requests).not.toContain("send sparse/0/a.txt 0");
    expect(server.files_.get("cam00.mp4")?.data.equals(content)).toBe(true);
  });

  it("goes on with what an earlier page has sent", async () => {
    const first = transferTo(server);
    server.fault = (request) => {
      if (request === "send cam00.mp4 16") throw new ApiError("gone", 404, "upload-not-found");
    };
    await first.run();
    expect([first.state, first.problem]).toEqual(["failed", "gone"]);
    server.fault = () => {};
    server.requests.length = 0;
    await transferTo(server).run();
    expect(server.requests.filter((request) => request.startsWith("send"))).toEqual(["send cam00.mp4 17"]);
  });

  it("reads a file again whose content is another, and gives it up at last", async () => {
    let reads = 0;
    const wrongAtFirst = async (file: File) => (file.size === LARGE && reads++ === 0 ? "0".repeat(64) : hashOf(file));
    const transfer = new Transfer(chosen, server, wrongAtFirst, () => {});
    await transfer.run();
    expect([transfer.state, reads]).toEqual(["done", 2]);
    server = new FakeServer();
    const wrong = new Transfer(
      chosen,
      server,
      async () => "0".repeat(64),
      () => {},
    );
    await wrong.run();
    expect([wrong.state, wrong.problem]).toEqual(["failed", "changed"]);
  });

  it("sends nothing of what is a capture already, and all of what only looks like it", async () => {
    await transferTo(server).run();
    server.requests.length = 0;
    const again = transferTo(server);
    await again.run();
    expect([again.state, again.upload?.capture]).toEqual(["done", "/captures/studio"]);
    expect(server.requests).toEqual(["uploads", "files"]);
    const other = new Transfer(
      chosen,
      server,
      async (file) => (await hashOf(file)).replace(/^./, "g"),
      () => {},
    );
    await other.run();
    expect(server.requests).toContain("begin");
  });

  it("says which file cannot be read", async () => {
    const unreadable = new Transfer(
      chosen,
      server,
      () => Promise.reject(new Error("cannot be read")),
      () => {},
    );
    await unreadable.run();
    expect(unreadable.problem).toBe("cam00.mp4 cannot be read; choose the folder again.");
  });
});
