/** The end of a job's log, updated while it is open. */

import { element, setText } from "../dom/element";
import { getJobLog } from "../protocol/api";

const LINES = 200;
const AGAIN = 3000; // ms

export class JobLogPanel {
  readonly #text = element("pre", { class: "log", tabindex: 0, role: "region", "aria-label": "Log" });
  readonly node = element("details", { class: "panel" }, element("summary", {}, "Log"), this.#text);
  #going = false;
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    readonly job: string,
    readonly signal: AbortSignal,
  ) {
    this.node.addEventListener("toggle", () => void this.#look());
    signal.addEventListener("abort", () => clearTimeout(this.#timer));
  }

  /** Set whether the job, and so its log, continues. */
  follow(going: boolean): void {
    if (going === this.#going) return;
    this.#going = going;
    void this.#look(); // also once at the end
  }

  async #look(): Promise<void> {
    clearTimeout(this.#timer);
    if (!this.node.open) return;
    try {
      const { lines, complete } = await getJobLog(this.job, LINES, this.signal);
      const text = lines.length === 0 ? "Nothing has been written yet." : lines.join("\n");
      const atEnd = this.#text.scrollHeight - this.#text.scrollTop - this.#text.clientHeight < 4;
      setText(this.#text, complete ? text : `…\n${text}`);
      if (atEnd) this.#text.scrollTop = this.#text.scrollHeight;
    } catch (error) {
      if (this.signal.aborted) return;
      setText(this.#text, error instanceof Error ? error.message : String(error));
    }
    clearTimeout(this.#timer);
    if (this.#going) this.#timer = setTimeout(() => void this.#look(), AGAIN);
  }
}
