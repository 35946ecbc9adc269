/**
 * The page that asks for a key, in place of any page that requires one: it is entered once, and the browser keeps a
 * session that scripts cannot read.
 */

import { element, setText } from "../dom/element";
import { beginSession } from "../protocol/api";
import { siteUrl } from "../protocol/http";
import "./key_page.css";

/** Replace the page; once a key was entered, the page is loaded again. */
export function showKeyPage(root: HTMLElement): void {
  document.title = "Key needed · HGS";
  const link = new URLSearchParams(location.search).has("link");
  const field = element("input", {
    class: "key-input",
    type: "password",
    name: "key",
    required: true,
    autocomplete: "current-password",
    autofocus: true,
    spellcheck: "false",
    placeholder: "hgs_…",
  });
  const error = element("p", { class: "key-error", role: "alert" });
  const button = element("button", { class: "button primary" }, "Open");
  const form = element(
    "form",
    { class: "key-card" },
    element("img", { src: siteUrl("icon.svg"), alt: "", width: 52, height: 52 }),
    element("h1", {}, link ? "This link has expired" : "This server requires a key"),
    element(
      "p",
      { class: "hint" },
      link ? "Ask for a new one, or enter a key." : "Ask the person who runs it for one.",
    ),
    element("label", { class: "key-field" }, element("span", {}, "Key"), field),
    error,
    button,
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    button.disabled = true;
    setText(error, "");
    beginSession(field.value).then(
      () => {
        const address = new URL(location.href);
        address.searchParams.delete("link"); // the link would take precedence, and be refused
        location.replace(address);
      },
      (reason: Error) => {
        button.disabled = false;
        setText(error, reason.message);
        field.select();
      },
    );
  });
  root.className = "key-page";
  root.replaceChildren(element("main", {}, form));
  field.focus();
}
