/** Times of pieces of sound: the scene's time on the clock of the sound, and the parts due on it. It plays nothing. */

import type { SoundPiece } from "../codec/audio_entry";

/** A line: the scene's time s is due at `zero + s / rate`, seconds of the sound's clock. */
export interface Line {
  readonly zero: number;
  /** Scene seconds per second. */
  readonly rate: number;
}

/** A part of a piece: scene seconds `from` to `until`, due from `when` on, seconds of the sound's clock. */
export interface Part {
  readonly when: number;
  readonly from: number;
  readonly until: number;
}

/**
 * Offset from the picture that is corrected at once, seconds: after a seek, a new start, or a stutter of the device.
 */
const FAR = 0.06;
/** Lasting offset from the picture that is corrected, seconds; less is noise of the clocks, and inaudible. */
const NEAR = 0.012;
/** Weight of a frame in the mean offset between sound and picture. */
const WEIGHT = 0.1;

/** Synchronisation without corrections of every millisecond: each correction is a gap, if one of a few milliseconds. */
export class Alignment {
  #line: Line | null = null;
  #apart = 0; // mean offset, seconds

  /** The line for scheduling, given the ideal one now; the same object until it changes. */
  follow(wanted: Line): Line {
    const line = this.#line;
    const apart = line ? wanted.zero - line.zero : 0;
    if (!line || line.rate !== wanted.rate || Math.abs(apart) > FAR) return this.#take(wanted);
    this.#apart += WEIGHT * (apart - this.#apart);
    if (Math.abs(this.#apart) <= NEAR) return line;
    return this.#take({ zero: line.zero + this.#apart, rate: line.rate });
  }

  /** Start again with the next line. */
  forget(): void {
    this.#line = null;
  }

  #take(line: Line): Line {
    this.#line = line;
    this.#apart = 0;
    return line;
  }
}

/** The part of a piece that is still due at `now`, seconds of the sound's clock; null if none is. */
export function partToHear(pieces: readonly SoundPiece[], index: number, line: Line, now: number): Part | null {
  const { start, end } = pieces[index];
  const until = Math.min(end, pieces[index + 1]?.start ?? end);
  const from = Math.max(start, (now - line.zero) * line.rate);
  return from < until ? { when: line.zero + from / line.rate, from, until } : null;
}

/** The piece at a time, or the next one; -1 after the last. */
export function pieceAt(pieces: readonly SoundPiece[], time: number): number {
  let [low, high] = [0, pieces.length]; // `low` pieces or more are over, and fewer than all up to `high`
  while (low < high) {
    const middle = (low + high) >> 1;
    if (pieces[middle].end > time) high = middle;
    else low = middle + 1;
  }
  return low < pieces.length ? low : -1;
}
