/** SHA-256 of files, in a worker. */

export class FileHasher {
  readonly #worker = new Worker(new URL("./hash_worker.ts", import.meta.url), { type: "module" });
  readonly #waiting = new Map<number, { resolve(sha256: string): void; reject(error: Error): void }>();
  #next = 0;

  constructor() {
    this.#worker.addEventListener("message", ({ data }: MessageEvent<{ id: number; sha256: string | null }>) => {
      const one = this.#waiting.get(data.id);
      this.#waiting.delete(data.id);
      if (data.sha256 === null) one?.reject(new Error("cannot be read: it was changed, moved or deleted"));
      else one?.resolve(data.sha256);
    });
    this.#worker.addEventListener("error", () => {
      for (const { reject } of this.#waiting.values()) reject(new Error("cannot be read"));
      this.#waiting.clear();
    });
  }

  /** The SHA-256 of a file, 64 hexadecimal digits. */
  hash(file: File): Promise<string> {
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.#worker.postMessage({ id, file });
    });
  }

  close(): void {
    this.#worker.terminate();
  }
}
