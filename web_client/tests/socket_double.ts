import { decode, encode } from "@msgpack/msgpack";
import { fromHex } from "../src/codec/hex";
import type { Socket } from "../src/protocol/connection";
import { TWO_SEGMENTS } from "./worker_double";

/** A socket whose other end is the test. */
export class FakeSocket implements Socket {
  binaryType: BinaryType = "blob";
  onopen: ((event: Event) => void) | null = null;
  onmessage: ((event: MessageEvent) => void) | null = null;
  onclose: ((event: CloseEvent) => void) | null = null;
  readonly sent: Record<string, unknown>[] = [];
  closed: number | undefined;

  send(data: Uint8Array): void {
    this.sent.push(decode(data) as Record<string, unknown>);
  }

  close(code?: number): void {
    this.closed = code;
  }

  open(): void {
    this.onopen?.(new Event("open"));
  }

  receive(bytes: Uint8Array): void {
    this.onmessage?.({ data: bytes.slice().buffer } as MessageEvent);
  }

  /** @param manifest empty to leave it out; its id is `id` of every byte. */
  welcome(manifest = TWO_SEGMENTS.toString(), id = 7): void {
    const bytes = new TextEncoder().encode(manifest);
    const manifest_id = new Uint8Array(32).fill(id);
    this.receive(encode({ type: "welcome", protocol: 1, scene: "s", manifest: bytes, manifest_id, remaining: 0 }));
  }

  types(): unknown[] {
    return this.sent.map(({ type }) => type);
  }

  frame(id: string, offset: number, size: number, payload: Uint8Array): void {
    const bytes = new Uint8Array(48 + payload.length);
    const view = new DataView(bytes.buffer);
    view.setUint8(0, 1);
    view.setUint32(4, offset, true);
    view.setUint32(8, size, true);
    bytes.set(fromHex(id), 16);
    bytes.set(payload, 48);
    this.receive(bytes);
  }

  drop(code: number): void {
    this.onclose?.({ code } as CloseEvent);
  }

  credits(): number {
    return this.sent.filter(({ type }) => type === "credit").reduce((sum, { bytes }) => sum + (bytes as number), 0);
  }
}
