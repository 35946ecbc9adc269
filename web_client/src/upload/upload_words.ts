/** Uploads in words. */

import { formatBytes } from "../dom/format";
import type { Transfer } from "./transfer";

/** "about 3 min left"; "" while nobody can tell. */
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
