/** The style sheet of all players of a page, made once; it holds inside their shadow roots only. */

import css from "./player.css?inline";

let sheet: CSSStyleSheet | null = null;

export function adoptPlayerStyle(shadow: ShadowRoot): void {
  if (!sheet) {
    sheet = new CSSStyleSheet();
    sheet.replaceSync(css);
  }
  shadow.adoptedStyleSheets = [sheet];
}
