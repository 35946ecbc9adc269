/** Address of the decompressor's WebAssembly (plugins/zstd_wasm.ts). */
declare module "virtual:zstd-address" {
  const address: string;
  export default address;
}
