/** When pieces of sound are to be heard: the scene's time on the clock of the sound, and pieces on that. Plays nothing. */

import type { SoundPiece } from "../codec/audio_entry";

/** The scene's time s is heard at `zero + s / rate`, seconds of the sound's clock. */
export interface Line {
  readonly zero: number;
  /** Scene seconds per second. */
  readonly rate: number;
}

/** A part of a piece: scene seconds `from` to `until`, to be heard from `when` on, seconds of the sound's clock. */
export interface Part {
  readonly when: number;
  readonly from: number;
  readonly until: number;
}

/** Sound that is farther from its picture is put right at once, seconds: a seek, a new beginning, a device that stuttered. */
const FAR = 0.06;
/** Sound that stays so far from its picture is put right, too; less is noise of the clocks, and below what anybody hears. */
const NEAR = 0.012;
/** Weight of a frame in the mean of what sound and picture are apart. */
const WEIGHT = 0.1;

/** Keeps sound in step without touching it for every millisecond: each correction is a gap, if one of a few milliseconds. */
export class Alignment {
  #line: Line | null = null;
  #apart = 0; // seconds, a mean

  /**
   * The line by which pieces are to be heard, given by which they should be, now; the same object until it changes.
   */
  follow(wanted: Line): Line {
    const line = this.#line;
    const apart = line ? wanted.zero - line.zero : 0;
    if (!line || line.rate !== wanted.rate || Math.abs(apart) > FAR) return this.#take(wanted);
    this.#apart += WEIGHT * (apart - this.#apart);
    if (Math.abs(this.#apart) <= NEAR) return line;
    return this.#take({ zero: line.zero + this.#apart, rate: line.rate });
  }

  /** Begin anew with the next line. */
  forget(): void {
    this.#line = null;
  }

  #take(line: Line): Line {
    this.#line = line;
    this.#apart = 0;
    return line;
  }
}

/** What of a piece can still be heard from `now` on, seconds of the sound's clock; null for nothing. */
export function partToHear(pieces: readonly SoundPiece[], index: number, line: Line, now: number): Part | null {
  const { start, end } = pieces[index];
  const until = Math.min(end, pieces[index + 1]?.start ?? end);
  const from = Math.max(start, (now - line.zero) * line.rate);
  return from < until ? { when: line.zero + from / line.rate, from, until } : null;
}

/** The piece that sounds at a time, or the next one; -1 after the last. */
export function pieceAt(pieces: readonly SoundPiece[], time: number): number {
  let [low, high] = [0, pieces.length]; // of those that are over, there are at least `low`, and fewer than all up to `high`
  while (low < high) {
    const middle = (low + high) >> 1;
    if (pieces[middle].end > time) high = middle;
    else low = middle + 1;
  }
  return low < pieces.length ? low : -1;
}
