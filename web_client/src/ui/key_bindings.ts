import type { HgsPlayer } from "../player/hgs_player";
import { longSeekStep, type PlayerActions, rateAfter, seekStep } from "./player_actions";
import { stepFrames, togglePlaying } from "./playing";
import { steering } from "./steering";
/** Key bindings: one table for the player and its help. */

export interface KeyBinding {
  /** Names as by `keyName`. */
  readonly keys: readonly string[];
  /** The help's display of the keys, if it differs from their names. */
  readonly shown?: string;
  /** The effect, for people. */
  readonly does: string;
  /**
   * The command.
   *
   * @param key the pressed one of `keys`.
   */
  readonly action: (key: string) => void;
}

export interface KeyGroup {
  readonly name: string;
  readonly bindings: readonly KeyBinding[];
}

/** The name of a key: "k", "Shift+l", "Shift+ArrowLeft", "?"; with Shift only if it does not change the character. */
export function keyName({ key, shiftKey }: KeyboardEvent): string {
  if (/^\p{L}$/u.test(key)) return (shiftKey ? "Shift+" : "") + key.toLowerCase();
  return shiftKey && key.length > 1 ? `Shift+${key}` : key;
}

/** A function that executes the table's keys in place of the browser's own actions. */
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

const TURN = 0.06; // radians
const ZOOM = 1.1;

/** Targets of keys other than the actions. */
export interface KeySurroundings {
  toggleStatistics(): void;
  toggleFullscreen(): void;
  toggleHelp(): void;
}

export function playerKeys(player: HgsPlayer, actions: PlayerActions, view: KeySurroundings): readonly KeyGroup[] {
  const camera = steering(player.camera, actions.surroundings.fly);
  const turn = (yaw: number, pitch: number) => () => {
    camera.turn(yaw, pitch);
    camera.release();
  };
  const zoom = (factor: number) => () => {
    camera.zoom(factor);
    camera.release();
  };
  /** A still scene has no time to seek, so the arrows turn the camera. */
  const arrow = (direction: 1 | -1) => () =>
    actions.moves ? actions.seekBy(direction * seekStep(player.duration)) : turn(-direction * TURN, 0)();
  const playing = [
    { keys: [" ", "k"], shown: "Space, K", does: "Play or pause", action: () => togglePlaying(player) },
    { keys: ["ArrowLeft"], shown: "←", does: "Back 5 s, or a tenth of a short scene", action: arrow(-1) },
    { keys: ["ArrowRight"], shown: "→", does: "Forward 5 s, or a tenth of a short scene", action: arrow(1) },
    {
      keys: ["j"],
      does: "Back 10 s, or a fifth of a short scene",
      action: () => actions.seekBy(-longSeekStep(player.duration)),
    },
    {
      keys: ["l"],
      does: "Forward 10 s, or a fifth of a short scene",
      action: () => actions.seekBy(longSeekStep(player.duration)),
    },
    { keys: [","], does: "One frame back", action: () => stepFrames(player, -1) },
    { keys: ["."], does: "One frame forward", action: () => stepFrames(player, 1) },
    {
      keys: [..."0123456789"],
      shown: "0 … 9",
      does: "To that tenth of the scene",
      action: (key: string) => actions.jump(Number(key) / 10),
    },
    { keys: ["Home"], does: "To the start", action: () => actions.jump(0) },
    { keys: ["End"], does: "To the end", action: () => actions.jump(1) },
    {
      keys: ["<"],
      does: "Slower",
      action: () => {
        actions.rate = rateAfter(player.playbackRate, -1);
      },
    },
    {
      keys: [">"],
      does: "Faster",
      action: () => {
        actions.rate = rateAfter(player.playbackRate, 1);
      },
    },
    { keys: ["m"], does: "Mute or unmute", action: () => actions.toggleMuted() },
    { keys: ["Shift+l"], shown: "Shift + L", does: "Repeat on or off", action: () => actions.toggleLoop() },
  ];
  const marking = [
    { keys: ["i"], does: "Repeat from here", action: () => actions.setLoop("from") },
    { keys: ["o"], does: "Repeat until here", action: () => actions.setLoop("to") },
    { keys: ["x"], does: "Clear the repeated part", action: () => actions.clearLoop() },
    { keys: ["b"], does: "Set or remove a bookmark here", action: () => actions.toggleBookmark() },
    { keys: ["PageUp"], shown: "Page up", does: "To the previous bookmark", action: () => actions.goToBookmark(-1) },
    { keys: ["PageDown"], shown: "Page down", does: "To the next bookmark", action: () => actions.goToBookmark(1) },
  ];
  const moving = [
    { keys: ["Shift+ArrowLeft"], shown: "Shift + ←", does: "Turn to the left", action: turn(TURN, 0) },
    { keys: ["Shift+ArrowRight"], shown: "Shift + →", does: "Turn to the right", action: turn(-TURN, 0) },
    { keys: ["ArrowUp", "Shift+ArrowUp"], shown: "↑", does: "Turn upwards", action: turn(0, TURN) },
    { keys: ["ArrowDown", "Shift+ArrowDown"], shown: "↓", does: "Turn downwards", action: turn(0, -TURN) },
    { keys: ["+", "="], shown: "+", does: "Move closer", action: zoom(1 / ZOOM) },
    { keys: ["-"], does: "Move away", action: zoom(ZOOM) },
    { keys: ["r"], does: "Back to the camera", action: () => actions.resetCamera() },
    { keys: ["h"], does: "Hide or show all that stands still", action: () => actions.toggleSubjectOnly() },
    { keys: ["g"], does: "Fly, or turn around the scene", action: () => actions.toggleFly() },
  ];
  const rest = [
    { keys: ["f"], does: "Full screen", action: () => view.toggleFullscreen() },
    { keys: ["p"], does: "Save the picture", action: () => void actions.savePicture() },
    { keys: ["s"], does: "Statistics", action: () => view.toggleStatistics() },
    { keys: ["?"], does: "This help", action: () => view.toggleHelp() },
  ];
  if (actions.surroundings.link) {
    rest.splice(1, 0, { keys: ["c"], does: "Copy a link to this picture", action: () => void actions.copyLink() });
  }
  const { toggleCrop, togglePath, toggleClean } = actions.surroundings;
  if (togglePath) rest.splice(1, 0, { keys: ["n"], does: "Key frames of a camera path", action: togglePath });
  if (toggleClean) rest.splice(1, 0, { keys: ["e"], does: "Start or finish cleaning", action: toggleClean });
  if (toggleCrop) rest.splice(1, 0, { keys: ["v"], does: "Start or finish cropping", action: toggleCrop });
  return [
    { name: "Playing", bindings: playing },
    { name: "Repeating and bookmarks", bindings: marking },
    { name: "Camera", bindings: moving },
    { name: "Player", bindings: rest },
  ];
}
