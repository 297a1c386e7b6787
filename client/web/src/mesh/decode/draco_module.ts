import createModule from 'three/examples/jsm/libs/draco/draco_wasm_wrapper.js';
import wasmUrl from 'three/examples/jsm/libs/draco/draco_decoder.wasm?url';

/* eslint-disable @typescript-eslint/no-explicit-any */
/** The part of Draco's module that is used here; it comes without types. */
export type DracoModule = any;

let loading: Promise<DracoModule> | undefined;

/** Draco's own decoder, from this server, once. */
export function dracoModule(): Promise<DracoModule> {
  loading ??= fetch(wasmUrl)
    .then((answer) => answer.arrayBuffer())
    .then((wasmBinary) => createModule({ wasmBinary }));
  return loading;
}
