import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { openFiles } from "../../src/source/open_source";
import { openServed } from "../../src/source/served_source";
import { FakeSocket } from "../socket_double";
import { TWO_SEGMENTS } from "../worker_double";

const STREAM = "wss://h.example/lab/v1/scenes/studio/stream?link=abc";
const INDEX = "https://h.example/lab/v1/scenes/studio/index.hgs?link=abc";
const GZIPPED = await new Response(
  new Blob([TWO_SEGMENTS.toString()]).stream().pipeThrough(new CompressionStream("gzip")),
).arrayBuffer();

const sockets: FakeSocket[] = [];
const asked: string[] = [];
let answer: () => Promise<Response>;
let remarks: ReturnType<typeof vi.spyOn>;

const index = async () => new Response(GZIPPED);
const problem = (status: number, code: string) => async () => Response.json({ code }, { status });

function open() {
  const states: string[] = [];
  const events = {
    manifest: vi.fn(),
    grown: vi.fn(),
    chunk: vi.fn(),
    missing: vi.fn(),
    progress: vi.fn(),
    failed: vi.fn(),
    state: (state: string) => void states.push(state),
  };
  const connect = () => {
    sockets.push(new FakeSocket());
    return sockets[sockets.length - 1];
  };
  const source = openServed(STREAM, openFiles, connect)(events, { time: null, rate: 1 });
  return { source, events, states };
}

const last = () => sockets[sockets.length - 1];

/** Let the last of so many connections fail as a handshake does. */
async function refuse(attempt: number): Promise<void> {
  await vi.waitFor(() => expect(sockets.length).toBe(attempt));
  last().drop(1006);
}

/** Let every connection fail. */
async function refuseUntil(done: () => boolean): Promise<void> {
  await vi.waitFor(() => {
    if (done()) return;
    last().drop(1006);
    throw new Error("not yet");
  });
}

beforeEach(() => {
  sockets.length = asked.length = 0;
  answer = index;
  vi.stubGlobal("document", { hidden: false });
  vi.stubGlobal("fetch", (url: string | URL) => {
    asked.push(String(url));
    return String(url).includes("/chunks/") ? new Promise(() => {}) : answer();
  });
  remarks = vi.spyOn(console, "info").mockImplementation(() => {});
  vi.spyOn(Math, "random").mockReturnValue(0);
});
afterEach(() => {
  vi.unstubAllGlobals();
  vi.restoreAllMocks();
  vi.useRealTimers();
});

describe("where no handshake succeeds while the scene is there over HTTP", () => {
  it("loads the scene over HTTP, with its link, and says so once", async () => {
    const { source, events, states } = open();
    await refuseUntil(() => events.manifest.mock.calls.length > 0);
    expect(states.at(-1)).toBe("over-http");
    expect(states).not.toContain("retrying");
    expect(remarks).toHaveBeenCalledExactlyOnceWith(expect.stringMatching(/does not pass WebSockets; .*HTTP/));
    await vi.waitFor(() => expect(asked.some((url) => url.includes("/chunks/"))).toBe(true));
    expect(asked.filter((url) => !url.includes("/chunks/")).every((url) => url === INDEX)).toBe(true);
    const chunk = asked.find((url) => url.includes("/chunks/"));
    expect(chunk).toMatch(/^https:\/\/h\.example\/lab\/v1\/scenes\/studio\/chunks\/[0-9a-f]{64}\?link=abc$/);
    const attempts = sockets.length;
    expect(attempts).toBeLessThan(5);
    await new Promise((resolve) => setTimeout(resolve, 20));
    expect(sockets.length).toBe(attempts);
    source.close();
  });

  it("does so after one connection that was accepted and brings nothing", async () => {
    vi.useFakeTimers({ toFake: ["setInterval", "clearInterval", "performance"] });
    const { source, events, states } = open();
    last().open();
    vi.advanceTimersByTime(9000);
    await vi.waitFor(() => expect(events.manifest).toHaveBeenCalled());
    expect(states.at(-1)).toBe("over-http");
    source.close();
  });

  it("does so after connections that were accepted and dropped before their welcome", async () => {
    const { source, events } = open();
    await refuseUntil(() => {
      last().open();
      return events.manifest.mock.calls.length > 0;
    });
    source.close();
  });

  it("goes on with the stream where only the first one failed", async () => {
    const { source, events, states } = open();
    await refuse(1);
    await vi.waitFor(() => expect(sockets.length).toBe(2));
    last().open();
    last().welcome();
    await vi.waitFor(() => expect(states.at(-1)).toBe("open"));
    expect(events.manifest).toHaveBeenCalledOnce();
    expect(remarks).not.toHaveBeenCalled();
    source.close();
  });
});

describe("where the server is away", () => {
  it.each<[string, () => Promise<Response>]>([
    ["does not answer", () => Promise.reject(new TypeError("no network"))],
    ["is behind a proxy that says so", problem(502, "")],
    ["has no room", problem(503, "server-busy")],
    ["is another one, with a page for every address", async () => new Response("<!doctype html>")],
    ["is unknown to the proxy", async () => new Response("<h1>404</h1>", { status: 404 })],
  ])("tries the stream again while it %s", async (_, answered) => {
    answer = answered;
    const { source, events, states } = open();
    for (const attempt of [1, 2, 3]) await refuse(attempt);
    await vi.waitFor(() => expect(states).toContain("retrying"));
    answer = index;
    await vi.waitFor(() => expect(sockets.length).toBe(4));
    last().open();
    last().welcome();
    await vi.waitFor(() => expect(states.at(-1)).toBe("open"));
    expect(events.failed).not.toHaveBeenCalled();
    source.close();
  });
});

describe("where the scene is refused over HTTP, too", () => {
  it.each<[string, () => Promise<Response>]>([
    ["no-access", problem(401, "key-needed")],
    ["no-access", problem(403, "not-allowed")],
    ["no-access", async () => new Response("", { status: 401 })],
    ["no-scene", problem(404, "scene-not-found")],
  ])("ends with %s", async (failure, answered) => {
    answer = answered;
    const { events, states } = open();
    await refuse(1);
    await vi.waitFor(() => expect(events.failed).toHaveBeenCalledWith(failure, expect.any(String)));
    expect(states.at(-1)).toBe("closed");
  });
});

it("asks nothing over HTTP once a stream has worked", async () => {
  const { source, states } = open();
  last().open();
  last().welcome();
  await vi.waitFor(() => expect(states.at(-1)).toBe("open"));
  for (const attempt of [1, 2, 3]) await refuse(attempt);
  expect(asked).toEqual([]);
  expect(states.filter((state) => state === "retrying").length).toBe(3);
  source.close();
});

it("is silent once it is closed", async () => {
  const { source, events } = open();
  await refuse(1);
  source.close();
  await new Promise((resolve) => setTimeout(resolve, 20));
  expect(events.manifest).not.toHaveBeenCalled();
  expect(sockets.length).toBe(1);
});
