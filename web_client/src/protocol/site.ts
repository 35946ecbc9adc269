/** Where the server's pages and its API are: at the root of their host, or below a path that a proxy has put them under. */

let root = "/";

/** @param path of the server's root, with a slash at its end, as browsers write it: `/`, `/hgs/`, `/my%20scenes/hgs/`. */
export function beginSiteAt(path: string): void {
  root = path;
}

/** The address of what is at `path` below the server's root, such as `v1/scenes`. */
export const siteUrl = (path: string): string => root + path;

/** The part of a page's address below the server's root, with a slash before it; all of it if it is not below. */
export const pathInSite = (path: string): string => (path.startsWith(root) ? path.slice(root.length - 1) : path);
