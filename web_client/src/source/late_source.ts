/** A source whose module is loaded when a scene needs it, so that a page with scenes of other kinds goes without. */

import type { OpenSource, SceneSource } from "./scene_source";

/**
 * Until the source has brought a manifest nobody knows a time to seek, and there are no chunks.
 *
 * @param load the module; what it rejects with is told as the failure `not-loaded`.
 */
export function openLate(load: () => Promise<OpenSource>): OpenSource {
  return (events, playhead) => {
    let source: SceneSource | null = null;
    let closed = false;
    const close = (): void => {
      closed = true;
      if (source) source.close();
      else events.state("closed");
    };
    events.state("connecting");
    const opened = load().then((open) => {
      if (closed) throw new DOMException("closed before it could open", "AbortError");
      source = open(events, playhead);
      return source;
    });
    opened.catch((error) => {
      if (closed) return;
      close();
      events.failed("not-loaded", error instanceof Error ? error.message : String(error));
    });
    return {
      play: (time, rate) => source?.play(time, rate),
      pause: (time) => source?.pause(time),
      seek: (time) => source?.seek(time),
      playheadAt: (time) => source?.playheadAt(time),
      consumed: (bytes) => source?.consumed(bytes),
      fetchAgain: async (...chunk) => (await opened).fetchAgain(...chunk),
      wake: () => source?.wake(),
      close,
    };
  };
}
