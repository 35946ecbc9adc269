/** Which page an address names. */

export type PageAddress =
  | { readonly kind: "list" }
  | { readonly kind: "view"; readonly scene: string }
  | { readonly kind: "unknown" };

/** The page at a path, such as `/view/studio`; scene ids are those of docs/protocol.md. */
export function pageAt(path: string): PageAddress {
  if (path === "/" || path === "/index.html") return { kind: "list" };
  const scene = /^\/view\/([a-z0-9][a-z0-9_-]{0,63})\/?$/.exec(path);
  return scene ? { kind: "view", scene: scene[1] } : { kind: "unknown" };
}
