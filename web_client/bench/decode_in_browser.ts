/**
 * Decoding rates in one worker of headless Chromium: `npm run bench:worker -- SCENE/chunks`, a folder of chunks.
 * HGS_CHROMIUM names the browser if it is not `chromium`.
 */

import { spawn } from "node:child_process";
import { mkdtempSync, readdirSync, readFileSync, rmSync } from "node:fs";
import { createServer } from "node:http";
import type { AddressInfo } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { zstdWasm } from "../plugins/zstd_wasm.ts";

const REPEATS = 200;
const LIMIT = 600_000; // milliseconds

const folder = process.argv[2];
if (!folder) throw new Error("usage: npm run bench:worker -- FOLDER_OF_CHUNKS");
const files = readdirSync(folder);
const page = `<!doctype html><script type="module">
new Worker("/worker.js", { type: "module" }).postMessage(${JSON.stringify({ files, repeats: REPEATS })});
</script>`;
// A page isolated from others has a clock of 5 microseconds, another one of 100.
const isolated = { "Cross-Origin-Opener-Policy": "same-origin", "Cross-Origin-Embedder-Policy": "require-corp" };

const rates = new Promise<string>((resolve, reject) => {
  const profile = mkdtempSync(join(tmpdir(), "hgs-bench-"));
  const server = createServer(async (request, response) => {
    const { url = "/", method } = request;
    const answer = (type: string, body: string | Buffer) =>
      response.writeHead(200, { "Content-Type": type, ...isolated }).end(body);
    const file = url.slice("/chunks/".length);
    if (method === "POST") {
      let body = "";
      for await (const part of request) body += part;
      answer("text/plain", "");
      resolve(body);
    } else if (url === "/") answer("text/html", page);
    else if (url === "/worker.js") answer("text/javascript", readFileSync(new URL("worker.js", import.meta.url)));
    else if (url === "/zstd.wasm") answer("application/wasm", Buffer.from(zstdWasm()));
    else if (files.includes(file)) answer("application/octet-stream", readFileSync(join(folder, file)));
    else response.writeHead(404).end();
  });
  server.listen(0, "127.0.0.1", () => {
    const address = `http://127.0.0.1:${(server.address() as AddressInfo).port}/`;
    const flags = ["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", `--user-data-dir=${profile}`];
    const browser = spawn(process.env.HGS_CHROMIUM ?? "chromium", [...flags, address], { stdio: "ignore" });
    const late = setTimeout(() => reject(new Error("no answer from the browser")), LIMIT);
    browser.on("error", reject);
    const close = () => {
      clearTimeout(late);
      server.close();
      server.closeAllConnections();
      browser.once("exit", () => rmSync(profile, { recursive: true, force: true, maxRetries: 5 }));
      browser.kill();
    };
    rates.then(close, close);
  });
});
process.stdout.write(await rates);
