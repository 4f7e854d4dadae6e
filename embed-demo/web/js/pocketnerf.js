// Radiance fields in a web page: see pocketnerf.d.ts for what each part is.

const WASM = new URL("./pocketnerf.wasm", import.meta.url);
let compiled = null;

/** The code, fetched and compiled once for all scenes. */
function code() {
  compiled ??= WebAssembly.compileStreaming(fetch(WASM)).catch(async (error) => {
    // A server that does not know the type.
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
 * @returns {Promise<Scene>}
 */
export async function load(source) {
  const bytes = source instanceof Blob ? await source.arrayBuffer() : copy(source);
  const module = await code();
  const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
  const calls = new Calls(worker);
  try {
    const { info, memory } = await calls.send({ kind: "open", module, bytes }, [bytes]);
    return new Scene(calls, info, memory);
  } catch (error) {
    calls.end("closed");
    throw error;
  }
}

/** The page's part of the bytes stays with the page. */
function copy(source) {
  const view = ArrayBuffer.isView(source)
    ? new Uint8Array(source.buffer, source.byteOffset, source.byteLength)
    : new Uint8Array(source);
  return view.slice().buffer;
}

/** Questions to the worker, and who waits for the answers. */
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

/** A file that is open, with a worker of its own. */
export class Scene {
  #calls;
  #seen = null;

  constructor(calls, info, memory) {
    this.#calls = calls;
    /** What is known of the file. */
    this.info = info;
    /** What the last whole picture took. */
    this.stats = { ms: 0, rays: 0, samples: 0, memory };
  }

  /** The file's own camera, or one beside the scene, for a picture of this size. */
  camera(width = this.info.camera.width, height = this.info.camera.height) {
    const own = this.info.camera;
    // As the renderer's own numbers have it, 32 bits, so that pictures are the same to the byte.
    let focal = Math.fround(Math.fround(0.5 * width) / own.tangent);
    // All that the file's picture shows is in this one.
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

  /** Renders a picture; null where another one was asked for before it was whole. */
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

  /** What `camera`, or the last picture's, sees at a point; null where there is nothing. */
  async pick(x, y, camera = this.#seen ?? this.camera()) {
    const { found } = await this.#calls.send({ kind: "pick", camera, x, y });
    return found;
  }

  /** Ends the worker and gives its memory back. */
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
