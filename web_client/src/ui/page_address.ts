/** Which page an address names. */

export type PageAddress =
  | { readonly kind: "list" }
  | { readonly kind: "view"; readonly scene: string }
  | { readonly kind: "unknown" };

/** The page at a path, such as `/view/studio`. */
export function pageAt(path: string): PageAddress {
  if (path === "/" || path === "/index.html") return { kind: "list" };
  const scene = /^\/view\/([A-Za-z0-9_-][A-Za-z0-9._-]{0,63})\/?$/.exec(path);
  return scene ? { kind: "view", scene: scene[1] } : { kind: "unknown" };
}
