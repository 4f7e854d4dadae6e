"""Types of the program's options, as keywords."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, TypedDict, Union

if TYPE_CHECKING:
    import os

Color = Union[Literal["white", "black"], str, Sequence[float]]


class TrainOptions(TypedDict, total=False):
    """Further options of ``train``; ``pocketnerf train --help`` describes them."""

    aabb: Sequence[float]
    auto: bool
    background: Color
    batch_rays: int
    components: int
    crop_steps: int
    density: Literal["relu", "softplus", "exp"]
    density_noise: float
    depth: int
    device: Literal["cpu", "gpu"]
    downscale_factor: int
    exposure: Literal["auto", "off"]
    far: float
    fog: Literal["clear", "keep"]
    gaussian: Sequence[float]
    heads: int
    hidden_width: int
    hold_every: int
    learning_rate: float
    log2_hashmap_size: int
    max_bytes: int
    method: Literal[
        "hash-grid", "planes", "plenoxels", "nerf", "derf", "llff", "srn", "neural-volumes"
    ]
    n_levels: int
    near: float
    no_hierarchy: bool
    no_positional_encoding: bool
    no_view_dependence: bool
    octaves: Sequence[int]
    plane_resolution: int
    precision: Literal["i8", "f16", "f32"]
    profile: Literal["fine", "fast"]
    refine_poses: bool
    samples: Sequence[int]
    sampling: Literal["occupancy", "hierarchical"]
    scale: float
    sh_bands: int
    simd: str
    smooth_surfaces: Union[bool, float]
    space: Literal["box", "ndc", "contracted"]
    spherify: bool
    target_psnr: float
    teachers: int
    up: Union[str, Sequence[float]]
    views: int
    voxels: int
    width: int


class EvaluateOptions(TypedDict, total=False):
    """Further options of ``evaluate``; ``pocketnerf eval --help`` describes them."""

    antialias: Union[bool, int, str]
    device: Literal["cpu", "gpu"]
    downscale_factor: int
    fit_exposure: bool
    fit_poses: bool
    hold_every: int
    lpips_weights: Union[str, os.PathLike[str]]
    no_skip: bool
    out: Union[str, os.PathLike[str]]
    pixel_origin: Literal["center", "corner"]
    quality: float
    sampling: Literal["occupancy", "hierarchical"]
    simd: str
    spherify: bool
