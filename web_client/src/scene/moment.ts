/** The moments that one order of splats can be drawn at. An order belongs to one segment. */

import { sliceAt } from "../codec/manifest_chunks";
import type { Manifest, SegmentEntry } from "../codec/types";
import type { Playback } from "./playback";

export interface Moment {
  /** Seconds: the moment of which the order is exact. */
  readonly time: number;
  /** Seconds: what is alive from `from` until `until` is in the order; `time` lies between. */
  readonly from: number;
  readonly until: number;
}

/** A picture this much beside its order's moment, in seconds, is drawn at that moment: a step that no eye sees. */
const SNAP = 0.002;

/** The segment that is shown at `time`, seconds; undefined where nothing moves. */
function segmentAt({ slices, segments }: Manifest, time: number): SegmentEntry | undefined {
  const slice = slices[sliceAt(slices, time)];
  return slice && segments[slice.segment];
}

/** The moments from `from` until `until`, cut to the segment of `time`; seconds. */
export function momentOf(manifest: Manifest, time: number, from = time, until = time): Moment {
  const segment = segmentAt(manifest, time);
  return {
    time,
    from: Math.min(time, Math.max(from, segment?.start ?? from)),
    until: Math.max(time, Math.min(until, segment?.end ?? until)),
  };
}

/** For at least so long an order can be drawn while the scene moves, seconds, should the next one be late. */
const SHORTEST_USE = 0.05;

/**
 * What to order: at rest the very moment, else the one at which the order will be shown and those about it. While that lacks
 * its base, what was shown last; null if nothing was.
 *
 * @param lead seconds until the order will be shown.
 */
export function nextMoment({ clock, moving, buffer }: Playback, shown: Moment | null, lead: number): Moment | null {
  const now = clock.time;
  if (!buffer.playable(now)) return shown && momentOf(buffer.manifest, shown.time);
  if (!moving) return momentOf(buffer.manifest, now);
  const next = clock.after(lead);
  const time = buffer.playable(next) ? next : now;
  const until = time + clock.rate * Math.max(SHORTEST_USE, 2 * lead);
  return momentOf(buffer.manifest, time, Math.min(now, time), until);
}

/** An order this far from the playhead, in seconds, is not late or early: the playhead has jumped, or will. */
const JUMP = 0.25;

/** When to draw by an order while the playhead is at `playhead`, seconds: as near to that as the order allows. */
export function drawnTime({ time, from, until }: Moment, playhead: number): number {
  const snaps = Math.abs(playhead - time) <= SNAP;
  if (snaps || playhead < from - JUMP || playhead > until + JUMP) return time;
  return Math.min(until, Math.max(from, playhead));
}

/** A time of the moment's segment as the renderer takes it, in [0, 1]. */
export function normalised(manifest: Manifest, moment: Moment, time: number): number {
  const segment = segmentAt(manifest, moment.time);
  if (!segment) return 0;
  const duration = segment.end - segment.start;
  return duration > 0 ? (time - segment.start) / duration : 0;
}
