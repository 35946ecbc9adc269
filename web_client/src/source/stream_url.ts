/** The address of a scene's stream on a server. */
export function streamUrl(scene: string, server: { protocol: string; host: string }): string {
  const scheme = server.protocol === "https:" ? "wss:" : "ws:";
  return `${scheme}//${server.host}/v1/scenes/${encodeURIComponent(scene)}/stream`;
}
