/** Style sheets of players, one object each per document. They apply inside the players' shadow roots only. */

const sheets = new WeakMap<Document, Map<string, CSSStyleSheet>>();
const worn = new WeakMap<ShadowRoot, Set<string>>();

export function adoptStyle(shadow: ShadowRoot, css: string): void {
  worn.set(shadow, (worn.get(shadow) ?? new Set()).add(css));
  const { ownerDocument } = shadow;
  const page = ownerDocument.defaultView;
  if (!page) return; // a document without a window
  const made = sheets.get(ownerDocument) ?? new Map<string, CSSStyleSheet>();
  sheets.set(ownerDocument, made);
  const sheet = made.get(css) ?? new page.CSSStyleSheet();
  if (!made.has(css)) sheet.replaceSync(css);
  made.set(css, sheet);
  if (!shadow.adoptedStyleSheets.includes(sheet)) shadow.adoptedStyleSheets.push(sheet);
}

/** Adopt the styles of a shadow root again, after a move to another document. */
export function adoptStylesAgain(shadow: ShadowRoot): void {
  for (const css of worn.get(shadow) ?? []) adoptStyle(shadow, css);
}
