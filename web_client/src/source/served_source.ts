/** A scene of a server: its stream, or the same scene over HTTP where something on the way lets no WebSocket through. */

import type { Socket } from "../protocol/connection";
import type { OpenSource, SceneSource, SourceEvents, SourceState } from "./scene_source";
import { SceneStream } from "./scene_stream";

/** Connections that have failed while the scene could be had over HTTP: a single one may be that of a server that restarts. */
const ENOUGH = 2;

/**
 * @param stream `ws://host/v1/scenes/{scene}/stream`, with the link that opens it.
 * @param openFiles opens a scene by the address of its index, and the query that opens it.
 */
export function openServed(
  stream: string,
  openFiles: (index: string, query: string) => OpenSource,
  connect?: (url: string) => Socket,
): OpenSource {
  return (events, playhead) => {
    let failures = 0; // one after the other, with an answer over HTTP after each
    let hopeful = true; // nothing has been there that could be lost, nor is the server known to be away
    let asking: AbortController | null = null;
    const told: SourceEvents = {
      ...events,
      state(state: SourceState) {
        if (state === "open") {
          hopeful = false;
          asking?.abort();
        }
        events.state(state === "retrying" && hopeful ? "connecting" : state);
      },
    };
    const socketed = new SceneStream(stream, told, playhead, connect, (silent) => void ask(silent));
    let source: SceneSource = socketed;

    /** Find out what HTTP says of the scene, and act upon it. */
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
