import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { parseManifest } from "../../src/codec/manifest";
import { HttpSource } from "../../src/source/http_source";
import type { SourceEvents } from "../../src/source/scene_source";
import { MANIFEST as PAGE_MANIFEST, PAGED } from "../page_vectors";

const id = (letter: string) => letter.repeat(64);
const chunk = (letter: string) => ({
  id: id(letter),
  bytes: 100,
  splats: 1,
  box: [
    [0, 0, 0],
    [1, 1, 1],
  ],
});
const slice = (start: number, letters: string) => ({
  segment: 0,
  start,
  end: start + 10,
  chunks: Array.from(letters, chunk),
  needs: [],
});
/** Two static chunks, and slices of ten seconds with a chunk each. */
const MANIFEST = JSON.stringify({
  format: "hgs-scene",
  version: 2,
  title: "test",
  start: 0,
  end: 50,
  frame_rate: 30,
  background: [0, 0, 0],
  up: [0, -1, 0],
  center: [0, 0, 0],
  extent: 1,
  cameras: [
    {
      name: "cam",
      width: 10,
      height: 10,
      fx: 10,
      fy: 10,
      cx: 5,
      cy: 5,
      near: 0.1,
      world_to_camera: [
        [1, 0, 0, 0],
        [0, 1, 0, 0],
        [0, 0, 1, 0],
        [0, 0, 0, 1],
      ],
    },
  ],
  segments: [{ start: 0, end: 50 }],
  static: [chunk("1"), chunk("2")],
  slices: [slice(0, "a"), slice(10, "b"), slice(20, "c"), slice(30, "d"), slice(40, "e")],
  totals: { splats_static: 2, splats_dynamic: 5, bytes_static: 200, bytes_dynamic: 500 },
  thumbnail: false,
  training: {},
});

interface Request {
  readonly url: string;
  readonly cache: string;
  readonly signal: AbortSignal;
  answer(body: Uint8Array | string, status?: number): Promise<void>;
  /** The line breaks. */
  fail(): Promise<void>;
}

const requests: Request[] = [];
let hidden: boolean;
let source: HttpSource | null = null;

const passed = async () => {
  await vi.advanceTimersByTimeAsync(0);
};
/** The chunks that are being fetched, by their letter. */
const asked = () => requests.map(({ url }) => url.at(-1)).join("");
const whole = () => new Uint8Array(100);

beforeEach(() => {
  vi.useFakeTimers();
  vi.spyOn(Math, "random").mockReturnValue(0.999);
  requests.length = 0;
  hidden = false;
  vi.stubGlobal("fetch", (url: string, { cache, signal }: { cache: string; signal: AbortSignal }) => {
    return new Promise<Response>((resolve, reject) => {
      signal.addEventListener("abort", () => reject(signal.reason));
      const forget = () => {
        if (requests.includes(request)) requests.splice(requests.indexOf(request), 1);
      };
      const settle = (done: () => void) => {
        forget();
        done();
        return passed();
      };
      const request: Request = {
        url,
        cache,
        signal,
        answer: (body, status = 200) => settle(() => resolve(new Response(body as BodyInit, { status }))),
        fail: () => settle(() => reject(new TypeError("Failed to fetch"))),
      };
      signal.addEventListener("abort", forget);
      requests.push(request);
    });
  });
});
afterEach(() => {
  source?.close();
  vi.useRealTimers();
  vi.unstubAllGlobals();
  vi.restoreAllMocks();
});

const document = JSON.parse(MANIFEST);
const versions = [
  {
    ...document,
    live: 1,
    end: 20,
    slices: document.slices.slice(0, 2),
    totals: { ...document.totals, splats_dynamic: 2, bytes_dynamic: 200 },
  },
  document,
];

describe("a scene that grows", () => {
  it("is asked for again until it is complete, and brings what was added", async () => {
    open();
    await requests[0].answer(JSON.stringify(versions[0]));
    await vi.dynamicImportSettled();
    for (const _ of "12ab") await requests[0].answer(whole());
    expect(requests).toEqual([]);
    await vi.advanceTimersByTimeAsync(2000);
    expect(requests.map(({ url, cache }) => [url, cache])).toEqual([
      ["https://cdn.example/studio/manifest.json?v=2", "no-cache"],
    ]);
    await requests[0].answer(JSON.stringify(versions[0])); // nothing new
    expect(events.grown).not.toHaveBeenCalled();
    await vi.advanceTimersByTimeAsync(2000);
    await requests[0].fail();
    await vi.advanceTimersByTimeAsync(2000);
    expect(requests).toEqual([]); // a pause after what has failed
    await vi.advanceTimersByTimeAsync(2000);
    await requests[0].answer(MANIFEST);
    expect(events.grown.mock.calls).toEqual([[parseManifest(document)]]);
    expect(events.manifest).toHaveBeenCalledTimes(1);
    expect(asked()).toBe("cde");
    for (const _ of "cde") await requests[0].answer(whole());
    await vi.advanceTimersByTimeAsync(60_000);
    expect(requests).toEqual([]);
  });

  it("is not asked for while nobody looks", async () => {
    open();
    await requests[0].answer(JSON.stringify(versions[0]));
    await vi.dynamicImportSettled();
    for (const _ of "12ab") await requests[0].answer(whole());
    hidden = true;
    await vi.advanceTimersByTimeAsync(60_000);
    expect(requests).toEqual([]);
    hidden = false;
    await vi.advanceTimersByTimeAsync(2000);
    expect(requests.length).toBe(1);
  });
});

const events = {
  manifest: vi.fn<SourceEvents["manifest"]>(),
  grown: vi.fn<SourceEvents["grown"]>(),
  chunk: vi.fn<SourceEvents["chunk"]>(),
  missing: vi.fn<SourceEvents["missing"]>(),
  progress: vi.fn<SourceEvents["progress"]>(),
  state: vi.fn<SourceEvents["state"]>(),
  failed: vi.fn<SourceEvents["failed"]>(),
};

function open(url = "https://cdn.example/studio/manifest.json?v=2"): HttpSource {
  for (const event of Object.values(events)) event.mockClear();
  source = new HttpSource(url, events, { time: 0, rate: 1 }, () => hidden);
  return source;
}

/** A source that has its manifest, and asks for what makes a picture: chunks 1 and a. */
async function begun(): Promise<HttpSource> {
  const opened = open();
  await requests[0].answer(MANIFEST);
  return opened;
}

/** A source that has a picture, and asks for chunks 2, b, c and d. */
async function pictured(): Promise<HttpSource> {
  const opened = await begun();
  for (const letter of "1a") await request(letter).answer(whole());
  return opened;
}

const request = (letter: string) => requests.find(({ url }) => url.endsWith(id(letter))) as Request;

describe("the manifest", () => {
  it("comes first, is asked for anew, and is handed on", async () => {
    open();
    expect(requests.map(({ url, cache }) => [url, cache])).toEqual([
      ["https://cdn.example/studio/manifest.json?v=2", "no-cache"],
    ]);
    await requests[0].answer(MANIFEST);
    expect(events.manifest.mock.calls).toEqual([[parseManifest(JSON.parse(MANIFEST))]]);
    expect(events.state.mock.calls.flat()).toEqual(["connecting", "open"]);
  });

  it.each([404, 410, 403])("that is not there (%i) is no scene", async (status) => {
    open();
    await requests[0].answer("", status);
    expect(events.failed).toHaveBeenCalledExactlyOnceWith("no-scene", expect.stringContaining(String(status)));
    await vi.advanceTimersByTimeAsync(60_000);
    expect(requests).toEqual([]);
  });

  it("that is locked asks for a key", async () => {
    open();
    await requests[0].answer("", 401);
    expect(events.failed).toHaveBeenCalledExactlyOnceWith("no-access", expect.stringContaining("401"));
    expect(events.state).toHaveBeenLastCalledWith("closed");
  });

  it("is asked for again later, and ever later, if the server cannot be reached", async () => {
    open();
    await requests[0].fail();
    expect(events.state).toHaveBeenLastCalledWith("retrying");
    await vi.advanceTimersByTimeAsync(500);
    await requests[0].answer("", 503);
    await vi.advanceTimersByTimeAsync(900);
    expect(requests).toEqual([]);
    await vi.advanceTimersByTimeAsync(100);
    await requests[0].answer(MANIFEST);
    expect(events.manifest).toHaveBeenCalledOnce();
  });

  it("is asked for at once when the network is back", async () => {
    const opened = open();
    await requests[0].fail();
    opened.wake();
    expect(requests).toHaveLength(1);
  });
});

describe("a manifest in pages", () => {
  const [first] = PAGED.pages;
  const index = "https://cdn.example/studio/index.hgs";
  const pages = () => requests.filter(({ url }) => url.endsWith(first.id));
  const manifest = parseManifest(PAGE_MANIFEST);

  it("brings the page at the playhead with what stands, and what it lists then", async () => {
    open(index);
    await requests[0].answer(PAGED.bytes);
    await vi.waitFor(() => expect(events.manifest).toHaveBeenCalledOnce());
    expect(requests.map(({ url }) => url.slice(-70))).toContain(`chunks/${first.id}`.slice(-70));
    await pages()[0].answer(first.bytes);
    await vi.waitFor(() => expect(events.grown).toHaveBeenCalledOnce());
    expect(events.grown.mock.calls[0][0].slices.slice(0, 8)).toEqual(manifest.slices.slice(0, 8));
    const [{ id }] = manifest.slices[0].chunks;
    expect(requests.some(({ url }) => url.endsWith(id))).toBe(true);
    expect([events.chunk.mock.calls, events.progress.mock.calls]).toEqual([[], []]);
  });

  it("asks for a page that is damaged again, past the caches", async () => {
    open(index);
    await requests[0].answer(PAGED.bytes);
    await vi.waitFor(() => expect(pages().length).toBe(1));
    await pages()[0].answer(new Uint8Array(first.bytes.length));
    await vi.waitFor(() => expect(events.state).toHaveBeenLastCalledWith("retrying"));
    await vi.advanceTimersByTimeAsync(500);
    expect(pages().map(({ cache }) => cache)).toEqual(["reload"]);
  });

  it.each(["{", "{}", Uint8Array.of(0x1f, 0x8b, 1)])("that cannot be read is told", async (answer) => {
    open(index);
    await requests[0].answer(answer);
    await vi.waitFor(() => expect(events.failed).toHaveBeenCalledOnce());
    expect(events.failed).toHaveBeenCalledWith("unreadable", expect.any(String));
  });
});

describe("chunks", () => {
  it("lie beside the manifest, and those come first and alone that make a picture", async () => {
    await begun();
    expect(requests.map(({ url }) => url)).toEqual([
      `https://cdn.example/studio/chunks/${id("1")}`,
      `https://cdn.example/studio/chunks/${id("a")}`,
    ]);
    await request("1").answer(whole());
    expect(asked()).toBe("a");
    expect(events.chunk).toHaveBeenCalledExactlyOnceWith(id("1"), whole());
    expect(events.progress).toHaveBeenCalledExactlyOnceWith(100);
  });

  it("come four at a time from then on", async () => {
    await pictured();
    expect(asked()).toBe("2bcd");
    await request("b").answer(whole());
    expect(asked()).toBe("2cde");
  });

  it("are all fetched once", async () => {
    await begun();
    while (requests.length > 0) await requests[0].answer(whole());
    expect(events.chunk.mock.calls.map(([name]) => name).sort()).toEqual(Array.from("12abcde", id));
    expect(events.missing).not.toHaveBeenCalled();
  });

  it("wait for a decoder that cannot keep up", async () => {
    const opened = await pictured();
    opened.consumed(-(17 << 20)); // as if so much had come
    await request("b").answer(whole());
    expect(asked()).toBe("2cd");
    opened.consumed(17 << 20);
    expect(asked()).toBe("2cde");
  });

  it("that a seek makes useless give way to those that it needs", async () => {
    const opened = await pictured();
    const given = request("b");
    opened.seek(45);
    await passed();
    expect(given.signal.aborted).toBe(true);
    expect(asked()).toBe("e");
    expect(events.missing).not.toHaveBeenCalled();
    expect(events.state).toHaveBeenLastCalledWith("open");
    await request("e").answer(whole());
    expect(asked()).toBe("2bcd");
  });

  it("are left where they are while nobody sees the page", async () => {
    const opened = await pictured();
    hidden = true;
    while (requests.length > 0) await requests[0].answer(whole());
    expect(events.chunk).toHaveBeenCalledTimes(6);
    hidden = false;
    opened.wake();
    expect(asked()).toBe("e");
  });
});

describe("a chunk that does not come", () => {
  it.each([404, 410])("because it is not there (%i) is missing, and not asked for again", async (status) => {
    await begun();
    await request("a").answer("", status);
    expect(events.missing).toHaveBeenCalledExactlyOnceWith(id("a"));
    while (requests.length > 0) await requests[0].answer(whole());
    expect(events.chunk).toHaveBeenCalledTimes(6);
  });

  it("is asked for again later, and then told to be there", async () => {
    await begun();
    await request("a").fail();
    expect(events.state).toHaveBeenLastCalledWith("retrying");
    expect(asked()).toBe("1");
    await vi.advanceTimersByTimeAsync(500);
    expect(asked()).toBe("1a");
    await request("a").answer(whole());
    expect(events.state).toHaveBeenLastCalledWith("open");
  });

  it("because the line breaks again and again is not given up", async () => {
    await begun();
    for (let i = 0; i < 5; i++) {
      await request("a").fail();
      await vi.advanceTimersByTimeAsync(8000);
    }
    expect(events.missing).not.toHaveBeenCalled();
    expect(asked()).toContain("a");
  });

  it("within ten seconds of silence is asked for again", async () => {
    await begun();
    const silent = request("a");
    await vi.advanceTimersByTimeAsync(10_000);
    expect(silent.signal.aborted).toBe(true);
    await vi.advanceTimersByTimeAsync(500);
    expect(asked()).toContain("a");
    expect(events.missing).not.toHaveBeenCalled();
  });

  it("because the server refuses three times is missing", async () => {
    await begun();
    for (let i = 0; i < 3; i++) {
      expect(events.missing).not.toHaveBeenCalled();
      await request("a").answer("", 500);
      await vi.advanceTimersByTimeAsync(8000);
    }
    expect(events.missing).toHaveBeenCalledExactlyOnceWith(id("a"));
  });

  it("because the key is no longer valid ends the scene", async () => {
    await begun();
    await request("a").answer("", 401);
    expect(events.failed).toHaveBeenCalledExactlyOnceWith("access-ended", expect.stringContaining("401"));
    await vi.advanceTimersByTimeAsync(60_000);
    expect(events.missing).not.toHaveBeenCalled();
  });

  it("whole is fetched past the caches, and taken only if it is whole", async () => {
    await begun();
    await request("a").answer(new Uint8Array(99));
    expect(events.chunk).not.toHaveBeenCalled();
    await vi.advanceTimersByTimeAsync(500);
    expect(request("a").cache).toBe("reload");
    await request("a").answer(whole());
    expect(events.chunk).toHaveBeenCalledOnce();
  });
});

it("brings a damaged chunk once more, past the caches", async () => {
  const opened = await begun();
  while (requests.length > 0) await requests[0].answer(whole());
  const again = opened.fetchAgain(id("a"), new AbortController().signal);
  expect(request("a").cache).toBe("reload");
  await request("a").answer(whole());
  expect(await again).toEqual(whole());
  const other = opened.fetchAgain(id("a"), new AbortController().signal);
  const refused = expect(other).rejects.toThrow("has 50 bytes, expected 100");
  await request("a").answer(new Uint8Array(50));
  await refused;
});

it("asks for all with the query that opens the scene", async () => {
  for (const event of Object.values(events)) event.mockClear();
  const url = "https://hgs.example/v1/scenes/studio/index.hgs";
  source = new HttpSource(url, events, { time: 0, rate: 1 }, () => hidden, "?link=x.y");
  expect(requests[0].url).toBe(`${url}?link=x.y`);
  await requests[0].answer(MANIFEST);
  expect(requests[0].url).toBe(`https://hgs.example/v1/scenes/studio/chunks/${id("1")}?link=x.y`);
});

it("asks for nothing after it is closed", async () => {
  const opened = await begun();
  opened.close();
  await passed();
  opened.wake();
  expect(requests).toEqual([]);
  expect(events.state).toHaveBeenLastCalledWith("closed");
});
