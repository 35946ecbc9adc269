/** The source for a scene of a server: its stream, or HTTP where WebSockets do not get through. */

import type { Socket } from "../protocol/connection";
import type { OpenSource, SceneSource, SourceEvents, SourceState } from "./scene_source";
import { SceneStream } from "./scene_stream";

/**
 * Failed connections, while HTTP worked, before the stream is given up: a single one may come from a restart of the
 * server.
 */
const ENOUGH = 2;

/**
 * Open a scene of a server.
 *
 * @param stream `ws://host/v1/scenes/{scene}/stream`, with the link that grants access.
 * @param openFiles opens a scene by the address of its index and a query.
 */
export function openServed(
  stream: string,
  openFiles: (index: string, query: string) => OpenSource,
  connect?: (url: string) => Socket,
): OpenSource {
  return (events, playhead) => {
    let failures = 0; // consecutive failures with an answer over HTTP after each
    let hopeful = true; // true until a connection was there or the server is known to be down
    let asking: AbortController | null = null;
    const watched: SourceEvents = {
      ...events,
      state(state: SourceState) {
        if (state === "open") {
          hopeful = false;
          asking?.abort();
        }
        events.state(state === "retrying" && hopeful ? "connecting" : state);
      },
    };
    const socketed = new SceneStream(stream, watched, playhead, connect, (silent) => void ask(silent));
    let source: SceneSource = socketed;

    /** Check the scene over HTTP, and act on the answer. */
    async function ask(silent: boolean): Promise<void> {
      if (asking) return;
      asking = new AbortController();
      const { signal } = asking;
      const words = await import("./http_instead").catch(() => null);
      const answer = (await words?.askOverHttp(stream, signal)) ?? "away";
      if (signal.aborted) return;
      asking = null;
      if (answer === "away") {
        failures = 0;
        hopeful = false;
        events.state("retrying");
      } else if (answer !== "there") {
        source.close();
        events.failed(answer, "the scene is refused over HTTP, too");
      } else if (++failures < ENOUGH && !silent) {
        source.wake();
      } else {
        socketed.close();
        source = words?.openInstead(stream, openFiles)(events, playhead) ?? source;
      }
    }

    return {
      play: (time, rate) => source.play(time, rate),
      pause: (time) => source.pause(time),
      seek: (time) => source.seek(time),
      playheadAt: (time) => source.playheadAt(time),
      consumed: (bytes) => source.consumed(bytes),
      fetchAgain: (...chunk) => source.fetchAgain(...chunk),
      wake: () => source.wake(),
      close() {
        asking?.abort();
        source.close();
      },
    };
  };
}
