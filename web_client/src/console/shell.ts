/** The common parts of all console pages: the masthead, a line for errors, and short messages. */

import { element, setText } from "../dom/element";
import { ApiError } from "../protocol/api";
import { siteUrl } from "../protocol/http";
import "./console.css";

const MESSAGE_SECONDS = 4;

export interface Shell {
  readonly main: HTMLElement;
  readonly masthead: HTMLElement;
  /** Show an error above the page; null or "" removes it. */
  problem(error: unknown): void;
  /** Show a message that needs no answer. */
  notify(text: string): void;
}

/** Create the page; `actions` are at the end of the masthead. */
export function showShell(root: HTMLElement, name: string, ...actions: HTMLElement[]): Shell {
  const alert = element("p", { class: "alert", role: "alert", hidden: true });
  const message = element("p", { class: "message", role: "status", hidden: true });
  const main = element("main", { id: "main" }, alert);
  const masthead = element(
    "header",
    { class: "masthead" },
    element(
      "a",
      { class: "home", href: siteUrl("") },
      element("img", { src: siteUrl("icon.svg"), alt: "", width: 36, height: 36 }),
      element("span", {}, element("strong", {}, "HGS"), element("small", {}, "Moving scenes, streamed")),
    ),
    ...actions,
  );
  root.className = `console ${name}`;
  root.replaceChildren(element("a", { class: "skip", href: "#main" }, "Skip to content"), masthead, main, message);
  let timer: ReturnType<typeof setTimeout> | undefined;
  return {
    main,
    masthead,
    problem(error) {
      const text = error instanceof Error ? error.message : String(error ?? "");
      alert.hidden = text === "";
      setText(alert, text);
    },
    notify(text) {
      clearTimeout(timer);
      message.hidden = false;
      setText(message, text);
      timer = setTimeout(() => {
        message.hidden = true;
        setText(message, "");
      }, 1000 * MESSAGE_SECONDS);
    },
  };
}

/** Whether the server reported that it does not exist. */
export const isMissing = (error: unknown): boolean => error instanceof ApiError && error.status === 404;

/** A placeholder for an empty list: its subject, and the next steps. */
export function emptyState(title: string, ...what: (Node | string)[]): HTMLElement {
  return element("div", { class: "empty" }, element("h2", {}, title), ...what);
}

/** Set the nodes of a list; those that keep their place keep their focus. */
export function showNodes(list: HTMLElement, nodes: readonly HTMLElement[]): void {
  const same = nodes.length === list.children.length && nodes.every((node, i) => node === list.children[i]);
  if (same) return;
  const focused = document.activeElement;
  list.replaceChildren(...nodes); // moving nodes drops the focus
  if (focused instanceof HTMLElement && list.contains(focused)) focused.focus({ preventScroll: true });
}
