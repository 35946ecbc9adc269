/** The address of a scene's stream on the server that the page came from. */
export function streamUrl(scene: string, page: { protocol: string; host: string } = location): string {
  const scheme = page.protocol === "https:" ? "wss:" : "ws:";
  return `${scheme}//${page.host}/v1/scenes/${encodeURIComponent(scene)}/stream`;
}
