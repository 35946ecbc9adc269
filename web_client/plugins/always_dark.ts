/** index.html as a page that is dark whatever the reader's system asks for, as the player is. */
export function alwaysDark(html: string): string {
  const dark = html
    .replace(' data-page="console"', "")
    .replace('content="light dark"', 'content="dark"')
    .replaceAll(/ *<meta name="theme-color" media="\(prefers-color-scheme: light\)"[^>]*>\n/g, "")
    .replace(' media="(prefers-color-scheme: dark)"', "");
  if (/console|light/.test(dark.replaceAll(/<script.*|<link.*/g, "")))
    throw new Error("index.html has changed: see plugins/always_dark.ts");
  return dark;
}
