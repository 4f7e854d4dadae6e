"""The compiled part of the package."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from types import TracebackType
from typing import Any, Literal, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Path: TypeAlias = str | PathLike[str]
_Color: TypeAlias = Literal["white", "black"] | Sequence[float]
_Pixels: TypeAlias = NDArray[np.uint8] | NDArray[np.float32]

__version__: str

class Error(Exception):
    """What failed, in one line: which file, what was found, what was expected, what to do."""

    checkpoint: str | None
    """Where a run of training is saved whose model could not be written."""

class DatasetError(Error):
    """A dataset cannot be read."""

class ModelError(Error):
    """A model file cannot be opened."""

class Interrupted(KeyboardInterrupt):
    """Ctrl-C, or an ended callback, stopped long work."""

    checkpoint: str | None
    """The checkpoint of an interrupted run, for ``train(..., resume=...)``."""

@final
class Camera:
    """A pinhole camera in the dataset's coordinates and units.

    ``camera_to_world`` is a 4x4 or 3x4 matrix whose columns are right, up, back (OpenGL, Blender),
    or with ``convention="opencv"`` right, down, forward (COLMAP, OpenCV), and the position. The
    centre of pixel (i, j), from the top left corner, is at (i + 0.5, j + 0.5).
    """

    def __new__(
        cls,
        width: int,
        height: int,
        camera_to_world: ArrayLike,
        *,
        fov_x: float | None = None,
        focal: float | Sequence[float] | None = None,
        center: Sequence[float] | None = None,
        convention: Literal["opengl", "opencv"] = "opengl",
    ) -> Camera: ...
    @staticmethod
    def look_at(
        eye: Sequence[float],
        target: Sequence[float],
        *,
        width: int,
        height: int,
        fov_x: float = ...,
        up: Sequence[float] | None = None,
    ) -> Camera: ...
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def fov_x(self) -> float: ...
    @property
    def focal(self) -> tuple[float, float]: ...
    @property
    def center(self) -> tuple[float, float]: ...
    @property
    def camera_to_world(self) -> NDArray[np.float32]: ...
    @property
    def position(self) -> NDArray[np.float32]: ...
    def resized(self, width: int, height: int) -> Camera: ...
    def rays(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]: ...
    def __eq__(self, other: object, /) -> bool: ...

@final
class Model:
    """An open model. It never changes, so that threads may share it."""

    @staticmethod
    def open(source: _Path | bytes | bytearray | memoryview) -> Model: ...
    def save(self, path: _Path) -> None: ...
    def to_bytes(self) -> bytes: ...
    def close(self) -> None: ...
    @property
    def closed(self) -> bool: ...
    def __enter__(self) -> Model: ...
    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None: ...
    @property
    def method(self) -> str: ...
    @property
    def nbytes(self) -> int: ...
    @property
    def bounds(self) -> NDArray[np.float32] | None: ...
    @property
    def background(self) -> tuple[float, float, float]: ...
    @property
    def camera(self) -> Camera: ...
    @property
    def photographs(self) -> list[Camera]: ...
    @property
    def up(self) -> tuple[float, float, float]: ...
    @property
    def metres(self) -> float | None: ...
    def orbit(
        self,
        azimuth: float,
        elevation: float = 0.5,
        *,
        distance: float | None = None,
        width: int | None = None,
        height: int | None = None,
    ) -> Camera: ...
    def render(
        self,
        camera: Camera | None = None,
        *,
        width: int | None = None,
        height: int | None = None,
        quality: float | None = None,
        background: _Color | None = None,
        dtype: Any = ...,
        alpha: bool = False,
        antialias: int | None = None,
        out: _Pixels | None = None,
        depth_out: NDArray[np.float32] | None = None,
    ) -> _Pixels: ...
    def depth(
        self,
        camera: Camera | None = None,
        *,
        width: int | None = None,
        height: int | None = None,
        quality: float | None = None,
        out: NDArray[np.float32] | None = None,
    ) -> NDArray[np.float32]: ...
    def normals(
        self,
        camera: Camera | None = None,
        *,
        width: int | None = None,
        height: int | None = None,
        out: NDArray[np.float32] | None = None,
    ) -> NDArray[np.float32]: ...
    def density(self, points: ArrayLike) -> NDArray[np.float32]: ...
    def density_gradient(self, points: ArrayLike) -> NDArray[np.float32]: ...
    def radiance(
        self, points: ArrayLike, directions: ArrayLike
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]: ...
    def transmittance(self, starts: ArrayLike, ends: ArrayLike) -> NDArray[np.float32]: ...
    def ray_depths(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        kind: Literal["expected", "median", "first_sigma", "first_opacity"] = "expected",
        threshold: float | None = None,
    ) -> NDArray[np.float32]: ...
    def occupied(self, points: ArrayLike) -> NDArray[np.bool_]: ...
    def sphere_clear(self, centers: ArrayLike, radii: ArrayLike) -> NDArray[np.bool_]: ...
    def collision_probability(
        self, points: ArrayLike, *, volume: float, particle_area: float
    ) -> float: ...
    def _repr_png_(self) -> bytes: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Dataset:
    """Photographs with cameras, in memory."""

    def __new__(
        cls,
        images: Sequence[NDArray[np.uint8]] | NDArray[np.uint8],
        cameras: Sequence[Camera],
        *,
        name: str = "memory",
        names: Sequence[str] | None = None,
        masks: Sequence[NDArray[np.bool_]] | NDArray[np.bool_] | None = None,
        aabb: ArrayLike | None = None,
        val: Sequence[int] | None = None,
        test: Sequence[int] | None = None,
    ) -> Dataset: ...
    @property
    def splits(self) -> list[str]: ...
    @staticmethod
    def load(path: _Path, *, downscale_factor: int = 1, hold_every: int = 8) -> Dataset: ...
    @property
    def name(self) -> str: ...
    def images(self, split: str = "train") -> list[NDArray[np.uint8]]: ...
    def cameras(self, split: str = "train") -> list[Camera]: ...
    def names(self, split: str = "train") -> list[str]: ...
    def __len__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

def run(
    arguments: Sequence[str],
    dataset: Dataset | None = None,
    on_event: Callable[[str, Mapping[str, Any]], object] | None = None,
    threads: int | None = None,
) -> dict[str, Any]:
    """Runs a command of the program in this process and returns what ``--json`` prints.

    ``on_event`` is told of "phase", "progress", "tasks" and "warning" in the calling thread.
    """

def main(arguments: Sequence[str], program: Sequence[str]) -> int:
    """Runs the program as the command line does; returns the exit status.

    ``program`` is what starts it in a process of its own.
    """

def options(command: str) -> dict[str, Literal["flag", "value", "values"]]:
    """Names of a command's long options, and whether each takes no value, one, or several."""

def encode_png(pixels: NDArray[np.uint8]) -> bytes:
    """A picture of shape (height, width, 3) or (height, width, 4) as a PNG file."""

def write_file(path: _Path, data: bytes) -> None:
    """Writes a file that is there as a whole or not at all."""

def num_threads() -> int:
    """The number of threads that work in this process."""

def set_num_threads(n: int) -> None:
    """Sets the number of threads that work in this process, 1 to 1024.

    Pictures and questions to models use them; ``train`` and ``evaluate`` take ``threads``.
    """
