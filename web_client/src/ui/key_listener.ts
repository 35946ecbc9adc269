/** Which keys pressed on a page are a player's. */

/** Hear keys on `target` until `signal` aborts, unless `ignores` says that one is for somebody else. */
export function listenForKeys(
  target: EventTarget,
  heard: (event: KeyboardEvent) => void,
  ignores: (event: KeyboardEvent, control: EventTarget) => boolean,
  signal: AbortSignal,
): void {
  const listen = (event: KeyboardEvent): void => {
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    // The element that it is for may be inside a shadow root.
    if (!ignores(event, event.composedPath()[0])) heard(event);
  };
  target.addEventListener("keydown", (event) => listen(event as KeyboardEvent), { signal });
}

/** Whether a key can be a player's, as far as that is known without its table: a sign, or one that moves through a page. */
export const mayBeObeyed = ({ key }: KeyboardEvent): boolean => key.length === 1 || /^(Arrow|Page|Home|End)/.test(key);
