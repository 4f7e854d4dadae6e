// Where photographs were taken: a section of the file that the module does not read (formats/SPEC.md).

const PHOTOGRAPHS = 13;
const POSE_BYTES = 12;
const MOST = 64;

/**
 * Poses in the dataset's coordinates, as in `Camera`; none where the file does not say it.
 * @param {Uint8Array} bytes of a file that was checked
 * @param {{ scale: number, rotation: number[], translation: number[] }} scene
 */
export function photographs(bytes, { scale, rotation, translation }) {
  const section = find(bytes);
  if (!section || section.byteLength < 29) return [];
  const float = (i) => section.getFloat32(4 * i, true);
  const [low, high] = [1, 4].map((first) => [0, 1, 2].map((a) => float(first + a)));
  // A length in one byte or two.
  const isLong = section.getUint8(28) > 127;
  const begin = isLong ? 30 : 29;
  const n = Math.min(Math.floor((section.byteLength - begin) / POSE_BYTES), MOST);
  return Array.from({ length: n }, (_, k) => {
    const value = (i) => section.getUint16(begin + POSE_BYTES * k + 2 * i, true);
    const [x, y, z] = [3, 4, 5].map((i) => value(i) / 32767 - 1);
    const at = low.map((v, a) => v + (value(a) / 65535) * (high[a] - v));
    const own = turn(x, y, z, Math.sqrt(Math.max(1 - x * x - y * y - z * z, 0)));
    const rows = [0, 3, 6].flatMap((row, a) => {
      const along = (v) => rotation[row] * v[0] + rotation[row + 1] * v[1] + rotation[row + 2] * v[2];
      return [...[0, 1, 2].map((c) => along([own[c], own[3 + c], own[6 + c]])), scale * along(at) + translation[a]];
    });
    return [...rows, 0, 0, 0, 1];
  });
}

/** The section, if there is one of the layout that is known. */
function find(bytes) {
  const file = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const count = file.getUint32(12, true);
  for (let entry = 32; entry < 32 + 48 * count; entry += 48) {
    const [kind, version] = [file.getUint32(entry, true), file.getUint32(entry + 8, true)];
    // Version 1, stored as it is.
    if (kind !== PHOTOGRAPHS || version !== 1) continue;
    const [offset, length] = [16, 24].map((at) => Number(file.getBigUint64(entry + at, true)));
    return new DataView(bytes.buffer, bytes.byteOffset + offset, length);
  }
  return null;
}

/** The rotation of a quaternion, row after row. */
function turn(x, y, z, w) {
  // Rounding, or a file that is damaged.
  const s = 2 / (x * x + y * y + z * z + w * w);
  return [
    ...[1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
    ...[s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)],
    ...[s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)],
  ];
}
