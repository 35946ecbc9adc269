/** A job's config as a table. */

import { element } from "../ui/element";
import { configRows } from "./config_rows";
import { spelledOut } from "./job_words";

export function configTable(config: Readonly<Record<string, unknown>>): HTMLElement {
  const bodies = new Map<string, HTMLElement>();
  for (const { group, name, value } of configRows(config)) {
    const heading = group.map(spelledOut).join(" · ");
    let body = bodies.get(heading);
    if (!body) {
      const title = element("th", { colspan: 2, scope: "rowgroup" }, heading);
      body = element("tbody", {}, heading === "" ? null : element("tr", { class: "group" }, title));
      bodies.set(heading, body);
    }
    body.append(element("tr", {}, element("th", { scope: "row" }, spelledOut(name)), element("td", {}, value)));
  }
  const table = element("table", { class: "config" }, ...bodies.values());
  return element(
    "details",
    { class: "panel" },
    element("summary", {}, "Settings"),
    element("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Settings" }, table),
  );
}
