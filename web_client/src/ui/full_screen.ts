/** Full screen for a player. */

/**
 * Enter full screen with `host`, or leave it.
 *
 * @throws Error with one line for people about the browser's refusal.
 */
export async function toggleFullscreen(host: HTMLElement): Promise<void> {
  const root = host.getRootNode() as Document | ShadowRoot;
  if (root.fullscreenElement === host) {
    await document.exitFullscreen();
    return;
  }
  if (!document.fullscreenEnabled) {
    const framed = window.parent !== window;
    throw new Error(
      framed
        ? 'The page around this frame does not let it fill the screen: its <iframe> needs allow="fullscreen".'
        : "This browser does not support full screen.",
    );
  }
  try {
    await host.requestFullscreen();
  } catch {
    throw new Error("The browser refused full screen. It allows it only right after a click or a key press.");
  }
}
