// Pictures by WebGPU, where there is a GPU that computes what WebAssembly does. Used by the worker.

import { Instance } from "./instance.js";

/** Pixels along a side of the picture that is compared; its mean square error at most: 40 dB. */
const SIDE = 16;
const MOST_ERROR = 6.5;
/** Milliseconds of a band: newer requests are noticed, and no driver is reset for being late. */
const BAND = 20;
/** Bytes of a pixel: colour, then distance and samples. */
const COLOR = 16;
const DISTANCE = 8;
/** Samples of a ray; WebAssembly says what is wrong with a file that asks for more. */
const MOST_SAMPLES = 1 << 15;
/** Software GPUs are slower than WebAssembly. */
const SOFTWARE = /swiftshader|llvmpipe|lavapipe|basic render/i;

/** Quads of numbers that the program leaves a pixel for a second one, where there is one. */
const MEAN = /const N_MEAN = (\d+)u/;

/** A model in a GPU's memory, and the program that renders it. */
export class Gpu {
  #device;
  #layout;
  /** What renders and, where colours are computed afterwards, what does so. */
  #pipelines;
  /** Bytes of a pixel that the first leaves for the second. */
  #mean;
  /** Buffers that the program reads, the uniform first. */
  #inputs;
  /** Bytes of a buffer. */
  #most;
  #room = null;
  #failure = null;
  /** Pixels of the next band. */
  #pixels = 1 << 12;
  /** Rays and samples of the last picture. */
  stats = null;

  /**
   * Opens a file on the browser's GPU. Rejects where there is none that renders it.
   * @param {WebAssembly.Module} module
   * @param {Uint8Array} bytes of the file
   * @param {"off" | "software" | undefined} which none, or whatever there is
   */
  static async open(module, bytes, which) {
    const adapter = which !== "off" && (await navigator.gpu?.requestAdapter());
    if (!adapter) throw new Error("no GPU");
    const { vendor, architecture, device, description, isFallbackAdapter } = adapter.info;
    const name = `${vendor} ${architecture} ${device} ${description}`;
    if (which !== "software" && (isFallbackAdapter || SOFTWARE.test(name))) throw new Error(name);
    const { maxBufferSize, maxStorageBufferBindingSize } = adapter.limits;
    const requiredLimits = { maxBufferSize, maxStorageBufferBindingSize };
    const opened = await adapter.requestDevice({ requiredLimits });
    const gpu = new Gpu(opened, Math.min(maxBufferSize, maxStorageBufferBindingSize));
    // An instance of its own: the buffers' memory is freed with it.
    const instance = new Instance(module, bytes);
    await gpu.#load(instance.pack());
    await gpu.#compare(instance);
    return gpu;
  }

  constructor(device, most) {
    this.#device = device;
    this.#most = most;
    device.onuncapturederror = (event) => {
      event.preventDefault();
      this.#failure ??= event.error;
    };
    device.lost.then(({ message }) => (this.#failure ??= new Error(message)));
  }

  async #load({ program, buffers }) {
    const { STORAGE, UNIFORM, COPY_DST } = GPUBufferUsage;
    const model = buffers.map((bytes) => {
      const buffer = this.#buffer(bytes.length, STORAGE | COPY_DST);
      this.#device.queue.writeBuffer(buffer, 0, bytes);
      return buffer;
    });
    // No rays are given: pictures have a camera.
    this.#inputs = [this.#buffer(144, UNIFORM | COPY_DST), ...model, this.#buffer(24, STORAGE)];
    const types = ["uniform", ...Array(4).fill("read-only-storage"), ...Array(3).fill("storage")];
    const entries = types.map((type, binding) => {
      return { binding, visibility: GPUShaderStage.COMPUTE, buffer: { type } };
    });
    this.#layout = this.#device.createBindGroupLayout({ entries });
    const layout = this.#device.createPipelineLayout({ bindGroupLayouts: [this.#layout] });
    const module = this.#device.createShaderModule({ code: program });
    this.#mean = 16 * (MEAN.exec(program)?.[1] ?? 0);
    const compile = (entryPoint) =>
      this.#device.createComputePipelineAsync({ layout, compute: { module, entryPoint } });
    const names = this.#mean ? ["render", "shade"] : ["render"];
    this.#pipelines = await Promise.all(names.map(compile));
  }

  /** Drivers have faults: a small picture is to be that of WebAssembly, and to show something. */
  async #compare(instance) {
    const { pose, tangent } = instance.info.camera;
    const half = SIDE / 2;
    const focal = [half / tangent, half / tangent];
    const camera = { width: SIDE, height: SIDE, focal, center: [half, half], pose };
    instance.begin(camera, 1);
    const expected = instance.tile(0).pixels;
    const { pixels: found } = await this.#render(instance, SIDE, 0, SIDE);
    const squares = expected.reduce((sum, v, i) => sum + (v - found[i]) ** 2, 0);
    const isPlain = expected.every((v, i) => v === expected[i % 4]);
    if (squares > MOST_ERROR * found.length || isPlain) throw new Error("the GPU miscomputes");
  }

  /** The picture that `instance` has begun, in bands of rows. Rejects if the GPU fails. */
  async *bands(instance, { width, height }, isLayer = false) {
    this.stats = { rays: width * height, samples: 0 };
    for (let y = 0; y < height; ) {
      const whole = 8 * Math.ceil(Math.max(this.#pixels / width, 1) / 8);
      const bytes = width * Math.max(COLOR + DISTANCE, this.#mean);
      const fits = Math.max(Math.floor(this.#most / bytes), 1);
      const rows = Math.min(whole, fits, height - y);
      const begun = performance.now();
      const { samples, ...seen } = await this.#render(instance, width, y, rows, isLayer);
      this.stats.samples += samples;
      this.#took(width * rows, performance.now() - begun);
      yield [{ x: 0, y, width, height: rows, ...seen }];
      y += rows;
    }
  }

  /** Halfway to what takes as long as a band should, as `bands.rs` of pocketnerf-gpu. */
  #took(pixels, ms) {
    const times = Math.min(Math.max(0.5 + (0.5 * BAND) / Math.max(ms, 0.1), 0.1), 4);
    // The last band of a picture is small and says little.
    if (ms > BAND || pixels >= this.#pixels / 2) {
      this.#pixels = Math.min(Math.max(pixels * times, 1), 1 << 22);
    }
  }

  async #render(instance, width, row, rows, isLayer = false) {
    const n = width * rows;
    const [colors, distances] = [COLOR * n, DISTANCE * n];
    const { queue } = this.#device;
    const room = this.#roomFor(n);
    queue.writeBuffer(this.#inputs[0], 0, instance.frame(row, rows));
    const encoder = this.#device.createCommandEncoder();
    const pass = encoder.beginComputePass();
    pass.setBindGroup(0, room.group);
    for (const pipeline of this.#pipelines) {
      pass.setPipeline(pipeline);
      pass.dispatchWorkgroups(Math.ceil(width / 8), Math.ceil(rows / 8));
    }
    pass.end();
    encoder.copyBufferToBuffer(room.colors, 0, room.read, 0, colors);
    encoder.copyBufferToBuffer(room.distances, 0, room.read, colors, distances);
    queue.submit([encoder.finish()]);
    await room.read.mapAsync(GPUMapMode.READ, 0, colors + distances);
    if (this.#failure) throw this.#failure;
    const seen = room.read.getMappedRange(0, colors + distances);
    const rgba = new Float32Array(seen, 0, 4 * n);
    const numbers = new Uint32Array(seen, colors, 2 * n);
    const depths = isLayer && new Float32Array(seen, colors, 2 * n).filter((_, i) => i % 2 === 0);
    const shown = isLayer ? instance.layer(rgba, depths) : { pixels: instance.shown(rgba) };
    let samples = 0;
    for (let i = 1; i < numbers.length; i += 2) {
      if (numbers[i] > MOST_SAMPLES) throw new Error("too many samples");
      samples += numbers[i];
    }
    room.read.unmap();
    return { ...shown, samples };
  }

  /** Memory for what comes out. */
  #roomFor(pixels) {
    if (this.#room?.pixels >= pixels) return this.#room;
    for (const buffer of this.#room?.own ?? []) buffer.destroy();
    const { STORAGE, COPY_SRC, COPY_DST, MAP_READ } = GPUBufferUsage;
    const colors = this.#buffer(COLOR * pixels, STORAGE | COPY_SRC);
    const distances = this.#buffer(DISTANCE * pixels, STORAGE | COPY_SRC);
    const read = this.#buffer((COLOR + DISTANCE) * pixels, MAP_READ | COPY_DST);
    const means = this.#buffer(this.#mean * pixels, STORAGE);
    const own = [colors, distances, read, means];
    const buffers = [...this.#inputs, colors, distances, means];
    const entries = buffers.map((buffer, binding) => ({ binding, resource: { buffer } }));
    const group = this.#device.createBindGroup({ layout: this.#layout, entries });
    this.#room = { pixels, own, colors, distances, read, group };
    return this.#room;
  }

  #buffer(bytes, usage) {
    // Never empty.
    const size = Math.max(bytes, 16);
    if (size > this.#most) throw new Error("too large for the GPU");
    return this.#device.createBuffer({ size, usage });
  }
}
