/** Style sheets of players, each made once for all of a page; they hold inside the players' shadow roots only. */

const sheets = new Map<string, CSSStyleSheet>();

export function adoptStyle(shadow: ShadowRoot, css: string): void {
  const sheet = sheets.get(css) ?? new CSSStyleSheet();
  if (!sheets.has(css)) {
    sheet.replaceSync(css);
    sheets.set(css, sheet);
  }
  if (!shadow.adoptedStyleSheets.includes(sheet)) shadow.adoptedStyleSheets.push(sheet);
}
