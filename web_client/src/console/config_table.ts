/** A job's config as a table. */

import { element } from "../dom/element";
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

export interface ConfigRow {
  /** The names of the groups around it, such as ["learning_rates"]; empty at the top. */
  readonly group: readonly string[];
  readonly name: string;
  readonly value: string;
}

const DEEPEST = 6;

/** The rows in the config's order, grouped, with the fields of the top first. */
export function configRows(config: Readonly<Record<string, unknown>>): ConfigRow[] {
  return rowsOf(config, []);
}

function rowsOf(config: Readonly<Record<string, unknown>>, group: readonly string[]): ConfigRow[] {
  const plain: ConfigRow[] = [];
  const nested: ConfigRow[] = [];
  for (const [name, value] of Object.entries(config)) {
    if (isGroup(value) && group.length < DEEPEST) nested.push(...rowsOf(value, [...group, name]));
    else plain.push({ group, name, value: words(value) });
  }
  return [...plain, ...nested];
}

const isGroup = (value: unknown): value is Record<string, unknown> =>
  typeof value === "object" && value !== null && !Array.isArray(value) && Object.keys(value).length > 0;

function words(value: unknown): string {
  if (Array.isArray(value)) return value.length === 0 ? "none" : value.map(words).join(", ");
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (typeof value === "number")
    return Number.isInteger(value) ? value.toLocaleString("en") : String(Number(value.toPrecision(6)));
  if (typeof value === "string") return value === "" ? "none" : value;
  if (value === null || value === undefined) return "none";
  return JSON.stringify(value);
}
