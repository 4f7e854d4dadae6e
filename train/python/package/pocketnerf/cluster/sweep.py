"""One scene with many settings."""

from __future__ import annotations

import itertools
import os
import re
from typing import Any, Dict, List, Mapping, Optional, Sequence

from pocketnerf import Error

from . import files
from .progress import OnProgress
from .scenes import Data, run_of, train
from .table import Row, Table


def sweep(
    data: Data,
    out: files.Path,
    options: Mapping[str, Sequence[Any]],
    *,
    split: str = "val",
    num_cpus: float = 2,
    seconds: Optional[float] = None,
    steps: Optional[int] = None,
    max_retries: int = 3,
    memory: Optional[int] = None,
    storage: Optional[files.Path] = None,
    save_every: float = 30.0,
    on_progress: Optional[OnProgress] = None,
    progress: Optional[bool] = None,
    address: Optional[str] = None,
    **shared: Any,
) -> Table:
    """Trains and evaluates one scene with every combination of some options.

    Choose on val views, and look at the test views only once, with the setting that is chosen.
    More values in a later call cost only what is new, as combinations that are done are skipped.

    Times of different machines are not comparable: choose by PSNR and bytes, with ``steps``, or
    compare times with ``pocketnerf.cluster.chart``.

    Args:
        data: path that all nodes see, ``"builtin:NAME"`` or ``pocketnerf.Dataset``.
        out: folder on the driver's machine, for the models, such as ``steps=500,seed=0.pnerf``,
            and for ``results.csv`` and ``sweep.csv``, the returned table.
        options: option of ``pocketnerf.train`` -> values. The last option varies fastest.
        split: views to evaluate: ``"val"`` or ``"test"``.
        shared: further options of ``pocketnerf.train``, the same for all.

    The others are those of ``train_many``.

    Returns:
        A row for each combination, in the order of ``itertools.product``: the options, ``psnr``
        and ``psnr_min`` (the worst view) in dB, ``bytes``, ``seconds``, and then what
        ``train_many`` gives.

    Example:
        >>> from pocketnerf.cluster import sweep
        >>> settings = {"log2_hashmap_size": [13, 15], "n_levels": [6, 9]}
        >>> table = sweep("builtin", "sizes", settings, steps=2000)  # doctest: +SKIP
        >>> table.best("psnr_min")["log2_hashmap_size"]  # doctest: +SKIP
        15
    """
    combinations = product(options)
    every = {"seconds": seconds, "steps": steps, "save_every": save_every, **shared}
    runs = [run_of(name, (data, own), every, split) for name, own in combinations.items()]
    table = train(
        runs,
        out,
        memory=memory,
        num_cpus=num_cpus,
        max_retries=max_retries,
        storage=None if storage is None else os.fspath(storage),
        on_progress=on_progress,
        progress=progress,
        address=address,
    )
    rows: List[Row] = []
    for own, row in zip(combinations.values(), table):
        first = {key: row.get(key) for key in ("psnr", "psnr_min", "bytes", "seconds")}
        rows.append({**{key: _cell(value) for key, value in own.items()}, **first, **row})
    chosen = Table(rows)
    chosen.to_csv(os.path.join(os.fspath(out), "sweep.csv"))
    return chosen


def product(options: Mapping[str, Sequence[Any]]) -> Dict[str, Dict[str, Any]]:
    """All combinations, by names that are file names."""
    for key, values in options.items():
        if isinstance(values, (str, bytes)) or not values:
            raise Error(
                f"options of a sweep: found {key}={values!r}, expected a list with at least one "
                f"value; give {key}=[...]"
            )
    named: Dict[str, Dict[str, Any]] = {}
    for values in itertools.product(*options.values()):
        own = dict(zip(options, values))
        name = ",".join(f"{key}={_word(value)}" for key, value in own.items())
        if name in named:
            raise Error(f"options of a sweep: found {name} twice, expected different values")
        named[name] = own
    return named


def _word(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        value = "_".join(str(part) for part in value)
    return re.sub(r"[^A-Za-z0-9._+-]", "_", str(value))


def _cell(value: Any) -> Any:
    simple = value is None or isinstance(value, (bool, int, float, str))
    return value if simple else str(value)
