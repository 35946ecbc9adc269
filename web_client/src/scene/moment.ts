/** The moments at which one order of splats can be drawn. An order belongs to one segment. */

import { sliceAt } from "../codec/manifest_chunks";
import type { Manifest, SegmentEntry } from "../codec/types";
import type { Playback } from "./playback";

export interface Moment {
  /** Seconds: the order is exact at this moment. */
  readonly time: number;
  /** Seconds: the order contains all splats alive from `from` until `until`; `time` lies between. */
  readonly from: number;
  readonly until: number;
}

/** Difference from an order's moment, seconds, that is too small to see: the picture is drawn at the order's moment. */
const SNAP = 0.002;

/** The segment shown at `time`, seconds; undefined if nothing moves. */
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

/** Shortest use of an order while the scene moves, seconds, in case the next one is late. */
const SHORTEST_USE = 0.05;

/**
 * The moment of the next order: at rest the playhead's, otherwise the one at which the order will be shown, and those
 * around it. While that lacks its base, the last one shown; null if there was none.
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

/**
 * Distance from the playhead, in seconds, beyond which an order is not late or early: the playhead has jumped, or will.
 */
const JUMP = 0.25;

/** The time of a picture by an order while the playhead is at `playhead`, seconds: as near as the order allows. */
export function drawnTime({ time, from, until }: Moment, playhead: number): number {
  const snaps = Math.abs(playhead - time) <= SNAP;
  if (snaps || playhead < from - JUMP || playhead > until + JUMP) return time;
  return Math.min(until, Math.max(from, playhead));
}

/** A time of the moment's segment in the renderer's unit, [0, 1]. */
export function normalised(manifest: Manifest, moment: Moment, time: number): number {
  const segment = segmentAt(manifest, moment.time);
  if (!segment) return 0;
  const duration = segment.end - segment.start;
  return duration > 0 ? (time - segment.start) / duration : 0;
}
