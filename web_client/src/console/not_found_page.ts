/** The page for addresses, scenes and jobs that do not exist. */

import { element } from "../dom/element";

/**
 * Show the page.
 *
 * @param home address of the server's root, with a slash at its end.
 */
export function showNotFoundPage(
  root: HTMLElement,
  home: string,
  title = "There is nothing at this address",
  hint = "The link may be mistyped, or the scene may have been deleted.",
): void {
  document.title = "Not found · HGS";
  root.className = "not-found-page";
  root.replaceChildren(
    element(
      "main",
      {},
      element("img", { src: `${home}icon.svg`, alt: "", width: 56, height: 56 }),
      element("h1", {}, title),
      element("p", { class: "hint" }, hint),
      element("a", { class: "button", href: home }, "All scenes"),
    ),
  );
}
