"""What a model answers beside pictures, against what follows from its density."""

from __future__ import annotations

import numpy as np
import pytest

import pocketnerf


@pytest.fixture(scope="module")
def points(model: pocketnerf.Model) -> np.ndarray:
    """Points on what the model's own camera sees."""
    origins, directions = model.camera.resized(48, 48).rays()
    depth = model.ray_depths(origins, directions, kind="median")
    seen = np.isfinite(depth)
    return origins[seen] + depth[seen][:, None] * directions[seen]


def test_shapes_follow_the_points(model: pocketnerf.Model, points: np.ndarray) -> None:
    some = points[:24].reshape(2, 3, 4, 3)
    assert model.density(some).shape == (2, 3, 4)
    assert model.density(some[0, 0, 0]).shape == ()
    assert model.density(np.zeros((0, 3))).shape == (0,)
    assert model.density_gradient(some).shape == (2, 3, 4, 3)
    color, sigma = model.radiance(some, np.broadcast_to([0, 0, -1], some.shape))
    assert color.shape == (2, 3, 4, 3) and 0 <= color.min() and color.max() <= 1
    assert np.array_equal(sigma, model.density(some))
    assert np.array_equal(model.density(some.tolist()), sigma)
    assert np.array_equal(model.density(np.asfortranarray(some.astype(np.float64))), sigma)


def test_space_outside_is_empty(model: pocketnerf.Model, points: np.ndarray) -> None:
    bounds = model.bounds
    assert bounds is not None and bounds.shape == (2, 3)
    outside = bounds[1] + 1
    assert model.density(outside) == 0 and not model.occupied(outside)
    assert model.sphere_clear(outside, 0.5) and not model.sphere_clear(outside, 10.0)
    assert model.occupied(points).all() and (model.density(points) > 0).mean() > 0.99
    clear = model.sphere_clear(points[:10], np.linspace(0, 1, 10))
    assert clear.shape == (10,) and not clear.any()
    assert model.occupied([np.nan, 0, 0]) and not model.sphere_clear([np.inf, 0, 0], 1)


def test_gradients_are_differences_of_density(model: pocketnerf.Model, points: np.ndarray) -> None:
    gradient = model.density_gradient(points[::7])
    step = 1e-3
    differences = np.stack(
        [
            (model.density(points[::7] + step * axis) - model.density(points[::7] - step * axis)) / (2 * step)
            for axis in np.eye(3, dtype=np.float32)
        ],
        -1,
    )
    cosine = (gradient * differences).sum(-1) / (
        np.linalg.norm(gradient, axis=-1) * np.linalg.norm(differences, axis=-1) + 1e-9
    )
    assert np.median(cosine) > 0.95


def test_transmittance_is_the_integral_of_density(model: pocketnerf.Model, points: np.ndarray) -> None:
    eye = model.camera.position
    ends = points[:: max(1, len(points) // 40)]
    # Only to the surface: behind it nothing passes.
    starts = ends + 0.1 * (eye - ends) / np.linalg.norm(eye - ends, axis=-1, keepdims=True)
    t = (np.arange(4000) + 0.5) / 4000
    along = starts[:, None] + t[:, None] * (ends - starts)[:, None]
    length = np.linalg.norm(ends - starts, axis=-1)
    expected = np.exp(-model.density(along).astype(np.float64).mean(-1) * length)
    found = model.transmittance(starts, ends)
    # Both are sums over samples of a rough field, the model's over its own fewer steps.
    assert np.abs(found - expected).mean() < 0.08 and np.corrcoef(found, expected)[0, 1] > 0.8
    # All light passes in front, and none through all of the scene.
    assert (model.transmittance(np.broadcast_to(eye, ends.shape), eye + 0.5 * (ends - eye)) > 0.99).all()
    behind = eye + 3 * (ends - eye)
    assert np.median(model.transmittance(np.broadcast_to(eye, ends.shape), behind)) < 0.01


def test_depths_have_their_order(model: pocketnerf.Model) -> None:
    origins, directions = model.camera.resized(32, 32).rays()

    def depth(kind: str, threshold: float | None = None) -> np.ndarray:
        return model.ray_depths(origins, directions, kind=kind, threshold=threshold)  # type: ignore[arg-type]

    early, median, late = depth("first_opacity", 0.1), depth("median"), depth("first_opacity", 0.9)
    assert np.array_equal(median, depth("first_opacity", 0.5))
    seen = np.isfinite(late)
    assert seen.sum() > 150 and (early[seen] <= median[seen]).all() and (median[seen] <= late[seen]).all()
    first = depth("first_sigma", 1e-3)
    assert (first[seen] <= late[seen] + 1e-2).all()


def test_collisions_follow_catnips(model: pocketnerf.Model, points: np.ndarray) -> None:
    body, volume, area = points[:20], 1e-4, 1e-3
    expected = 1 - np.exp(-model.density(body).astype(np.float64).sum() * volume / area)
    found = model.collision_probability(body, volume=volume, particle_area=area)
    assert found == pytest.approx(expected, rel=1e-4)
