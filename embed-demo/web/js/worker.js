// Renders in a worker, a few tiles at a time, and handles messages in between.

import { Instance } from "./instance.js";

/** Milliseconds of rendering before messages are handled. */
const BATCH = 12;

let instance = null;
/** The next picture to render; it replaces the current one. */
let next = null;
let isRendering = false;

const answers = {
  async open({ module, bytes }) {
    instance = new Instance(await module, new Uint8Array(bytes));
    return { info: instance.info, memory: instance.memory };
  },
  pick: ({ camera, x, y }) => ({ found: instance.pick(camera, x, y) }),
};

addEventListener("message", async ({ data }) => {
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
  const begun = performance.now();
  const count = instance.begin(job.camera, job.quality);
  let tiles = [];
  let since = begun;
  for (let number = 0; number < count; number += 1) {
    tiles.push(instance.tile(number));
    if (performance.now() - since < BATCH || number + 1 === count) continue;
    send({ id: job.id, tiles });
    tiles = [];
    await messages();
    if (next) return drop(job);
    since = performance.now();
  }
  const stats = { ms: performance.now() - begun, ...instance.stats, memory: instance.memory };
  send({ id: job.id, tiles, result: stats });
}

function send(message) {
  postMessage(message, message.tiles.map((tile) => tile.pixels.buffer));
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
