/**
 * Radiance fields in a web page, rendered on the CPU.
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

/** What is known of a file. */
export interface Info {
  name: string;
  /** Kind of the field: hash-grid, ... */
  kind: string;
  method: string;
  program: string;
  dataset: string;
  /** The file's own view (`isOwn`), or one beside the scene; `tangent` of half its width's angle. */
  camera: { pose: number[]; tangent: number; width: number; height: number; isOwn: boolean };
  /** The middle of what there is to see, and the longest side of the box around it. */
  center: [number, number, number];
  size: number;
  /** The background of pictures, 0 to 1, in the model's own colour space. */
  background: [number, number, number];
  /** Colours, the background's too, are linear light; pictures are sRGB all the same. */
  isLinear: boolean;
  /** The quality that pictures have where nobody chooses. */
  quality: number;
  /** Whether `pick` can be asked: not in forward-facing captures. */
  hasDepth: boolean;
  /** Distance between samples along a ray. */
  step: number;
  /** Part of the box that may hold something. */
  occupancy: number;
  /** The box in the model's own coordinates. */
  box: { min: number[]; max: number[] };
  /** From the model's own: scale * rotation * model + translation; rotation row after row. */
  scene: { scale: number; rotation: number[]; translation: number[] };
  /** Before a forward-facing capture: how far away its nearest thing is. */
  near: number;
}

export interface RenderOptions {
  /** From 0, the fastest, to 1, the finest; `info.quality` unless given. */
  quality?: number;
  /** Is given the picture's size, and the picture, when it is whole. */
  canvas?: HTMLCanvasElement | OffscreenCanvas;
  /** Is told each tile as soon as it is there. */
  onTile?: (tile: ImageData, x: number, y: number) => void;
}

export interface Pick {
  /** Distance from the camera to where half of the light has been held back. */
  depth: number;
  point: [number, number, number];
}

export declare class Scene {
  private constructor();
  readonly info: Info;
  /** What the last whole picture took; `memory`: the module's, bytes. */
  readonly stats: { ms: number; rays: number; samples: number; memory: number };
  /** The file's own camera for a picture of this size: all that its own picture shows is in it. */
  camera(width?: number, height?: number): Camera;
  /**
   * Renders a picture, in a worker. Resolves to `null` when another picture was asked for
   * before this one was whole: only the newest is rendered. Rejects with one line of text.
   */
  render(camera?: Camera, options?: RenderOptions): Promise<ImageData | null>;
  /** What is at a point of the picture, pixels; of the camera rendered last unless one is given. */
  pick(x: number, y: number, camera?: Camera): Promise<Pick | null>;
  /** Ends the worker. What waits for it rejects. */
  close(): void;
}

/** Opens a `.pnerf` file, every byte of it checked; rejects with one line that says what is wrong. */
export declare function load(source: ArrayBuffer | ArrayBufferView | Blob): Promise<Scene>;
