/** The scenes of the list: cards, and for more than a few, a search and an order. */

import { element, setText } from "../dom/element";
import type { Scene } from "../protocol/api";
import { siteUrl } from "../protocol/http";
import { newSceneOf } from "./page_address";
import type { SceneEvents } from "./scene_actions";
import { SceneCards } from "./scene_cards";
import { arrange, isOrder, ORDERS } from "./scene_order";
import { emptyState } from "./shell";

const FEW = 6; // scenes at a glance

export class SceneSection {
  readonly node: HTMLElement;
  readonly #cards: SceneCards;
  readonly #search = element("input", {
    class: "input",
    type: "search",
    placeholder: "Search",
    "aria-label": "Search",
  });
  readonly #order = element("select", { class: "input", "aria-label": "Order" });
  readonly #tools = element("div", { class: "tools", role: "search", hidden: true }, this.#search, this.#order);
  readonly #none: HTMLElement;
  readonly #nothingFound = element("p", { class: "hint", role: "status" });
  readonly #sending = element("div", {});
  #scenes: readonly Scene[] = [];

  constructor(events: SceneEvents) {
    const list = element("ul", { class: "cards" });
    this.#cards = new SceneCards(list, events);
    for (const [order, words] of Object.entries(ORDERS)) this.#order.append(element("option", { value: order }, words));
    this.#none = emptyState(
      "No scenes yet",
      element(
        "p",
        { class: "hint" },
        "Turn videos of one moment, filmed from several sides, into a scene you can walk around in.",
      ),
      this.#sending,
      element("a", { href: siteUrl("new") }, "Or choose a capture of the server"),
    );
    this.#none.hidden = true;
    this.node = element(
      "section",
      { "aria-labelledby": "scenes" },
      element("div", { class: "section-head" }, element("h2", { id: "scenes" }, "Scenes"), this.#tools),
      list,
      this.#nothingFound,
      this.#none,
    );
    this.#search.addEventListener("input", () => this.#arrange());
    this.#order.addEventListener("change", () => this.#arrange());
  }

  show(scenes: readonly Scene[]): void {
    this.#scenes = scenes;
    this.#none.hidden = scenes.length > 0;
    if (scenes.length === 0) void this.#offerSending();
    this.#tools.hidden = scenes.length <= FEW && this.#search.value === "";
    this.#arrange();
  }

  /** Put the panel that takes a folder in its place, once. */
  async #offerSending(): Promise<void> {
    const { UploadPanel } = await import("./upload_panel");
    if (this.#sending.isConnected)
      this.#sending.replaceWith(new UploadPanel((path) => location.assign(siteUrl(newSceneOf(path)))).node);
  }

  #arrange(): void {
    const order = this.#order.value;
    const found = arrange(this.#scenes, this.#search.value, isOrder(order) ? order : "newest");
    this.#cards.show(found);
    setText(this.#nothingFound, this.#scenes.length > 0 && found.length === 0 ? "No scene of that name." : "");
  }
}
