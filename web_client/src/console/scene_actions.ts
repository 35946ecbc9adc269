/** The actions on a scene: copy its link, rename it, delete it. */

import { element, icon } from "../dom/element";
import { MORE } from "../dom/icons";
import { deleteScene, getSession, makeLink, renameScene, type Scene } from "../protocol/api";
import { siteUrl } from "../protocol/http";
import { ask } from "./dialog";
import { nameOf } from "./scene_order";

const LONGEST_TITLE = 200; // characters, as in docs/rest.md

export interface SceneEvents {
  /** The scenes have changed on the server. */
  changed(): void;
  notify(text: string): void;
}

/** A button that opens the actions of a scene. */
export function sceneActions(scene: Scene, events: SceneEvents): HTMLElement {
  const name = nameOf(scene);
  const item = (text: string, run: () => void): HTMLElement =>
    element("button", { type: "button", class: "menu-item", onclick: () => close(run) }, text);
  const menu = element(
    "div",
    { class: "menu", id: `actions-${scene.id}`, hidden: true },
    item("Copy link", () => void share(scene, events)),
    item("Rename …", () => void rename(scene, events)),
    item("Delete …", () => void remove(scene, events)),
  );
  const more = element(
    "button",
    {
      type: "button",
      class: "more",
      "aria-label": `More about ${name}`,
      "aria-expanded": "false",
      "aria-controls": menu.id,
    },
    icon(MORE),
  );
  const node = element("div", { class: "card-actions" }, more, menu);

  function show(open: boolean): void {
    menu.hidden = !open;
    more.setAttribute("aria-expanded", String(open));
  }

  function close(run: () => void): void {
    show(false);
    more.focus();
    run();
  }

  more.addEventListener("click", () => {
    show(Boolean(menu.hidden));
    if (!menu.hidden) menu.querySelector("button")?.focus();
  });
  node.addEventListener("focusout", (event) => {
    if (!(event.relatedTarget instanceof Node && node.contains(event.relatedTarget))) show(false);
  });
  node.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !menu.hidden) close(() => {});
  });
  return node;
}

const LINK_SECONDS = 7 * 24 * 3600;

/**
 * The address of a scene for others: if keys are required, and this one may, a link without one that ends in a week.
 */
async function addressOf({ id }: Scene): Promise<string> {
  const page = siteUrl(`view/${encodeURIComponent(id)}`);
  try {
    if (!(await getSession(AbortSignal.timeout(5000))).needed) return page;
    return `${page}?link=${encodeURIComponent(await makeLink(id, LINK_SECONDS))}`;
  } catch {
    return page;
  }
}

/** Copy the scene's address; if the browser does not allow it, show it for copying. */
async function share(scene: Scene, events: SceneEvents): Promise<void> {
  const address = new URL(await addressOf(scene), location.href).href;
  try {
    await navigator.clipboard.writeText(address); // missing on pages that are neither https nor localhost
    events.notify("Link copied");
  } catch {
    const field = element("input", { class: "input", value: address, readonly: true, "aria-label": "Link" });
    field.addEventListener("focus", () => field.select());
    const body = [element("p", { class: "hint" }, "Anyone who can reach this server can watch it there."), field];
    await ask({ title: `Link to ${nameOf(scene)}`, body, action: "Done", dismiss: "Close", run: async () => {} });
  }
}

async function rename(scene: Scene, events: SceneEvents): Promise<void> {
  const field = element("input", {
    class: "input",
    value: nameOf(scene),
    maxlength: LONGEST_TITLE,
    required: true,
    autocomplete: "off",
    autofocus: true,
  });
  field.addEventListener("focus", () => field.select());
  const done = await ask({
    title: "Rename the scene",
    body: [element("label", { class: "field" }, element("span", {}, "Name"), field)],
    action: "Rename",
    run: () => renameScene(scene.id, field.value),
  });
  if (!done) return;
  events.notify("Renamed");
  events.changed();
}

async function remove(scene: Scene, events: SceneEvents): Promise<void> {
  const done = await ask({
    title: `Delete ${nameOf(scene)}?`,
    body: [
      element("p", {}, "It disappears for everybody, and its link stops working."),
      element("p", { class: "hint" }, "The files it was made from stay on the server."),
    ],
    action: "Delete",
    danger: true,
    run: () => deleteScene(scene.id),
  });
  if (!done) return;
  events.notify("Deleted");
  events.changed();
}
