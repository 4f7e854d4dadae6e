// Cameras between keyframes: the same as core's camera/path.rs, and a test compares the two. It is
// JavaScript because the module's memory is the worker's.

/** The pictures of a path through keyframes, so many a second: pose and vertical field of view, degrees. */
export function pictures({ keyframes, isCycle, fps }) {
  const path = new Path(keyframes, isCycle);
  const n = keyframes.length && Math.max(1, Math.floor(path.seconds * fps + 0.5));
  const last = Math.max(1, path.returns ? n : n - 1);
  return Array.from({ length: n }, (_, i) => path.at((path.seconds * i) / last));
}

/** How long it takes. */
export function duration({ keyframes, isCycle }) {
  return new Path(keyframes, isCycle).seconds;
}

class Path {
  #keyframes;
  #stops;
  /** Keyframes from which there is a way to the next. */
  #spans;

  constructor(keyframes, isCycle) {
    const n = keyframes.length;
    this.#keyframes = keyframes;
    this.#stops = keyframes.map(({ pose }) => ({
      position: [pose[3], pose[7], pose[11]],
      rotation: quaternion(pose),
    }));
    this.returns = isCycle && n > 1;
    this.#spans = this.returns ? n : Math.max(n - 1, 0);
    this.seconds = keyframes.slice(0, this.#spans).reduce((sum, { seconds }) => sum + seconds, 0);
  }

  at(time) {
    const all = this.#keyframes;
    if (this.#spans === 0) return { pose: all[0].pose, fov: all[0].fov };
    let [left, a] = [time, 0];
    for (; a + 1 < this.#spans && left >= all[a].seconds; a += 1) left -= all[a].seconds;
    const b = (a + 1) % all.length;
    const h = all[a].seconds;
    const t = Math.min(Math.max(left / h, 0), 1);
    const [from, to] = [a, b].map((i) => ({ ...this.#stops[i], ...this.#slope(i) }));
    return { pose: place(from, to, h, t), fov: all[a].fov + t * (all[b].fov - all[a].fov) };
  }

  /** How the camera moves as it passes a keyframe, a second: of the parabola through three. */
  #slope(i) {
    const after = i < this.#spans ? this.#way(i) : null;
    const hasBefore = i > 0 || this.returns;
    const before = hasBefore ? this.#way(i > 0 ? i - 1 : this.#stops.length - 1) : null;
    if (!before || !after) return before ?? after;
    const mean = (name) => {
      const [slow, fast] = [before[name], after[name]];
      return slow.map((v, k) => (after.h * v + before.h * fast[k]) / (before.h + after.h));
    };
    return { velocity: mean("velocity"), turn: mean("turn") };
  }

  /** The straight way from a keyframe to the next. */
  #way(i) {
    const [a, b] = [this.#stops[i], this.#stops[(i + 1) % this.#stops.length]];
    const h = this.#keyframes[i].seconds;
    const turn = axisOf(times(conjugate(a.rotation), b.rotation));
    return { velocity: b.position.map((v, k) => (v - a.position[k]) / h), turn: scaled(turn, 1 / h), h };
  }
}

/** The pose at a share `t` of the `h` seconds from one stop to the next. */
function place(a, b, h, t) {
  const third = h / 3;
  const beside = (stop, way) => stop.position.map((v, k) => v + way * third * stop.velocity[k]);
  const turned = (stop, way) => times(stop.rotation, ofAxis(scaled(stop.turn, way * third)));
  const points = [a.position, beside(a, 1), beside(b, -1), b.position];
  const rotations = [a.rotation, turned(a, 1), turned(b, -1), b.rotation];
  const position = deCasteljau(points, (p, q) => p.map((v, k) => v + t * (q[k] - v)));
  return matrix(deCasteljau(rotations, (p, q) => slerp(p, q, t)), position);
}

/** A point of a Bézier curve, by mixing neighbours until one is left. */
function deCasteljau(points, mix) {
  const next = points.slice(1).map((point, i) => mix(points[i], point));
  return next.length > 1 ? deCasteljau(next, mix) : next[0];
}

const scaled = (v, by) => v.map((x) => x * by);
const dot = (a, b) => a.reduce((sum, v, k) => sum + v * b[k], 0);
const conjugate = ([x, y, z, w]) => [-x, -y, -z, w];

/** The product of two quaternions x, y, z, w. */
function times([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

/** The axis of a turn, the shorter way, as long as its angle. */
function axisOf(q) {
  const [x, y, z, w] = q[3] < 0 ? scaled(q, -1) : q;
  const sin = Math.hypot(x, y, z);
  return scaled([x, y, z], sin > 1e-9 ? (2 * Math.atan2(sin, w)) / sin : 2);
}

function ofAxis(v) {
  const angle = Math.hypot(...v);
  const by = angle > 1e-9 ? Math.sin(angle / 2) / angle : 0.5;
  return [...scaled(v, by), Math.cos(angle / 2)];
}

function slerp(a, to, t) {
  const along = dot(a, to);
  const b = along < 0 ? scaled(to, -1) : to;
  const angle = Math.acos(Math.min(Math.abs(along), 1));
  const weights = angle > 1e-6 ? [(1 - t) * angle, t * angle].map(Math.sin) : [1 - t, t];
  const mixed = a.map((v, k) => weights[0] * v + weights[1] * b[k]);
  return scaled(mixed, 1 / Math.hypot(...mixed));
}

/** The rotation of a pose, row after row (Shepperd 1978). */
function quaternion(m) {
  const parts = [
    [1 + m[0] - m[5] - m[10], m[1] + m[4], m[2] + m[8], m[9] - m[6]],
    [m[1] + m[4], 1 - m[0] + m[5] - m[10], m[6] + m[9], m[2] - m[8]],
    [m[2] + m[8], m[6] + m[9], 1 - m[0] - m[5] + m[10], m[4] - m[1]],
    [m[9] - m[6], m[2] - m[8], m[4] - m[1], 1 + m[0] + m[5] + m[10]],
  ];
  // The row of the largest part is exact where the others are not.
  const [most] = parts.map((part, k) => [part[k], part]).reduce((a, b) => (b[0] > a[0] ? b : a)).slice(1);
  return scaled(most, 1 / Math.hypot(...most));
}

function matrix([x, y, z, w], [px, py, pz]) {
  return [
    ...[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), px],
    ...[2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x), py],
    ...[2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y), pz],
    ...[0, 0, 0, 1],
  ];
}
