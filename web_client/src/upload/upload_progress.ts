/** The progress of an upload: its speed, and its state in words. */

import { formatBytes } from "../dom/format";
import type { Transfer } from "./transfer";

const WINDOW = 10; // seconds
const LEAST = 2; // seconds before the first estimate

export class Speed {
  #samples: { readonly time: number; readonly bytes: number }[] = [];

  /** Note the total of bytes at a time in seconds. */
  note(bytes: number, time: number): void {
    this.#samples.push({ time, bytes });
    while (this.#samples.length > 2 && this.#samples[1].time < time - WINDOW) this.#samples.shift();
  }

  /** Start again, after a pause. */
  reset(): void {
    this.#samples = [];
  }

  /** Bytes per second; null while unknown. */
  perSecond(): number | null {
    const first = this.#samples[0];
    const last = this.#samples.at(-1);
    if (!first || !last || last.time - first.time < LEAST || last.bytes <= first.bytes) return null;
    return (last.bytes - first.bytes) / (last.time - first.time);
  }
}

/** "about 3 min left"; "" while unknown. */
export function describeRest(bytes: number, perSecond: number | null): string {
  if (perSecond === null) return "";
  const seconds = bytes / perSecond;
  if (seconds < 60) return "less than a minute left";
  const minutes = Math.round(seconds / 60);
  return minutes < 90 ? `about ${minutes} min left` : `about ${Math.round(minutes / 60)} h left`;
}

/** "1.2 GB of 2.0 GB · 34 MB/s · about 3 min left". */
export function describeTransfer(
  { state, reading, sent, total, problem }: Pick<Transfer, "state" | "reading" | "sent" | "total" | "problem">,
  perSecond: number | null,
): string {
  const amount = `${formatBytes(sent)} of ${formatBytes(total)}`;
  switch (state) {
    case "sending": {
      if (reading) return `Reading the files · ${amount}`;
      const parts = [amount];
      if (perSecond !== null) parts.push(`${formatBytes(perSecond)}/s`, describeRest(total - sent, perSecond));
      return parts.join(" · ");
    }
    case "paused":
      return `Paused · ${amount}`;
    case "waiting":
      return `Waiting to try again: ${problem} · ${amount}`;
    case "finishing":
      return "Everything is sent. The server is checking it …";
    case "done":
      return `Sent · ${formatBytes(total)}`;
    case "failed":
      return problem
        .replace(/^The server answered \d+: /, "")
        .replace(/^[a-z](?=[a-z]* )/, (letter) => letter.toUpperCase());
  }
}
