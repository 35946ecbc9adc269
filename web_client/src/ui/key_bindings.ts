/** Keys and what they do: one table that the player obeys and its help shows. */

export interface KeyBinding {
  /** As `keyName` calls them. */
  readonly keys: readonly string[];
  /** How the help writes them, where it is not as they are called. */
  readonly shown?: string;
  /** What they do, for people. */
  readonly does: string;
  /** @param key the one of `keys` that was pressed. */
  readonly action: (key: string) => void;
}

export interface KeyGroup {
  readonly name: string;
  readonly bindings: readonly KeyBinding[];
}

/** "k", "Shift+l", "Shift+ArrowLeft", "?": with Shift only where it does not already make another sign. */
export function keyName({ key, shiftKey }: KeyboardEvent): string {
  if (/^\p{L}$/u.test(key)) return (shiftKey ? "Shift+" : "") + key.toLowerCase();
  return shiftKey && key.length > 1 ? `Shift+${key}` : key;
}

/** A function that obeys a key that the table has, in place of what the browser would do. */
export function obey(groups: readonly KeyGroup[]): (event: KeyboardEvent) => void {
  const actions = new Map<string, KeyBinding>();
  for (const { bindings } of groups) {
    for (const binding of bindings) for (const key of binding.keys) actions.set(key, binding);
  }
  return (event) => {
    const name = keyName(event);
    const binding = actions.get(name);
    if (!binding) return;
    event.preventDefault();
    binding.action(name);
  };
}
