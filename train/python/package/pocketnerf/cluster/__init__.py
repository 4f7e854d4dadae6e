"""Many scenes on many machines, through Ray: ``pip install pocketnerf[ray]``.

>>> from pocketnerf import cluster
>>> scenes = {"chair": "/data/chair", "lego": ("/data/lego", {"seed": 1})}
>>> table = cluster.train_many(scenes, "models", steps=4000, evaluate="test")  # doctest: +SKIP
>>> table.best("psnr")["name"]  # doctest: +SKIP
'lego'

Without a cluster the tasks run on this machine. On a cluster, give ``address="auto"`` on its head
node, or call ``ray.init`` first. docs/cluster.md is the guide.
"""

from __future__ import annotations


class RayMissing(ImportError):
    """Ray is not installed."""


try:
    import ray as _ray  # noqa: F401
except ImportError as error:
    raise RayMissing("pocketnerf.cluster needs Ray: pip install pocketnerf[ray]") from error

from .path import render_path  # noqa: E402
from .programs import chart, stress  # noqa: E402
from .scenes import train_many  # noqa: E402
from .sweep import sweep  # noqa: E402
from .table import Table  # noqa: E402

__all__ = ["RayMissing", "Table", "chart", "render_path", "stress", "sweep", "train_many"]
