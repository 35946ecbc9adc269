/** What the server refuses of a form, at the field that it concerns. */

import type { ApiError } from "../protocol/api";

/** The fields of the form, by the names that docs/rest.md gives them. */
export type Field = "capture" | "title" | "preset" | "hold_out";

const FIELDS: readonly Field[] = ["capture", "title", "preset", "hold_out"];

/** The form's field that an error is about, such as `hold_out` for `hold_out.3`; null where it has none for it. */
export function fieldOf(error: Pick<ApiError, "code" | "field">): Field | null {
  const name = error.field.split(".")[0];
  const found = FIELDS.find((field) => field === name);
  if (found) return found;
  return error.code === "capture-invalid" || error.code === "capture-outside" ? "capture" : null;
}

/** The server's line without what it begins with: beside the field, neither the status nor the name is needed. */
export function reasonOf(error: Pick<ApiError, "message" | "field">): string {
  const detail = error.message.replace(/^The server answered \d+: /, "");
  const prefix = `${error.field}: `;
  const reason = error.field !== "" && detail.startsWith(prefix) ? detail.slice(prefix.length) : detail;
  return reason.replace(/^[a-z](?=[a-z]* )/, (letter) => letter.toUpperCase()); // but no file's name
}
