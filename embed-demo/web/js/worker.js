// Renders in a worker, a few tiles at a time, and handles messages in between.

import { Gpu } from "./gpu.js";
import { Instance } from "./instance.js";
import { photographs } from "./photographs.js";

/** Milliseconds of rendering before messages are handled. */
const BATCH = 12;

let instance = null;
/** What renders instead of `instance`, where there is one. */
let gpu = null;
/** The next picture to render; it replaces the current one. */
let next = null;
let isRendering = false;
/** The picture under way that nobody wants any more. */
let cancelled = null;

const answers = {
  open({ module, bytes, gpu: which }) {
    const file = new Uint8Array(bytes);
    instance = new Instance(module, file);
    // Compiling may take seconds: until then, and where it fails, the CPU renders.
    Gpu.open(module, file, which).then((opened) => (gpu = opened), () => {});
    const { info } = instance;
    return { info: { ...info, photographs: photographs(file, info.scene) }, memory: instance.memory };
  },
  pick: ({ camera, x, y }) => ({ found: instance.pick(camera, x, y) }),
};

addEventListener("message", async ({ data }) => {
  if (data.kind === "cancel") {
    if (next?.id === data.id) next = null;
    else cancelled = data.id;
    return;
  }
  if (data.kind === "render") {
    if (next) drop(next);
    next = data;
    if (!isRendering) render();
    return;
  }
  try {
    postMessage({ id: data.id, result: await answers[data.kind](data) });
  } catch (error) {
    fail(data, error);
  }
});

async function render() {
  isRendering = true;
  while (next) {
    const job = next;
    next = null;
    try {
      await paint(job);
    } catch (error) {
      fail(job, error);
    }
  }
  isRendering = false;
}

async function paint(job) {
  const { id, camera, quality, isLayer } = job;
  const begun = performance.now();
  const count = instance.begin(camera, quality);
  const used = gpu;
  let left = camera.width * camera.height;
  try {
    for await (const tiles of used ? used.bands(instance, camera, isLayer) : bands(count, isLayer)) {
      for (const tile of tiles) left -= tile.width * tile.height;
      const own = tiles.flatMap(({ pixels, depth }) => (depth ? [pixels, depth] : [pixels]));
      postMessage({ id, tiles }, own.map((list) => list.buffer));
      if (cancelled === id || (left && next)) return drop(job);
    }
  } catch (error) {
    if (!used) throw error;
    gpu = null;
    return paint(job);
  }
  const ms = performance.now() - begun;
  const stats = used?.stats ?? instance.stats;
  const device = used ? "gpu" : "cpu";
  postMessage({ id, result: { ms, ...stats, memory: instance.memory, device } });
}

/** The picture that was begun, by the CPU, some tiles at a time. */
async function* bands(count, isLayer) {
  let tiles = [];
  let since = performance.now();
  for (let number = 0; number < count; number += 1) {
    tiles.push(instance.tile(number, isLayer));
    if (performance.now() - since < BATCH && number + 1 < count) continue;
    await messages();
    yield tiles;
    tiles = [];
    since = performance.now();
  }
}

function drop({ id }) {
  postMessage({ id, result: null });
}

function fail({ id }, error) {
  const trapped = error instanceof WebAssembly.RuntimeError;
  const text = trapped ? `the renderer stopped: ${error.message}` : error.message;
  postMessage({ id, error: text });
}

/** Lets pending messages be handled, without a timer's delay. */
const channel = new MessageChannel();
function messages() {
  return new Promise((resolve) => {
    channel.port1.onmessage = resolve;
    channel.port2.postMessage(null);
  });
}
