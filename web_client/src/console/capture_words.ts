/** Captures in words. */

import type { Capture } from "../protocol/api";
import { formatDuration } from "../ui/format";

const counted = (count: number, noun: string): string =>
  `${count.toLocaleString("en")} ${noun}${count === 1 ? "" : "s"}`;

/** "16 cameras · 60 frames · 2.0 s", "49 photographs of a still scene". */
export function describeCapture({ cameras, frames, seconds }: Capture): string {
  if (frames === 1) return `${counted(cameras.length, "photograph")} of a still scene`;
  const parts = [counted(cameras.length, "camera")];
  if (frames !== null) parts.push(counted(frames, "frame"));
  if (seconds !== null) parts.push(formatDuration(seconds));
  return parts.join(" · ");
}
