// Radiance fields in a web page; documented in pocketnerf.d.ts.

import { orbit, own } from "./cameras.js";
import { bytesOf } from "./source.js";

const WASM = new URL("./pocketnerf.wasm", import.meta.url);
let compiled = null;

/** The code, fetched and compiled once for all scenes. */
function code() {
  compiled ??= WebAssembly.compileStreaming(fetch(WASM)).catch(async (error) => {
    // The server sends another content type.
    const response = await fetch(WASM).catch(() => null);
    if (!response?.ok) {
      compiled = null;
      throw new Error(`${WASM}: ${error.message}`);
    }
    return WebAssembly.compile(await response.arrayBuffer());
  });
  return compiled;
}

/**
 * Opens a `.pnerf` file.
 * @param {string | URL | Response | ArrayBuffer | ArrayBufferView | Blob} source
 * @param {{ gpu?: "off" | "software", signal?: AbortSignal, onProgress?: Function }} options
 * @returns {Promise<Scene>}
 */
export async function load(source, { gpu, signal, onProgress } = {}) {
  const [bytes, module] = await Promise.all([bytesOf(source, { signal, onProgress }), code()]);
  signal?.throwIfAborted();
  const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  const calls = new Calls(worker);
  try {
    const message = { kind: "open", module, bytes, gpu };
    const { info, memory } = await calls.send(message, { transfer: [bytes], signal });
    return new Scene(calls, info, memory);
  } catch (error) {
    calls.end("closed");
    throw error;
  }
}

/** Calls to the worker that wait for an answer. */
class Calls {
  #worker;
  #waiting = new Map();
  #last = 0;
  #ended = null;

  constructor(worker) {
    this.#worker = worker;
    worker.onmessage = ({ data }) => this.#answer(data);
    worker.onerror = (event) => {
      event.preventDefault();
      this.end(`the worker stopped: ${event.message ?? "it did not load"}`);
    };
  }

  /** `signal` ends the wait, and tells the worker. */
  send(message, { transfer = [], onTiles, signal } = {}) {
    return new Promise((resolve, reject) => {
      if (this.#ended) return reject(new Error(this.#ended));
      if (signal?.aborted) return reject(signal.reason);
      const id = ++this.#last;
      const stop = () => {
        if (!this.#waiting.delete(id)) return;
        this.#worker.postMessage({ kind: "cancel", id });
        reject(signal.reason);
      };
      const done = (end) => (result) => {
        signal?.removeEventListener("abort", stop);
        end(result);
      };
      signal?.addEventListener("abort", stop, { once: true });
      this.#waiting.set(id, { resolve: done(resolve), reject: done(reject), onTiles });
      this.#worker.postMessage({ ...message, id }, transfer);
    });
  }

  end(why) {
    this.#ended ??= why;
    this.#worker.terminate();
    for (const { reject } of this.#waiting.values()) reject(new Error(this.#ended));
    this.#waiting.clear();
  }

  #answer({ id, tiles, result, error }) {
    const call = this.#waiting.get(id);
    if (!call) return;
    if (tiles) call.onTiles?.(tiles);
    if (result === undefined && error === undefined) return;
    this.#waiting.delete(id);
    if (error === undefined) call.resolve(result);
    else call.reject(new Error(error));
  }
}

/** An open file, with its own worker. */
export class Scene {
  #calls;
  #seen = null;

  constructor(calls, info, memory) {
    this.#calls = calls;
    /** Facts about the file. */
    this.info = info;
    /** Statistics of the last complete picture. */
    this.stats = { ms: 0, rays: 0, samples: 0, memory, device: "cpu" };
  }

  /** The file's own camera, or one beside the scene, for a picture of this size. */
  camera(width = this.info.camera.width, height = this.info.camera.height) {
    return own(this.info, width, height);
  }

  /** A camera that goes around the centre of the scene: angles in radians. */
  orbit(azimuth, elevation, { distance, up = this.info.up, width, height } = {}) {
    const size = width && height ? { width, height } : this.info.camera;
    return orbit(this.info, azimuth, elevation, { ...size, distance, up });
  }

  /** Renders a picture; null if another one was requested before it was complete. */
  async render(camera = this.camera(), { quality, canvas, onTile, signal } = {}) {
    const { width, height } = camera;
    const context = canvas?.getContext("2d");
    let image = null;
    const isComplete = await this.#paint(camera, { quality, signal }, (tile) => {
      image ??= new ImageData(width, height);
      place(image.data, tile.pixels, width, tile, 4);
      onTile?.(new ImageData(tile.pixels, tile.width, tile.height), tile.x, tile.y);
    });
    if (!isComplete) return null;
    if (context) {
      if (canvas.width !== width) canvas.width = width;
      if (canvas.height !== height) canvas.height = height;
      context.putImageData(image, 0, 0);
    }
    return image;
  }

  /** Renders what is to be composited with other things by depth; null as `render` has it. */
  async layer(camera = this.camera(), { quality, signal } = {}) {
    const { width, height } = camera;
    const pixels = new Uint8ClampedArray(4 * width * height);
    const depth = new Float32Array(width * height);
    const isComplete = await this.#paint(camera, { quality, signal, isLayer: true }, (tile) => {
      place(pixels, tile.pixels, width, tile, 4);
      place(depth, tile.depth, width, tile, 1);
    });
    return isComplete ? { width, height, pixels, depth } : null;
  }

  async #paint(camera, { quality = this.info.quality, signal, isLayer = false }, onTile) {
    this.#seen = camera;
    const plain = { ...camera, pose: [...camera.pose] };
    const onTiles = (tiles) => tiles.forEach(onTile);
    const message = { kind: "render", camera: plain, quality, isLayer };
    const stats = await this.#calls.send(message, { onTiles, signal });
    if (stats) this.stats = stats;
    return stats !== null;
  }

  /** What `camera`, or that of the last picture, sees at a point; null if there is nothing. */
  async pick(x, y, camera = this.#seen ?? this.camera()) {
    const { found } = await this.#calls.send({ kind: "pick", camera, x, y });
    return found;
  }

  /** Ends the worker and frees its memory. */
  close() {
    this.#calls.end("the scene is closed");
  }
}

/** Copies a tile of `n` values a pixel into a picture. */
function place(to, from, across, { x, y, width, height }, n) {
  for (let row = 0; row < height; row += 1) {
    const line = from.subarray(n * row * width, n * (row + 1) * width);
    to.set(line, n * ((y + row) * across + x));
  }
}
