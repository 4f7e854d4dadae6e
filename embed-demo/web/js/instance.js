// An instance of the module: converts its numbers and memory to objects. Used by the worker.

/** Pixels of a tile at most, and so colours at a time. */
const MOST_PIXELS = 128 * 64;
const TEXTS = ["name", "kind", "method", "program", "dataset"];

/** An open file. Failures throw an `Error` with the module's text. */
export class Instance {
  #exports;
  #display;
  /** Rays and samples of the picture so far. */
  stats = { rays: 0, samples: 0 };

  /**
   * @param {WebAssembly.Module} module
   * @param {Uint8Array} bytes of a `.pnerf` file; copied
   */
  constructor(module, bytes) {
    this.#exports = new WebAssembly.Instance(module).exports;
    const address = this.#checked(this.#exports.input(bytes.length));
    new Uint8Array(this.#exports.memory.buffer, address, bytes.length).set(bytes);
    this.#checked(this.#exports.open());
    const facts = this.#floats(this.#exports.facts(), 56);
    this.#display = { isLinear: facts[27] > 0, scale: facts[38] };
  }

  /** Bytes of memory, the file's included. */
  get memory() {
    return this.#exports.memory.buffer.byteLength;
  }

  /** Facts about the file. */
  get info() {
    const f = [...this.#floats(this.#exports.facts(), 56)];
    const texts = TEXTS.map((name, which) => [name, this.#text(this.#exports.text(which))]);
    return {
      ...Object.fromEntries(texts),
      camera: {
        pose: f.slice(0, 16),
        tangent: f[16],
        width: f[17],
        height: f[18],
        isOwn: f[19] > 0,
      },
      center: f.slice(20, 23),
      size: f[23],
      background: f.slice(24, 27),
      isLinear: f[27] > 0,
      quality: f[28],
      hasDepth: f[29] > 0,
      step: f[30],
      occupancy: f[31],
      box: { min: f.slice(32, 35), max: f.slice(35, 38) },
      scene: { scale: f[38], rotation: f.slice(39, 48), translation: f.slice(48, 51) },
      near: f[51],
      up: f.slice(52, 55),
    };
  }

  /** Starts a picture, and returns the number of its tiles. */
  begin(camera, quality) {
    this.#look(camera);
    this.stats = { rays: 0, samples: 0 };
    return this.#checked(this.#exports.begin(camera.width, camera.height, quality));
  }

  /**
   * Renders a tile of it: its place, and its pixels, four bytes each. As a layer, pixels have no
   * background and are multiplied by alpha, and there are depths.
   */
  tile(number, isLayer = false) {
    const length = this.#checked(this.#exports.tile(number, isLayer ? 1 : 0));
    const [x, y, width, height, rays, samples] = this.#floats(this.#exports.answer(), 6);
    this.stats.rays += rays;
    this.stats.samples += samples;
    const place = { x, y, width, height };
    if (!isLayer) {
      return { ...place, pixels: new Uint8ClampedArray(this.#bytes(this.#exports.pixels(), length)) };
    }
    const colors = this.#exports.colors();
    const depths = this.#floats(colors + 16 * MOST_PIXELS, width * height);
    return { ...place, ...this.layer(this.#floats(colors, 4 * width * height), depths) };
  }

  /** Pixels and depths of a layer, of colours and depths in the model's units. */
  layer(colors, depths) {
    const { isLinear, scale } = this.#display;
    const pixels = new Uint8ClampedArray(colors.length);
    const depth = new Float32Array(depths.length);
    for (let i = 0; i < colors.length; i += 1) {
      pixels[i] = 255 * (isLinear && i % 4 < 3 ? encoded(colors[i]) : colors[i]);
    }
    // A GPU divides by the opacity, which may be 0.
    for (let i = 0; i < depths.length; i += 1) {
      depth[i] = colors[4 * i + 3] > 0 ? scale * depths[i] : Infinity;
    }
    return { pixels, depth };
  }

  /**
   * What a GPU renders the file with: a program in WGSL, and its buffers 1 to 3, which are views
   * of memory until the next call.
   */
  pack() {
    this.#checked(this.#exports.pack());
    const [program, ...buffers] = [0, 1, 2, 3].map((which) =>
      this.#bytes(this.#exports.part(which), this.#exports.part_length(which)),
    );
    return { program: new TextDecoder().decode(program), buffers };
  }

  /** Buffer 0, for rows of the picture that was started; until the next call. */
  frame(row, rows) {
    const words = new Uint32Array(this.#exports.memory.buffer, this.#exports.frame(), 36);
    words.set([row, rows], 29);
    return words;
  }

  /** Pixels, four bytes each, of colours that a GPU computed. */
  shown(colors) {
    const pixels = new Uint8ClampedArray(colors.length);
    for (let at = 0; at < colors.length; at += 4 * MOST_PIXELS) {
      const some = colors.subarray(at, at + 4 * MOST_PIXELS);
      this.#floats(this.#exports.colors(), some.length).set(some);
      const length = this.#exports.show(some.length / 4);
      pixels.set(this.#bytes(this.#exports.pixels(), length), at);
    }
    return pixels;
  }

  /** Distance and position of what the camera sees at a point, or null if there is nothing. */
  pick(camera, x, y) {
    this.#look(camera);
    const found = this.#exports.pick(camera.width, camera.height, x, y);
    if (found < 0) this.#fail();
    const [depth, ...point] = this.#floats(this.#exports.answer(), 4);
    return depth === Infinity ? null : { depth, point };
  }

  #look({ pose, focal, center }) {
    this.#floats(this.#exports.view(), 20).set([...pose, ...focal, ...center]);
  }

  // Memory may have moved since the last call: views are created when they are used.
  #floats(address, length) {
    return new Float32Array(this.#exports.memory.buffer, address, length);
  }

  #bytes(address, length) {
    return new Uint8Array(this.#exports.memory.buffer, address, length);
  }

  #text(length) {
    return new TextDecoder().decode(this.#bytes(this.#exports.message(), length));
  }

  #fail() {
    throw new Error(this.#text(this.#exports.message_length()));
  }

  #checked(result) {
    if (result === 0) this.#fail();
    return result;
  }
}

/** Linear light as sRGB. */
function encoded(v) {
  return v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055;
}
