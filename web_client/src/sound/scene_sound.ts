/**
 * The sound of a scene in step with its picture, by Web Audio. It follows the picture, which never waits for it.
 * Nothing is fetched while it is muted, and nothing sounds before the visitor has touched the page: browsers do not
 * allow it.
 */

import { type AudioEntry, readAudio, type SoundPiece } from "../codec/audio_entry";
import type { Manifest } from "../codec/types";
import type { StreamedScene } from "../scene/streamed_scene";
import { newContext, outputTime, toSample } from "./device";
import { stretched } from "./stretch";
import { Alignment, type Line, partToHear, pieceAt } from "./timing";

/** Seconds of playing for which pieces are fetched, and for which they are scheduled. */
const AHEAD = 3;
const SOON = 0.6;
/** Highest rate with sound: beyond it, nothing could be understood. */
const FASTEST = 4;
/** Number of decoded pieces in memory, about 0.4 MB each. */
const KEPT = 24;
/** Fade at the beginning and end of sound, seconds, against clicks. */
const FADE = 0.01;
/** Time from a frame until its picture is visible, seconds: about the next refresh of the screen. */
const DISPLAY = 1 / 60;
/** Shortest notice for the device, seconds. */
const LATEST = 0.005;
/** Milliseconds without a start after which the browser is waiting for the visitor to touch the page. */
const PATIENCE = 1000;
/** Milliseconds of silence after which the device may rest. */
const REST = 500;
/** Milliseconds before a piece that could not be fetched is requested again. */
const RETRY = 3000;

/** The player of the sound: reports by events that a frame has passed or the loudness has changed; receives `error`. */
export interface SoundingPlayer extends Pick<EventTarget, "dispatchEvent"> {
  readonly manifest: Manifest | null;
  muted: boolean;
  /** From 0 to 1. */
  readonly volume: number;
  addEventListener(type: "frame" | "volumechange", listener: () => void, options: { signal: AbortSignal }): void;
}

/** Sounds scheduled by one line: they end together when the line changes. */
interface Run {
  readonly line: Line;
  /** The line moved by less than a sample, so that each piece begins at one, right after its predecessor. */
  readonly exact: Line;
  readonly fade: GainNode;
  /** Sources by the start of their pieces. */
  readonly pieces: Map<number, AudioBufferSourceNode>;
}

export class SceneSound {
  #audio: AudioEntry;
  #listed: unknown; // the manifest's entry as last read
  readonly #alignment = new Alignment();
  /** Decoded pieces by their start; null: being fetched, or not available now. */
  readonly #buffers = new Map<number, AudioBuffer | null>();
  #context: AudioContext | null = null;
  #volume: GainNode | null = null;
  #run: Run | null = null;
  #rest: ReturnType<typeof setTimeout> | undefined; // set while the device is to rest soon, or rests
  #waking: ReturnType<typeof setTimeout> | undefined; // set while the device is starting
  #deaf = false; // true once decoding has failed and the visitor has been notified

  /**
   * Play the sound of a scene.
   *
   * @param scene with a manifest; `gone` aborts when it is removed.
   * @throws ManifestError if the manifest's entry for sound is wrong.
   */
  constructor(
    readonly player: SoundingPlayer,
    readonly scene: Pick<StreamedScene, "playback" | "source">,
    readonly gone: AbortSignal,
  ) {
    this.#audio = this.#list();
    const listen = { signal: gone };
    player.addEventListener("frame", () => this.#update(), listen);
    player.addEventListener("volumechange", () => this.#update(), listen);
    document.addEventListener("visibilitychange", () => this.#update(), listen);
    gone.addEventListener("abort", () => this.#dispose());
    this.#update();
  }

  /** Follow the state of the player. */
  #update(): void {
    const { playback } = this.scene;
    const { muted, volume } = this.player;
    if (!playback || this.gone.aborted) return;
    this.#audio = this.#list();
    const { clock, moving } = playback;
    if (muted || !moving || document.hidden || clock.rate > FASTEST) {
      this.#hush();
      return;
    }
    const context = this.#wake();
    if (!context || !this.#volume) return;
    const loud = Math.min(1, Math.max(0, volume || 0)) ** 2; // perceived loudness
    this.#volume.gain.setTargetAtTime(loud, context.currentTime, FADE);
    const wanted = new Set<SoundPiece>();
    for (let ahead = 0; ahead <= AHEAD; ahead += 0.4 / clock.rate) {
      const piece = this.#audio.pieces[pieceAt(this.#audio.pieces, clock.after(ahead))];
      if (piece) wanted.add(piece);
    }
    this.#fetch(context, wanted);
    if (context.state !== "running" || clock.ticked === null) return;
    const { performanceTime: played, contextTime } = outputTime(context);
    const shown = clock.ticked + DISPLAY - played / 1000; // the picture's time relative to the sound's
    const line = this.#alignment.follow({ zero: contextTime + shown - clock.time / clock.rate, rate: clock.rate });
    const [first] = wanted;
    if (line !== this.#run?.line && first !== undefined) this.#begin(context, this.#volume, line, first);
    for (const piece of wanted) this.#schedule(context, piece);
  }

  /** The listed pieces; a growing manifest may have further ones. */
  #list(): AudioEntry {
    const { audio, room } = this.player.manifest ?? {};
    if (audio === this.#listed) return this.#audio;
    this.#listed = audio;
    return readAudio(audio, room !== undefined);
  }

  /** The device, running or starting; null while the browser does not allow it. */
  #wake(): AudioContext | null {
    clearTimeout(this.#rest);
    this.#rest = undefined;
    if (!this.#context) {
      if (navigator.userActivation?.hasBeenActive === false) {
        this.player.muted = true; // muted until the visitor requests sound
        return null;
      }
      const context = newContext(this.#audio.sampleRate);
      this.#volume = context.createGain();
      this.#volume.gain.value = 0; // silent until the first update of the loudness
      this.#volume.connect(context.destination);
      this.#context = context;
    }
    if (this.#context.state !== "running" && this.#waking === undefined) this.#resume(this.#context);
    return this.#context;
  }

  #resume(context: AudioContext): void {
    this.#waking = setTimeout(() => {
      this.#waking = undefined;
      const wanted = this.#rest === undefined && this.scene.playback?.moving;
      if (wanted && context.state !== "running" && !this.gone.aborted) this.player.muted = true;
    }, PATIENCE);
    const woken = () => {
      clearTimeout(this.#waking);
      this.#waking = undefined;
    };
    context.resume().then(woken, () => {});
  }

  /** Stop the sound; the device may rest soon. */
  #hush(): void {
    this.#end();
    this.#alignment.forget();
    if (this.#context?.state !== "running" || this.#rest !== undefined) return;
    this.#rest = setTimeout(() => void this.#context?.suspend().catch(() => {}), REST);
  }

  #begin(context: AudioContext, volume: GainNode, line: Line, first: SoundPiece): void {
    this.#end();
    const into = first.start / line.rate;
    const exact = { zero: toSample(line.zero + into, context) - into, rate: line.rate };
    const fade = context.createGain();
    fade.gain.setValueAtTime(0, context.currentTime);
    fade.gain.linearRampToValueAtTime(1, context.currentTime + FADE);
    fade.connect(volume);
    this.#run = { line, exact, fade, pieces: new Map() };
  }

  #end(): void {
    const [run, context] = [this.#run, this.#context];
    this.#run = null;
    if (!run || !context) return;
    const { currentTime } = context;
    run.fade.gain.cancelScheduledValues(currentTime);
    run.fade.gain.setValueAtTime(run.fade.gain.value, currentTime);
    run.fade.gain.linearRampToValueAtTime(0, currentTime + FADE);
    for (const node of run.pieces.values()) node.stop(currentTime + FADE);
  }

  /** Schedule a piece, if it is decoded, due soon, and not scheduled yet. */
  #schedule(context: AudioContext, piece: SoundPiece): void {
    const { start, end } = piece;
    const [run, buffer] = [this.#run, this.#buffers.get(start)];
    if (!run || !buffer || run.pieces.has(start)) return;
    const now = context.currentTime + LATEST;
    const { pieces } = this.#audio;
    const part = partToHear(pieces, pieces.indexOf(piece), run.exact, now);
    if (!part || part.when > now + SOON) return;
    const { rate } = run.line;
    const node = new AudioBufferSourceNode(context, { buffer: atRate(context, buffer, end - start, rate) });
    node.connect(run.fade);
    const from = Math.max(0, node.buffer!.duration - (end - part.from) / rate);
    node.start(toSample(part.when, context), toSample(from, context), (part.until - part.from) / rate);
    run.pieces.set(start, node);
  }

  /** Fetch and decode pieces, and drop those long past. */
  #fetch(context: AudioContext, wanted: ReadonlySet<SoundPiece>): void {
    const starts = new Set<number>();
    for (const piece of wanted) {
      starts.add(piece.start);
      if (this.#buffers.has(piece.start)) continue;
      this.#buffers.set(piece.start, null);
      void this.#bring(context, piece);
    }
    for (const start of this.#buffers.keys()) {
      if (this.#buffers.size <= KEPT) break;
      if (!starts.has(start)) this.#buffers.delete(start);
    }
  }

  async #bring(context: AudioContext, { id, start }: SoundPiece): Promise<void> {
    let bytes: Uint8Array;
    try {
      bytes = await this.scene.source.fetchAgain(id, this.gone, "default");
    } catch (error) {
      if (this.gone.aborted) return;
      // biome-ignore lint/suspicious/noConsole: the scene continues, without sound for a second
      console.warn(`sound ${id}: ${error instanceof Error ? error.message : error}`);
      setTimeout(() => this.#buffers.delete(start), RETRY);
      return;
    }
    try {
      const buffer = await context.decodeAudioData(bytes.slice().buffer as ArrayBuffer);
      if (this.#buffers.has(start)) this.#buffers.set(start, buffer);
      this.#update();
    } catch (error) {
      if (!this.gone.aborted && !this.#deaf) this.#complain(`${this.#audio.codec}, ${id}: ${error}`);
      this.#deaf = true;
    }
  }

  #complain(cause: string): void {
    const message = "This browser cannot play the scene's sound.";
    this.player.dispatchEvent(new CustomEvent("error", { detail: { message, cause } }));
  }

  #dispose(): void {
    clearTimeout(this.#rest);
    clearTimeout(this.#waking);
    this.#end();
    const context = this.#context;
    this.#context = null;
    setTimeout(() => void context?.close().catch(() => {}), 100); // end of the fade
  }
}

/**
 * A piece of `seconds` at a rate, with its own pitch. The decoded sound ends with the piece; before it there is the
 * decoder's lead-in.
 */
function atRate(context: AudioContext, decoded: AudioBuffer, seconds: number, rate: number): AudioBuffer {
  if (rate === 1) return decoded;
  const channels = Array.from({ length: Math.min(2, decoded.numberOfChannels) }, (_, i) => decoded.getChannelData(i));
  const begin = Math.max(0, decoded.length - Math.round(seconds * decoded.sampleRate));
  const made = stretched(channels, begin, rate, decoded.sampleRate);
  const buffer = context.createBuffer(made.length, Math.max(1, made[0].length), decoded.sampleRate);
  for (const [i, samples] of made.entries()) buffer.copyToChannel(samples, i);
  return buffer;
}
