/** The page of an address at which there is nothing. */

import { siteUrl } from "../protocol/site";
import { element } from "./element";

export function showNotFoundPage(root: HTMLElement): void {
  document.title = "Not found · HGS";
  root.className = "not-found-page";
  root.replaceChildren(
    element(
      "main",
      {},
      element("img", { src: siteUrl("icon.svg"), alt: "", width: 56, height: 56 }),
      element("h1", {}, "There is nothing at this address"),
      element("p", { class: "hint" }, "The link may be mistyped, or the scene may have gone."),
      element("a", { class: "button", href: siteUrl("") }, "All scenes"),
    ),
  );
}
