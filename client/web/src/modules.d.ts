declare module 'three/examples/jsm/libs/draco/draco_wasm_wrapper.js' {
  /** Draco's module comes without types. */
  export default function createModule(options: { wasmBinary: ArrayBuffer }): Promise<unknown>;
}
