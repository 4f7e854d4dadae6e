// Radiance fields in a web page; documented in pocketnerf.d.ts.

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
 * @param {ArrayBuffer | ArrayBufferView | Blob} source
 * @param {{ gpu?: "off" | "software" }} options
 * @returns {Promise<Scene>}
 */
export async function load(source, { gpu } = {}) {
  const bytes = source instanceof Blob ? await source.arrayBuffer() : copy(source);
  const module = await code();
  const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  const calls = new Calls(worker);
  try {
    const { info, memory } = await calls.send({ kind: "open", module, bytes, gpu }, [bytes]);
    return new Scene(calls, info, memory);
  } catch (error) {
    calls.end("closed");
    throw error;
  }
}

/** The page keeps its own copy of the bytes. */
function copy(source) {
  const view = ArrayBuffer.isView(source)
    ? new Uint8Array(source.buffer, source.byteOffset, source.byteLength)
    : new Uint8Array(source);
  return view.slice().buffer;
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

  send(message, transfer = [], onTiles = null) {
    return new Promise((resolve, reject) => {
      if (this.#ended) return reject(new Error(this.#ended));
      const id = ++this.#last;
      this.#waiting.set(id, { resolve, reject, onTiles });
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
    const own = this.info.camera;
    // In 32 bits, like the renderer, so pictures are the same to the byte.
    let focal = Math.fround(Math.fround(0.5 * width) / own.tangent);
    // This picture shows all that the file's own shows.
    const wide = (width * own.height) / (height * own.width);
    if (wide > 1) focal = Math.fround(focal / wide);
    return {
      width,
      height,
      focal: [focal, focal],
      center: [0.5 * width, 0.5 * height],
      pose: [...own.pose],
    };
  }

  /** Renders a picture; null if another one was requested before it was complete. */
  async render(camera = this.camera(), { quality = this.info.quality, canvas, onTile } = {}) {
    this.#seen = camera;
    const { width, height } = camera;
    let image = null;
    const context = canvas?.getContext("2d");
    const onTiles = (tiles) => {
      image ??= new ImageData(width, height);
      for (const tile of tiles) {
        place(image, tile);
        if (onTile) onTile(new ImageData(tile.pixels, tile.width, tile.height), tile.x, tile.y);
      }
    };
    const plain = { ...camera, pose: [...camera.pose] };
    const stats = await this.#calls.send({ kind: "render", camera: plain, quality }, [], onTiles);
    if (!stats) return null;
    this.stats = stats;
    if (context) {
      if (canvas.width !== width) canvas.width = width;
      if (canvas.height !== height) canvas.height = height;
      context.putImageData(image, 0, 0);
    }
    return image;
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

function place(image, { x, y, width, height, pixels }) {
  for (let row = 0; row < height; row += 1) {
    const line = pixels.subarray(4 * row * width, 4 * (row + 1) * width);
    image.data.set(line, 4 * ((y + row) * image.width + x));
  }
}
