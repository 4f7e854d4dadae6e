"""Pictures: the same as the command line's, in the caller's memory."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import pocketnerf
from conftest import program, python


def test_pictures_are_those_of_the_command_line(
    model: pocketnerf.Model, demo: Path, tmp_path: Path
) -> None:
    file = tmp_path / "picture.png"
    program("render", demo, "--width", 90, "--height", 70, "--out", file, "--quiet")
    expected = np.asarray(Image.open(file).convert("RGB"))
    picture = model.render(width=90, height=70)
    assert picture.dtype == np.uint8 and np.array_equal(picture, expected)
    # A camera with the same view, from a matrix.
    own = model.camera.resized(90, 70)
    camera = pocketnerf.Camera(
        90, 70, own.camera_to_world, focal=own.focal, center=own.center
    )
    assert np.array_equal(model.render(camera), expected)
    flipped = own.camera_to_world * np.array([1, -1, -1, 1], np.float32)
    camera = pocketnerf.Camera(
        90, 70, flipped[:3], fov_x=own.fov_x, center=own.center, convention="opencv"
    )
    assert np.abs(model.render(camera).astype(int) - expected).max() <= 2


def test_floats_alpha_and_backgrounds_agree(model: pocketnerf.Model) -> None:
    size = {"width": 60, "height": 50}
    bytes_ = model.render(**size)
    floats = model.render(**size, dtype=np.float32)
    assert floats.dtype == np.float32
    assert np.array_equal(np.clip(floats * 255 + 0.5, 0, 255.5).astype(np.uint8), bytes_)
    straight = model.render(**size, dtype="float32", alpha=True)
    color, alpha = straight[..., :3], straight[..., 3:]
    assert straight.shape == (50, 60, 4) and alpha.min() == 0 and alpha.max() > 0.99
    for background in ([0.0, 0.0, 0.0], [0.25, 0.5, 1.0]):
        over = color * alpha + np.float32(background) * (1 - alpha)
        assert np.allclose(model.render(**size, dtype="float32", background=background), over, atol=1e-6)
    assert np.array_equal(model.render(**size, background="white"), bytes_)
    rounded = model.render(**size, alpha=True)
    seen = alpha[..., 0] > 0
    assert np.array_equal(rounded[seen], np.clip(straight * 255 + 0.5, 0, 255.5).astype(np.uint8)[seen])


def test_pictures_go_to_the_array_that_is_given(model: pocketnerf.Model) -> None:
    size = {"width": 64, "height": 48}
    out, depth = np.full((48, 64, 3), 7, np.uint8), np.zeros((48, 64), np.float32)
    assert model.render(**size, out=out) is out
    plain = model.render(**size)
    assert np.array_equal(out, plain)
    assert model.render(**size, antialias=1, out=out, depth_out=depth) is out
    plain = model.render(**size, antialias=1)
    # Pixels are interpolated where their depths agree, too.
    assert np.abs(out.astype(int) - plain).mean() < 0.1
    assert np.array_equal(depth, model.depth(**size))
    # The middle of the picture shows the scene, its corner nothing.
    assert np.isinf(depth[0, 0]) and 2.0 < depth[24:, 32].min() < 6.0
    part = np.zeros((2, 48, 64, 4), np.float32)
    assert model.render(**size, alpha=True, out=part[1]).base is part
    assert part[0].max() == 0 and part[1].max() > 0


def test_no_frame_is_copied(demo: Path) -> None:
    """A picture of 28 MB takes less than a fifth of that beside itself."""
    script = f"""
import numpy as np, pocketnerf
def peak():
    return next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM"))
model = pocketnerf.Model.open({str(demo)!r})
model.render(width=64, height=64)
camera = model.camera.resized(3072, 3072)
for dtype in ("uint8", "float32"):
    out = np.ones((3072, 3072, 3), dtype)
    before = peak()
    model.render(camera, quality=0, out=out)
    print((peak() - before) * 1024 / out.nbytes)
"""
    grown = [float(line) for line in python("-c", script).split()]
    assert len(grown) == 2 and max(grown) < 0.2, grown


def test_depths_and_normals_are_those_of_rays(model: pocketnerf.Model) -> None:
    camera = model.camera.resized(40, 40)
    origins, directions = camera.rays()
    assert np.allclose(np.linalg.norm(directions, axis=-1), 1, atol=1e-5)
    # The ray through the principal point goes forward.
    assert np.allclose(directions[19:21, 19:21].mean((0, 1)), -camera.camera_to_world[:3, 2], atol=1e-3)
    along_rays = model.ray_depths(origins, directions)
    depth = model.depth(camera, quality=1)
    both = np.isfinite(along_rays) & np.isfinite(depth)
    assert both.sum() > 300 and np.median(np.abs(along_rays[both] - depth[both])) < 1e-3
    normals = model.normals(camera)
    found = np.linalg.norm(normals, axis=-1) > 0
    assert found.sum() > 300 and np.allclose(np.linalg.norm(normals[found], axis=-1), 1, atol=1e-4)
    # Surfaces face the camera.
    facing = (normals * directions).sum(-1)[found]
    assert (facing < 0.1).mean() > 0.8 and np.median(facing) < -0.4


def test_notebooks_show_a_png(model: pocketnerf.Model, tmp_path: Path) -> None:
    file = tmp_path / "shown.png"
    file.write_bytes(model._repr_png_())
    shown = np.asarray(Image.open(file))
    assert np.array_equal(shown, model.render())
    pocketnerf.write_png(file, shown[:, ::-1])
    assert np.array_equal(np.asarray(Image.open(file)), shown[:, ::-1])


@pytest.mark.parametrize("antialias", [2, 3])
def test_rays_of_a_pixel_are_averaged(model: pocketnerf.Model, antialias: int) -> None:
    many = 30 * antialias
    fine = model.render(width=many, height=many, quality=1, dtype="float32", antialias=1)
    mean = fine.reshape(30, antialias, 30, antialias, 3).mean((1, 3))
    found = model.render(width=30, height=30, quality=1, dtype="float32", antialias=antialias)
    assert np.allclose(found, mean, atol=2e-3)


def test_orbits_go_around_the_z_axis(model: pocketnerf.Model) -> None:
    bounds = model.bounds
    assert bounds is not None
    middle = bounds.mean(0)
    for azimuth, elevation in ((0.0, 0.0), (0.5, 0.3), (-2.0, -0.4)):
        flat = np.cos(elevation)
        way = [flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)]
        camera = model.orbit(azimuth, elevation, distance=4.0, width=30, height=20)
        assert np.allclose(camera.position, middle + 4 * np.array(way), atol=1e-4)
        # It looks at the middle, with z upwards.
        assert np.allclose(camera.camera_to_world[:3, 2], way, atol=1e-5)
        assert camera.camera_to_world[2, 1] > 0 and abs(camera.camera_to_world[2, 0]) < 1e-6
        assert (camera.width, camera.height) == (30, 20)
    assert model.render(model.orbit(0.5, 0.3, width=30, height=30)).std() > 5
