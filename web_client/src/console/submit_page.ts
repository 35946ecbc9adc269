/** The form for a new scene: a capture, a training preset, and the cameras that are held out to check it. */

import "./form.css";
import { element, setText } from "../dom/element";
import { formatBytes, formatDuration } from "../dom/format";
import { ApiError, type Capture, type CaptureList, listCaptures, submitJob, type TrainingPrice } from "../protocol/api";
import { siteUrl } from "../protocol/http";
import { CameraChoice } from "./camera_choice";
import { CheckPanel } from "./check_panel";
import { choices, chosenIn, type Field, FormField, fieldOf, reasonOf } from "./form_field";
import { captureOf } from "./page_address";
import { SentCaptures } from "./sent_captures";
import { emptyState, type Shell, showShell } from "./shell";
import { UploadPanel } from "./upload_panel";

const LONGEST_TITLE = 200; // characters, as in docs/rest.md
const LEAST_CAMERAS = 2; // cameras that training needs
const HOURS_FROM = 120; // minutes
const LOOK_AGAIN_MS = 2000; // ms between requests while the server checks captures

const PRESETS = [
  { value: "preview", title: "Preview", note: "A quick first look" },
  { value: "standard", title: "Standard", note: "A finished scene" },
  { value: "best", title: "Best", note: "The best picture" },
];

export function showSubmitPage(root: HTMLElement): void {
  document.title = "New scene · HGS";
  const shell = showShell(root, "submit-page");
  shell.main.append(element("h1", {}, "New scene"));
  const body = element("div", {}, element("p", { class: "hint", role: "status" }, "Loading captures …"));
  shell.main.append(body);
  const abort = new AbortController();
  addEventListener("pagehide", () => abort.abort(), { once: true });
  const panel = new UploadPanel((path) => void show(path));
  const sent = new SentCaptures(() => void show());
  let touched = false; // an edited form stays unchanged
  body.addEventListener("input", () => {
    touched = true;
  });
  /** Show the captures; one that was just sent is selected and checked. */
  const show = async (uploaded = ""): Promise<void> => {
    try {
      const list = await listCaptures(abort.signal);
      if (list.captures.some(({ looking }) => looking))
        setTimeout(() => {
          if (!touched && !abort.signal.aborted) void show(uploaded);
        }, LOOK_AGAIN_MS);
      void sent.refresh();
      touched = false;
      const form = list.captures.length > 0 ? new SubmitForm(list, shell, panel.node, sent.node, uploaded).node : null;
      body.replaceChildren(form ?? noCaptures(list, panel.node, sent.node));
    } catch (error) {
      if (abort.signal.aborted) return;
      body.replaceChildren();
      shell.problem(error);
    }
  };
  void show(captureOf(location.search));
}

/** The hint without captures. */
function noCaptures({ folders }: CaptureList, ...sending: HTMLElement[]): HTMLElement {
  const there = folders.filter(({ exists }) => exists);
  const paths = (there.length > 0 ? there : folders).map(({ path }) => element("li", {}, element("code", {}, path)));
  const retry = element("a", { class: "button primary", href: siteUrl("new") }, "Refresh");
  if (folders.length === 0)
    return emptyState(
      "This server reads no captures",
      element(
        "p",
        { class: "hint" },
        "The person who runs it can restart it with hgs serve --captures FOLDER. Or send one:",
      ),
      ...sending,
    );
  return emptyState(
    "No captures yet",
    ...sending,
    element(
      "p",
      { class: "hint" },
      there.length > 0
        ? "Or copy the folder of a capture, its videos and camera poses, into this folder of the server:"
        : "Or make this folder on the server, and copy the folder of a capture into it, its videos and camera poses:",
    ),
    element("ul", { class: "paths" }, ...paths),
    retry,
  );
}

class SubmitForm {
  readonly node: HTMLFormElement;
  readonly #capture: FormField;
  readonly #title = element("input", {
    class: "input",
    maxlength: LONGEST_TITLE,
    autocomplete: "off",
    "aria-label": "Name",
  });
  readonly #cameras = new CameraChoice();
  readonly #more = element("details", { class: "more-settings" }, element("summary", {}, "More settings"));
  readonly #fields: Readonly<Record<Field, FormField>>;
  readonly #submit = element("button", { class: "button primary" }, "Start");
  readonly #check = new CheckPanel();

  /**
   * Create the form.
   *
   * @param sending the part of the page for uploads
   * @param uploaded the path of a finished upload, which is or contains a capture; "" for none
   */
  constructor(
    readonly list: CaptureList,
    readonly shell: Shell,
    sending: HTMLElement,
    sent: HTMLElement,
    uploaded: string,
  ) {
    const usable = list.captures.filter(({ problem }) => problem === null);
    const offered = list.captures.map((capture) => ({
      value: capture.capture,
      title: capture.name,
      note: describeCapture(capture),
      problem: capture.problem ?? "",
      picture: capture.picture,
    }));
    const within = (path: string) => path === uploaded || path.startsWith(`${uploaded}/`);
    const arrived = uploaded === "" ? undefined : list.captures.find(({ capture }) => within(capture));
    const first = arrived?.problem === null ? arrived.capture : usable.length === 1 ? usable[0].capture : "";
    this.#capture = new FormField(
      "capture",
      "Capture",
      [choices("capture", offered, first), this.#check.node, sending, sent],
      list.complete ? "" : "The server has more captures than this list can show.",
    );
    this.#fields = {
      capture: this.#capture,
      title: new FormField("title", "Name of the scene", [this.#title]),
      preset: new FormField("preset", "Quality", [choices("preset", PRESETS, "standard")]),
      hold_out: new FormField(
        "hold_out",
        "Cameras to check the scene with",
        [this.#cameras.node],
        "Training does not use their pictures. Unless you choose others, it is the middle camera of six or more.",
      ),
    };
    const { capture, title, preset, hold_out } = this.#fields;
    this.#more.append(title.node, hold_out.node);
    this.#more.addEventListener("toggle", () => this.#cameras.look());
    this.node = element(
      "form",
      { class: "form", novalidate: true },
      capture.node,
      preset.node,
      this.#more,
      element(
        "div",
        { class: "form-actions" },
        this.#submit,
        element("a", { class: "button", href: siteUrl("") }, "Cancel"),
      ),
    );
    this.#capture.node.addEventListener("change", ({ target }) => {
      if (target instanceof HTMLInputElement && target.name === "capture") this.#choose(false);
    });
    this.node.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#send();
    });
    this.#choose(arrived !== undefined);
    if (arrived && arrived.problem !== null && !arrived.looking)
      this.#capture.fault(
        `The upload is not a complete capture: ${arrived.problem}. Add the missing files and send the folder again.`,
      );
    if (uploaded !== "")
      queueMicrotask(() => this.#capture.node.querySelector(":checked")?.scrollIntoView({ block: "nearest" }));
  }

  #chosen(): Capture | undefined {
    const name = chosenIn(this.#capture.node);
    return this.list.captures.find(({ capture }) => capture === name);
  }

  /** Offer the cameras of the capture, and its name as the scene's title. */
  #choose(checked: boolean): void {
    const chosen = this.#chosen();
    this.#title.placeholder = chosen?.name.split("/").at(-1) ?? "";
    this.#capture.fault("");
    this.#check.show(chosen, checked);
    this.#fields.hold_out.node.hidden = !chosen || chosen.cameras.length <= LEAST_CAMERAS;
    this.#fields.hold_out.fault("");
    for (const { value, note } of PRESETS)
      setText(this.#note(value), [note, priceWords(chosen?.presets?.[value])].filter(Boolean).join(" · "));
    this.#cameras.show(chosen);
  }

  /** The explanation of a preset. */
  #note(preset: string): HTMLElement {
    return this.#fields.preset.node.querySelector(`[value="${preset}"] + span small`) as HTMLElement;
  }

  async #send(): Promise<void> {
    for (const field of Object.values(this.#fields)) field.fault("");
    this.shell.problem(null);
    const capture = chosenIn(this.#capture.node);
    if (capture === "") return this.#refuse("capture", "Choose a capture.");
    this.#submit.disabled = true;
    const { heldOut } = this.#cameras;
    try {
      const job = await submitJob(
        {
          capture,
          title: this.#title.value.trim(),
          preset: chosenIn(this.#fields.preset.node),
          ...(heldOut.length > 0 ? { hold_out: heldOut } : {}),
          ...(this.#check.trusted ? { config: { "capture.trust_poses": true } } : {}),
        },
        () => this.#submit.replaceChildren("Checking the capture …"),
      );
      location.assign(siteUrl(`job/${encodeURIComponent(job.id)}`));
    } catch (error) {
      this.#submit.disabled = false;
      this.#submit.replaceChildren("Start");
      const field = error instanceof ApiError ? fieldOf(error) : null;
      if (field === null || !(error instanceof ApiError)) this.shell.problem(error);
      else this.#refuse(field, reasonOf(error));
    }
  }

  #refuse(name: Field, reason: string): void {
    if (name === "hold_out" || name === "title") this.#more.open = true;
    if (name === "hold_out") this.#cameras.node.open = true;
    this.#fields[name].fault(reason);
    this.#fields[name].focus();
  }
}

const counted = (count: number, noun: string): string =>
  `${count.toLocaleString("en")} ${noun}${count === 1 ? "" : "s"}`;

/** "about 20 minutes here · at most 1.4 MB"; "" for an unknown price. */
export function priceWords(price: TrainingPrice | undefined): string {
  if (!price) return "";
  const minutes = Math.max(1, Math.round(price.minutes));
  const time = minutes < HOURS_FROM ? counted(minutes, "minute") : counted(Math.round(minutes / 60), "hour");
  return `about ${time} here · at most ${formatBytes(price.bytes)}`;
}

/** "16 cameras · 60 frames · 2.0 s", "49 photographs of a still scene". */
export function describeCapture({ cameras, frames, seconds }: Capture): string {
  if (frames === 1) return `${counted(cameras.length, "photograph")} of a still scene`;
  const parts = [counted(cameras.length, "camera")];
  if (frames !== null) parts.push(counted(frames, "frame"));
  if (seconds !== null) parts.push(formatDuration(seconds));
  return parts.join(" · ");
}
