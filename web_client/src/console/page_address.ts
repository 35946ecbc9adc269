/** The addresses of the pages. */

export type PageAddress =
  | { readonly kind: "list" }
  | { readonly kind: "new" }
  | { readonly kind: "job"; readonly job: string }
  | { readonly kind: "view"; readonly scene: string }
  | { readonly kind: "unknown" };

/** The page at a path, such as `/view/studio`. */
export function pageAt(path: string): PageAddress {
  if (path === "/" || path === "/index.html") return { kind: "list" };
  if (path === "/new" || path === "/new/") return { kind: "new" };
  const [, kind, name] = /^\/(view|job)\/([A-Za-z0-9_-][A-Za-z0-9._-]{0,63})\/?$/.exec(path) ?? [];
  if (kind === "view") return { kind, scene: name };
  return kind === "job" ? { kind, job: name } : { kind: "unknown" };
}

/** The path and query of the form for a new scene, with a capture chosen. */
export const newSceneOf = (capture: string): string => `new?capture=${encodeURIComponent(capture)}`;

/** The capture that is chosen in such a query; "" for none. */
export const captureOf = (query: string): string => new URLSearchParams(query).get("capture") ?? "";
