/**
 * The transfer of a capture's files, in pieces; it continues after interruptions, pauses and closed pages
 * (docs/upload.md).
 */

import { ApiError } from "../protocol/http";
import type { Announcement, RemoteFile, Upload } from "../protocol/uploads";
import { type Chosen, type ChosenFile, uploadKey } from "./chosen_files";

const PIECE = 8 << 20; // bytes per request
const AT_ONCE = 3; // parallel files
const CHANGES = 3; // changes of an announced file before the transfer fails
const LONGEST_WAIT = 20; // seconds between two tries
const MAY_PASS = new Set([0, 408, 429, 502, 503, 504]); // statuses that may pass

/** The requests of docs/upload.md; protocol/uploads.ts implements them. */
export interface UploadRequests {
  /** All uploads on the server. */
  uploads(signal: AbortSignal): Promise<readonly Upload[]>;
  begin(announced: Announcement, signal: AbortSignal): Promise<{ upload: Upload; resumed: boolean }>;
  files(id: string, signal: AbortSignal): Promise<readonly RemoteFile[]>;
  announce(
    id: string,
    file: { readonly path: string; readonly size: number; readonly sha256: string },
    signal: AbortSignal,
  ): Promise<{ location: string; offset: number }>;
  offset(location: string, signal: AbortSignal): Promise<number>;
  send(
    location: string,
    offset: number,
    piece: Blob,
    onBytes: (bytes: number) => void,
    signal: AbortSignal,
  ): Promise<number>;
  finish(id: string, signal: AbortSignal): Promise<Upload>;
  /** Wait for some seconds. */
  wait(seconds: number, signal: AbortSignal): Promise<void>;
}

export type FileState = "waiting" | "reading" | "sending" | "there";
export type TransferState = "sending" | "paused" | "waiting" | "finishing" | "done" | "failed";

export interface SentFile {
  readonly path: string;
  readonly size: number;
  /** Bytes on the server, or on their way. */
  sent: number;
  state: FileState;
}

export class Transfer {
  readonly files: readonly SentFile[];
  readonly total: number;
  state: TransferState = "paused";
  /** The reason for waiting or failure; "" otherwise. */
  problem = "";
  upload: Upload | null = null;
  readonly #hashes = new Map<SentFile, string>();
  #running: AbortController | null = null;

  /**
   * Prepare a transfer.
   *
   * @param hash the SHA-256 of a file; rejects if it cannot be read
   * @param onChange is called after every change, often
   */
  constructor(
    readonly chosen: Chosen,
    readonly requests: UploadRequests,
    readonly hash: (file: File) => Promise<string>,
    readonly onChange: () => void,
  ) {
    this.files = chosen.files.map(({ path, file }) => ({ path, size: file.size, sent: 0, state: "waiting" }));
    this.total = this.files.reduce((sum, { size }) => sum + size, 0);
  }

  /** Whether nothing is sent yet because files are being hashed. */
  get reading(): boolean {
    return this.files.some(({ state }) => state === "reading") && !this.files.some(({ state }) => state === "sending");
  }

  get sent(): number {
    return this.files.reduce((sum, { sent }) => sum + sent, 0);
  }

  /** Send everything that the server lacks; also continues after a pause or a failure. */
  async run(): Promise<void> {
    if (this.#running) return;
    const running = new AbortController();
    this.#running = running;
    this.#set("sending");
    try {
      await this.#send(running.signal);
      this.#set("done");
    } catch (error) {
      if (!running.signal.aborted) this.#set("failed", error instanceof Error ? error.message : String(error));
      running.abort(); // stops the other files
    } finally {
      if (this.#running === running) this.#running = null;
    }
  }

  pause(): void {
    this.#running?.abort();
    this.#running = null;
    for (const file of this.files) if (file.state !== "there") file.state = "waiting";
    this.#set("paused");
  }

  async #send(signal: AbortSignal): Promise<void> {
    const { name, files } = this.chosen;
    const announced = { name, files: files.length, bytes: this.total, key: uploadKey(files) };
    const there = await this.#present(announced, signal);
    if (there) {
      this.upload = there;
      return;
    }
    const { upload, resumed } = await this.#patiently(() => this.requests.begin(announced, signal), signal);
    this.upload = upload;
    const listed = resumed ? await this.#patiently(() => this.requests.files(upload.id, signal), signal) : [];
    const known = new Map(listed.map((file) => [file.path, file]));
    for (const file of this.files) file.sent = known.get(file.path)?.offset ?? 0;
    let next = 0;
    const sendNext = async (): Promise<void> => {
      while (next < files.length) {
        const place = next++;
        await this.#sendFile(upload.id, files[place], this.files[place], known.get(files[place].path), signal);
      }
    };
    await Promise.all(Array.from({ length: AT_ONCE }, sendNext));
    this.#set("finishing");
    this.upload = await this.#patiently(() => this.requests.finish(upload.id, signal), signal);
  }

  /** An earlier, finished upload with the same content, if there is one. */
  async #present({ name, files, bytes }: Announcement, signal: AbortSignal): Promise<Upload | null> {
    const all = await this.#patiently(() => this.requests.uploads(signal), signal);
    const alike = all.filter((one) => one.capture && one.name === name && one.files === files && one.bytes === bytes);
    for (const upload of alike) {
      const listed = await this.#patiently(() => this.requests.files(upload.id, signal), signal);
      if (await this.#same(new Map(listed.map((file) => [file.path, file])), signal)) return upload;
    }
    return null;
  }

  async #same(known: ReadonlyMap<string, RemoteFile>, signal: AbortSignal): Promise<boolean> {
    for (const [place, sent] of this.files.entries()) {
      const other = known.get(sent.path);
      if (other?.offset !== sent.size) return false;
      const sha256 =
        this.#hashes.get(sent) ?? (await this.#read(sent.path, this.chosen.files[place].file, sent, signal));
      if (other.sha256 !== sha256) return false;
      sent.state = "waiting";
    }
    return true;
  }

  async #sendFile(
    id: string,
    { path, file }: ChosenFile,
    sent: SentFile,
    known: RemoteFile | undefined,
    signal: AbortSignal,
  ): Promise<void> {
    for (let attempt = 1; ; attempt++) {
      const sha256 = this.#hashes.get(sent) ?? (await this.#read(path, file, sent, signal));
      if (known?.verified && known.sha256 === sha256) break;
      try {
        await this.#sendContent(id, { path, size: file.size, sha256 }, file, sent, signal);
        break;
      } catch (error) {
        const code = error instanceof ApiError ? error.code : "";
        if (code === "upload-finished") break; // another page has sent the same
        if (code !== "checksum-mismatch" || attempt === CHANGES) throw error;
        this.#hashes.delete(sent);
      }
    }
    sent.sent = sent.size;
    sent.state = "there";
    this.onChange();
  }

  async #read(path: string, file: File, sent: SentFile, signal: AbortSignal): Promise<string> {
    sent.state = "reading";
    this.onChange();
    const sha256 = await this.hash(file).catch((error: Error) => {
      throw new Error(`${path} ${error.message}; choose the folder again.`);
    });
    signal.throwIfAborted();
    this.#hashes.set(sent, sha256);
    return sha256;
  }

  async #sendContent(
    id: string,
    announced: { path: string; size: number; sha256: string },
    file: File,
    sent: SentFile,
    signal: AbortSignal,
  ): Promise<void> {
    sent.state = "sending";
    const made = await this.#patiently(() => this.requests.announce(id, announced, signal), signal);
    let { offset } = made;
    let again = false;
    while (offset < file.size) {
      const start = offset;
      sent.sent = start;
      this.onChange();
      const onBytes = (bytes: number) => {
        if (signal.aborted) return;
        sent.sent = start + bytes;
        this.onChange();
      };
      offset = await this.#patiently(async () => {
        // after an interruption only the server has the offset
        if (again) return this.requests.offset(made.location, signal);
        again = true;
        const piece = file.slice(start, start + PIECE);
        return this.requests.send(made.location, start, piece, onBytes, signal);
      }, signal).catch((error: unknown) => {
        if (error instanceof ApiError && error.code === "offset-mismatch")
          return this.requests.offset(made.location, signal);
        throw error;
      });
      again = false;
    }
  }

  /** Repeat a request until there is a final answer, with longer and longer pauses. */
  async #patiently<T>(ask: () => Promise<T>, signal: AbortSignal): Promise<T> {
    for (let tries = 0; ; tries++) {
      try {
        const answer = await ask();
        signal.throwIfAborted();
        if (tries > 0) this.#set("sending");
        return answer;
      } catch (error) {
        if (signal.aborted || !(error instanceof ApiError) || !MAY_PASS.has(error.status)) throw error;
        this.#set("waiting", error.message);
        await this.requests.wait(Math.min(LONGEST_WAIT, 0.5 * 2 ** Math.min(tries, 10)), signal);
      }
    }
  }

  #set(state: TransferState, problem = ""): void {
    this.state = state;
    this.problem = problem;
    this.onChange();
  }
}
