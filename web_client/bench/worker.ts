/** The worker of decode_in_browser.ts: fetches every chunk that it is told of, and reports the rates. */

import { provideZstd } from "../src/codec/zstd";
import { decodingRates } from "./rates";

self.onmessage = async ({ data }: MessageEvent<{ files: string[]; repeats: number }>) => {
  await provideZstd(await WebAssembly.compile(await (await fetch("/zstd.wasm")).arrayBuffer()));
  const chunks = await Promise.all(
    data.files.map(async (file) => new Uint8Array(await (await fetch(`/chunks/${file}`)).arrayBuffer())),
  );
  await fetch("/rates", { method: "POST", body: await decodingRates(chunks, data.repeats) });
};
