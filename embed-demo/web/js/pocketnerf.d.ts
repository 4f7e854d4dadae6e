/**
 * Radiance fields in a web page, rendered on the GPU where the browser has one, or on the CPU.
 *
 * Coordinates and lengths are those of the photographs that a model was made from.
 */

/** A pinhole camera. Axes are OpenGL's: x right, y up, looking along -z. */
export interface Camera {
  /** Pixels, 1 to 16384. */
  width: number;
  height: number;
  /** Focal lengths in x and y, pixels. */
  focal: [number, number];
  /** Principal point, pixels from the top left corner; pixel (0, 0) has its centre at (0.5, 0.5). */
  center: [number, number];
  /** 4x4 camera-to-world, row after row: columns right, up, back (unit vectors), position. */
  pose: ArrayLike<number> & Iterable<number>;
}

/** Facts about a file. */
export interface Info {
  name: string;
  /** Kind of the field, such as `hash-grid`. */
  kind: string;
  method: string;
  program: string;
  dataset: string;
  /** The file's own view (`isOwn`), or one beside the scene; `tangent` is that of half its horizontal field of view. */
  camera: { pose: number[]; tangent: number; width: number; height: number; isOwn: boolean };
  /** The centre of the scene, and the longest side of the box around it; of a scene without an end, of the part that keeps its shape. */
  center: [number, number, number];
  size: number;
  /** The background, 0 to 1, in the model's own colour space. */
  background: [number, number, number];
  /** Colours and background are linear light; pictures are sRGB in any case. */
  isLinear: boolean;
  /** The default quality of pictures. */
  quality: number;
  /** Whether `pick` is supported: not for forward-facing captures and scenes without an end. */
  hasDepth: boolean;
  /** Distance between samples along a ray. */
  step: number;
  /** Occupied fraction of the box. */
  occupancy: number;
  /** The box in the model's own coordinates. */
  box: { min: number[]; max: number[] };
  /** From the model's coordinates: scale * rotation * model + translation; rotation row after row. */
  scene: { scale: number; rotation: number[]; translation: number[] };
  /** Forward-facing captures: distance of the nearest object; else 0. */
  near: number;
}

export interface RenderOptions {
  /** From 0, the fastest, to 1, the finest; default `info.quality`. */
  quality?: number;
  /** Receives the size and the complete picture. */
  canvas?: HTMLCanvasElement | OffscreenCanvas;
  /** Called for each tile when it is rendered. */
  onTile?: (tile: ImageData, x: number, y: number) => void;
}

export interface Pick {
  /** Distance from the camera to where half of the light is absorbed. */
  depth: number;
  point: [number, number, number];
}

export interface Stats {
  ms: number;
  rays: number;
  samples: number;
  /** Memory of the module, bytes. */
  memory: number;
  /**
   * What rendered the picture. A GPU renders from when its program is compiled, within seconds,
   * to when it fails. Its pictures differ in last bits from one to another.
   */
  device: "gpu" | "cpu";
}

export interface LoadOptions {
  /** `off`: render on the CPU. `software`: accept a software GPU too, for tests. */
  gpu?: "off" | "software";
}

export declare class Scene {
  private constructor();
  readonly info: Info;
  /** Statistics of the last complete picture. */
  readonly stats: Stats;
  /** The file's own camera for a picture of this size, which shows all that its own picture shows. */
  camera(width?: number, height?: number): Camera;
  /**
   * Renders a picture in a worker. Resolves to `null` if another picture was requested before
   * this one was complete: only the newest is rendered. Rejects with one line of text.
   */
  render(camera?: Camera, options?: RenderOptions): Promise<ImageData | null>;
  /** What is at a point of the picture, pixels; default camera: that of the last picture. */
  pick(x: number, y: number, camera?: Camera): Promise<Pick | null>;
  /** Ends the worker. Pending calls reject. */
  close(): void;
}

/** Opens a `.pnerf` file, with every byte checked; rejects with one line of text. */
export declare function load(
  source: ArrayBuffer | ArrayBufferView | Blob,
  options?: LoadOptions,
): Promise<Scene>;
