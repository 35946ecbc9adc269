/** The listener for a player's keys on a page. */

/** Listen for keys on `target` until `signal` aborts, except those that `ignores` leaves to other elements. */
export function listenForKeys(
  target: EventTarget,
  pressed: (event: KeyboardEvent) => void,
  ignores: (event: KeyboardEvent, control: EventTarget) => boolean,
  signal: AbortSignal,
): void {
  const listen = (event: KeyboardEvent): void => {
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    // The target of the key may be inside a shadow root.
    if (!ignores(event, event.composedPath()[0])) pressed(event);
  };
  target.addEventListener("keydown", (event) => listen(event as KeyboardEvent), { signal });
}

/**
 * Whether a key may be in the player's table, before that is loaded: a character, or a key that moves through a page.
 */
export const mayBeObeyed = ({ key }: KeyboardEvent): boolean => key.length === 1 || /^(Arrow|Page|Home|End)/.test(key);
