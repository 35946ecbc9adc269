/** Names of capture cameras for people: captures name them by their files. */

/**
 * The names to show, in the same order: "cam00" as "Camera 0", "frame_00012.jpg" as "Frame 12", "left-side" as "Left side".
 * Two that would look the same keep the names they have.
 */
export function readableCameraNames(names: readonly string[]): readonly string[] {
  const readable = names.map(readableName);
  return names.map((name, i) => (readable.filter((other) => other === readable[i]).length > 1 ? name : readable[i]));
}

function readableName(name: string): string {
  const words = name
    .replace(/\.(?:jpe?g|png|webp|tiff?|exr|mp4|mov)$/i, "")
    .replace(/[_\s-]+/g, " ")
    .replace(/(\p{L})(\d)/gu, "$1 $2")
    .replace(/\b0+(?=\d)/g, "")
    .replace(/^cam(?=\s|$)/i, "camera")
    .trim();
  return words === "" ? name : words[0].toUpperCase() + words.slice(1);
}
