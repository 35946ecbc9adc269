/** A source with a module that is loaded on demand, so that pages with other scenes do without it. */

import type { OpenSource, SceneSource } from "./scene_source";

/**
 * Open a source when its module has arrived. Until the manifest is there, no seek time is known and there are no
 * chunks.
 *
 * @param load the module; a rejection becomes the failure `not-loaded`.
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
