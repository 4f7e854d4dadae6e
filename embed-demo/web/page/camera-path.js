// Keyframes, and files of them: nerfstudio's camera_path.json, which the window saves and
// `pocketnerf render --camera-path` reads.

import { duration, pictures } from "./between.js";

/** Seconds from one keyframe to the next, and pictures a second, where nothing else is said. */
const SECONDS = 2;
const FPS = 30;

/** Keyframes in the dataset's coordinates, angles in degrees. */
export class CameraPath {
  /** @type {{ pose: number[], fov: number, seconds: number }[]} `seconds`: until the next */
  keyframes = [];
  isCycle = false;
  fps = FPS;

  /** Adds a camera. */
  add({ pose, focal, height }) {
    const fov = degrees(2 * Math.atan((0.5 * height) / focal[1]));
    this.keyframes.push({ pose: [...pose], fov, seconds: SECONDS });
  }

  /** What there is, in words. */
  get words() {
    const n = this.keyframes.length;
    if (n < 2) return ["no keyframes", "1 keyframe"][n];
    return `${n} keyframes, ${+duration(this).toFixed(1)} seconds`;
  }

  /** Pose and vertical field of view of each picture. */
  get pictures() {
    return pictures(this);
  }

  /** The text of a file, for pictures of this size. */
  text([width, height]) {
    const aspect = width / height;
    const file = {
      camera_type: "perspective",
      render_width: width,
      render_height: height,
      fps: this.fps,
      seconds: duration(this),
      is_cycle: this.isCycle,
      smoothness_value: 0,
      default_fov: this.keyframes[0].fov,
      default_transition_sec: SECONDS,
      keyframes: this.keyframes.map(({ pose, fov, seconds }) => ({
        matrix: pose,
        fov,
        aspect,
        override_transition_enabled: seconds !== SECONDS,
        override_transition_sec: seconds,
      })),
      camera_path: this.pictures.map(({ pose, fov }) => ({ camera_to_world: pose, fov, aspect })),
    };
    return JSON.stringify(file, null, 1);
  }

  /** Reads such a file; throws an `Error` of one line. */
  static of(text) {
    const file = parsed(text);
    const path = new CameraPath();
    const lens = file?.camera_type ?? "perspective";
    if (lens !== "perspective") throw new Error(`camera type ${lens}, expected perspective`);
    if (!Array.isArray(file?.keyframes) || !file.keyframes.length) {
      throw new Error("no keyframes in it; expected nerfstudio's camera_path.json with \"keyframes\"");
    }
    const usual = file.default_transition_sec ?? SECONDS;
    path.keyframes = file.keyframes.map((keyframe, i) => {
      const { matrix, fov, override_transition_enabled: isOwn, override_transition_sec: own } = keyframe ?? {};
      const seconds = isOwn ? (own ?? usual) : usual;
      if (!isWithin(fov, 0.5, 180)) {
        throw new Error(`keyframe ${i}: fov ${fov}, expected a vertical angle in degrees from 0.5 to below 180`);
      }
      if (!isWithin(seconds, Number.MIN_VALUE)) throw new Error(`keyframe ${i}: ${seconds} seconds, expected some time`);
      return { pose: poseOf(matrix, i), fov, seconds };
    });
    path.isCycle = file.is_cycle === true;
    path.fps = file.fps ?? FPS;
    const own = duration(path);
    const by = own > 0 ? (file.seconds ?? own) / own : 1;
    if (!isWithin(by, Number.MIN_VALUE) || !isWithin(path.fps, Number.MIN_VALUE) || !(own * by * path.fps < MOST_PICTURES)) {
      throw new Error(`${own * by} seconds of ${path.fps} pictures each, expected some time, and less than an hour`);
    }
    for (const keyframe of path.keyframes) keyframe.seconds *= by;
    return path;
  }
}

/** An hour of them. */
const MOST_PICTURES = 108000;

const isWithin = (v, low, high = Infinity) => typeof v === "number" && v >= low && v < high;

function parsed(text) {
  try {
    return JSON.parse(text);
  } catch (error) {
    throw new Error(`no JSON: ${error.message}`);
  }
}

/** Row after row; as text, as older versions write it, column after column. */
function poseOf(matrix, i) {
  const isText = typeof matrix === "string";
  const found = isText ? parsed(matrix) : matrix;
  const isList = Array.isArray(found) && found.length === 16 && found.every(Number.isFinite);
  const pose = isList && isText ? found.map((_, k) => found[(k % 4) * 4 + (k >> 2)]) : found;
  if (!isList || !isRigid(pose)) {
    throw new Error(`keyframe ${i}: its matrix is no camera-to-world pose, expected a rotation and a position in 16 numbers`);
  }
  return pose;
}

function isRigid(m) {
  const axes = [0, 1, 2].map((c) => [m[c], m[4 + c], m[8 + c]]);
  const dot = (a, b) => a.reduce((sum, v, k) => sum + v * b[k], 0);
  const [[ax, ay, az], [bx, by, bz], back] = axes;
  const cross = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
  const off = axes.flatMap((a, i) => axes.map((b, k) => Math.abs(dot(a, b) - (i === k ? 1 : 0))));
  const hasEnd = [0, 0, 0, 1].every((v, k) => Math.abs(m[12 + k] - v) < 1e-6);
  return hasEnd && Math.max(...off) < 0.02 && dot(cross, back) > 0;
}

const degrees = (radians) => (radians * 180) / Math.PI;
