/** The check of a capture before training: whether poses, clocks and pictures fit (docs/checking.md). */

import { element } from "../dom/element";
import { formatDuration } from "../dom/format";
import type { Capture } from "../protocol/api";
import { type CaptureCheck, type Finding, getCheck, startCheck } from "../protocol/uploads";

const EVERY = 1000; // milliseconds between two requests
const WITHOUT_POSES = "videos without poses"; // layout of docs/rest.md

export class CheckPanel {
  readonly node = element("div", { class: "check" });
  readonly #trust = element("input", { type: "checkbox" });
  #asking = new AbortController();

  /** Whether to train the capture regardless of the result. */
  get trusted(): boolean {
    return this.#trust.isConnected && this.#trust.checked;
  }

  /** Offer the check of a capture; `atOnce` begins it. */
  show(capture: Capture | undefined, atOnce: boolean): void {
    this.#asking.abort();
    this.#asking = new AbortController();
    this.#trust.checked = false;
    this.node.replaceChildren();
    if (!capture || capture.problem !== null) return;
    if (capture.layout === WITHOUT_POSES) {
      this.#write("It has no camera poses. The job first finds them from the videos.");
      return;
    }
    const button = element("button", { type: "button", class: "button" }, "Check it");
    button.addEventListener("click", () => void this.#run(capture));
    this.node.replaceChildren(
      element("p", { class: "hint" }, "Check poses, clocks and pictures now. Every job starts with this check, too."),
      button,
    );
    if (atOnce) void this.#run(capture);
  }

  async #run(capture: Capture): Promise<void> {
    const { signal } = this.#asking;
    this.#write("Checking the capture …");
    try {
      let check = await startCheck(capture.capture);
      while (check.state === "waiting" || check.state === "running") {
        if (signal.aborted) return;
        const waits = check.state === "waiting" ? "Waiting for the check of another capture" : "Checking the capture";
        this.#write(`${waits} … ${formatDuration(Math.round(check.seconds)).replace(".0", "")}`);
        await new Promise((resolve) => setTimeout(resolve, EVERY));
        check = await getCheck(capture.capture, signal);
      }
      if (!signal.aborted) this.#show(check);
    } catch (error) {
      if (!signal.aborted) this.#write(error instanceof Error ? error.message : String(error));
    }
  }

  #write(text: string): void {
    this.node.replaceChildren(element("p", { class: "hint" }, text));
  }

  #show({ found, error }: CaptureCheck): void {
    if (found === null) {
      this.#write(`The check failed: ${error}`);
      return;
    }
    const head = found.stops
      ? "This capture would not train well:"
      : found.findings.length > 0
        ? "It can be trained, with these warnings:"
        : "No problems found: poses, clocks and pictures agree.";
    this.node.replaceChildren(
      element("p", { class: found.stops ? "check-head wrong" : "check-head", role: "status" }, head),
      ...(found.findings.length > 0 ? [element("ul", { class: "findings" }, ...found.findings.map(findingItem))] : []),
      element(
        "details",
        {},
        element("summary", {}, `Figures of ${found.cameras.length} cameras`),
        element("div", { class: "check-table", tabindex: 0, role: "region", "aria-label": "Figures" }, table(found)),
      ),
      ...(found.stops
        ? [element("label", { class: "camera" }, this.#trust, "Train it anyway: the job then ignores these problems")]
        : []),
    );
  }
}

const findingItem = ({ stops, cameras, problem, cure }: Finding): HTMLElement =>
  element(
    "li",
    { class: stops ? "wrong" : "" },
    cameras.length > 0 ? element("strong", {}, `${cameras.join(", ")}: `) : null,
    `${problem}. `,
    element("span", { class: "cure" }, `${cure.charAt(0).toUpperCase()}${cure.slice(1)}.`),
  );

function table(found: NonNullable<CaptureCheck["found"]>): HTMLElement {
  const about = (name: string) => found.findings.filter(({ cameras }) => cameras.includes(name));
  const mark = (name: string) => {
    const all = about(name);
    return all.length === 0 ? "" : all.some(({ stops }) => stops) ? "stop" : "look";
  };
  return element(
    "table",
    {},
    element(
      "thead",
      {},
      element(
        "tr",
        {},
        ...["Camera", "Partners", "Matches", "Off, px", "Ahead, frames", ""].map((name) => element("th", {}, name)),
      ),
    ),
    element(
      "tbody",
      {},
      ...found.cameras.map(({ name, partners, matches, error, ahead }) =>
        element(
          "tr",
          { class: mark(name) },
          element("th", { scope: "row" }, name),
          element("td", {}, String(partners)),
          element("td", {}, matches.toLocaleString("en")),
          element("td", {}, error === null ? "–" : error.toFixed(2)),
          element("td", {}, ahead === null ? "–" : (Math.round(10 * ahead) / 10 + 0).toFixed(1)),
          element("td", {}, mark(name)),
        ),
      ),
    ),
  );
}
