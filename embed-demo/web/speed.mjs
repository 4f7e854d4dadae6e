// node embed-demo/web/speed.mjs NATIVE [MODEL...]: frames by WebAssembly against the same frames
// by native code at the SSE4.2 level, one thread each, by turns in one run. NATIVE is the example
// `frames` of this crate; `embed-demo/web/build` comes first.

import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { Instance } from "./js/instance.js";
import { Scene } from "./js/pocketnerf.js";

const SIDE = 400;
const FRAMES = 3;
const ROUNDS = 7;

const [native, ...models] = process.argv.slice(2);
if (!native) throw new Error("expected the native example's path");
const here = new URL(".", import.meta.url);
const module = new WebAssembly.Module(readFileSync(new URL("dist/pocketnerf.wasm", here)));
const median = (list) => list.toSorted((a, b) => a - b)[list.length >> 1];

if (!models.length) models.push(new URL("../still-life.pnerf", here).pathname);
for (const model of models) {
  const file = readFileSync(model);
  const instance = new Instance(module, file);
  const scene = new Scene(null, instance.info, 0);
  const camera = scene.camera(SIDE, SIDE);
  const frame = () => {
    const begun = performance.now();
    const tiles = instance.begin(camera, scene.info.quality);
    for (let number = 0; number < tiles; number += 1) instance.tile(number);
    return performance.now() - begun;
  };
  for (let i = 0; i < 8; i += 1) frame();
  const rounds = [];
  for (let round = 0; round < ROUNDS; round += 1) {
    const web = median(Array.from({ length: FRAMES }, frame));
    const said = execFileSync(native, [model, String(SIDE), String(FRAMES)]);
    rounds.push({ web, native: median(JSON.parse(said)) });
  }
  const [web, own] = [median(rounds.map((r) => r.web)), median(rounds.map((r) => r.native))];
  const ratio = median(rounds.map((r) => r.native / r.web));
  const beside = instance.memory - file.length;
  console.log(
    `${model}: ${web.toFixed(1)} ms by WebAssembly, ${own.toFixed(1)} ms native, speed ` +
      `${ratio.toFixed(2)}; memory ${instance.memory} bytes, ${beside} beside the file`,
  );
}
