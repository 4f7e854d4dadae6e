"""Many scenes on many machines: two nodes of Ray's test cluster on this one."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

if not os.environ.get("POCKETNERF_REQUIRE_TOOLS"):
    pytest.importorskip("ray")
os.environ["RAY_USAGE_STATS_ENABLED"] = "0"

import cluster_scenes
import ray
from cluster_scenes import SMALL, die, nap, write_ball
from ray.cluster_utils import Cluster

import pocketnerf
from pocketnerf import Error, cluster
from pocketnerf.cluster import driver, files

pytestmark = pytest.mark.filterwarnings("ignore::pocketnerf.PocketnerfWarning")
# Workers do not see this folder.
ray.cloudpickle.register_pickle_by_value(cluster_scenes)

STORE = 100 * 1024 * 1024
STEPS = 60


@pytest.fixture(scope="module")
def nodes() -> Iterator[Cluster]:
    quick = {"health_check_initial_delay_ms": 0, "health_check_period_ms": 500}
    head = {"num_cpus": 1, "object_store_memory": STORE, "include_dashboard": False}
    nodes = Cluster(initialize_head=True, head_node_args={**head, "_system_config": quick})
    driver.connect(nodes.address)
    yield nodes
    ray.shutdown()
    nodes.shutdown()


@pytest.fixture(scope="module")
def ball(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scenes") / "ball"
    write_ball(folder)
    return folder


def local(data: Path, **options: Any) -> bytes:
    """A model's bytes, from a run in this process."""
    given = {**SMALL, **options}
    return pocketnerf.train(data, threads=1, progress=False, **given).model.to_bytes()


def test_lost_node(nodes: Cluster, ball: Path, tmp_path: Path) -> None:
    """A node is killed while it trains; its scene goes on elsewhere, and no byte differs."""
    seeds = {f"scene-{seed:02}": seed for seed in range(12)}
    node = nodes.add_node(num_cpus=1, object_store_memory=STORE)
    killed = []

    def kill() -> None:
        while len(list(tmp_path.glob("*.pnerf"))) < 4:
            time.sleep(0.05)
        keeper = ray.get_actor(ray.util.list_named_actors()[0])
        begun = set()
        while not killed:
            for name, task in ray.get(keeper.running.remote()).items():
                if task["node"] != node.node_id:
                    continue
                if not task["checkpoint"]:
                    begun.add(name)
                elif name in begun:
                    # Its first checkpoint is new. One that was there before this thread looked
                    # may be of a task that has ended and whose model is on its way.
                    nodes.remove_node(node, allow_graceful=False)
                    killed.append(name)
                    return
            time.sleep(0.02)

    threading.Thread(target=kill, daemon=True).start()
    with ThreadPoolExecutor(1) as pool:
        alone = {name: pool.submit(local, ball, seed=seeds[name], steps=200) for name in seeds}
        table = cluster.train_many(
            {name: (ball, {"seed": seed}) for name, seed in seeds.items()},
            tmp_path,
            num_cpus=1,
            steps=200,
            save_every=0.1,
            **SMALL,
        )
    assert [row["name"] for row in table] == list(seeds)
    assert [row["status"] for row in table] == ["trained"] * 12, table.rows
    lost = table[seeds[killed[0]]]
    assert lost["attempts"] == 2
    assert lost["resumed_at_step"] > 0
    for name in seeds:
        assert files.read(tmp_path / f"{name}.pnerf") == alone[name].result(), name


def test_failures_and_skips(nodes: Cluster, ball: Path, tmp_path: Path) -> None:
    """One scene's failure is its own; a second call does what is left."""
    bad, out = tmp_path / "nowhere", tmp_path / "out"
    memory = pocketnerf.Dataset.load(ball)
    scenes: dict[str, Any] = {"good": ball, "bad": bad, "few": (ball, {"views": 5}), "mem": memory}
    how: dict[str, Any] = {"num_cpus": 0.5, "steps": STEPS, "evaluate": "val", **SMALL}
    seen = []
    table = cluster.train_many(scenes, out, on_progress=lambda *news: seen.append(news), **how)
    assert [row["status"] for row in table] == ["trained", "failed", "trained", "trained"]
    assert "nowhere" in table[1]["error"]
    assert table.failed == [table[1]]
    assert [row["attempts"] for row in table] == [1, 1, 1, 1]
    assert table[0]["steps"] == STEPS
    assert 0 < table[0]["psnr_min"] <= table[0]["psnr"]
    assert {name for name, _ in seen} >= {"good", "few"}
    assert all(isinstance(progress, pocketnerf.Progress) for _, progress in seen)
    assert not (out / "bad.pnerf").exists()
    assert files.read(out / "few.pnerf") == local(ball, views=5, steps=STEPS)
    assert files.read(out / "mem.pnerf") == files.read(out / "good.pnerf")

    read = cluster.Table.read_csv(out / "results.csv")
    assert read.rows == table.rows
    before = os.stat(out / "good.pnerf").st_mtime_ns
    write_ball(bad)
    table = cluster.train_many(scenes, out, **how)
    assert [row["status"] for row in table] == ["skipped", "trained", "skipped", "skipped"]
    assert os.stat(out / "good.pnerf").st_mtime_ns == before
    assert table[0]["psnr"] == read[0]["psnr"]

    with pytest.raises(Error, match="choose another folder"):
        cluster.train_many(scenes, out, **{**how, "steps": 2 * STEPS})


def test_retries_are_bounded(nodes: Cluster) -> None:
    outcomes: dict[str, Any] = {}
    jobs = [driver.Job(name, {"when": when}) for name, when in [("a", 0), ("b", 1), ("c", 9)]]
    driver.run(jobs, die, outcomes.update, num_cpus=0.5, max_retries=1, unit="task")
    assert {name: outcome.row["attempts"] for name, outcome in outcomes.items()} == {
        "a": 1,
        "b": 2,
        "c": 2,
    }
    assert outcomes["b"].row["attempt"] == 2
    assert "lost 2 times" in outcomes["c"].row["error"]


def test_tasks_keep_their_cores(nodes: Cluster) -> None:
    """Nothing that a task waits for lets another one on its cores."""
    outcomes: dict[str, Any] = {}
    jobs = [driver.Job(str(i), {"seconds": 0.1}) for i in range(5)]
    driver.run(jobs, nap, outcomes.update, num_cpus=1, max_retries=0, unit="task")
    spans = sorted((outcome.row["begun"], outcome.row["ended"]) for outcome in outcomes.values())
    assert all(end <= begin for (_, end), (begin, _) in zip(spans, spans[1:])), spans


def test_interrupted_driver(nodes: Cluster, ball: Path, tmp_path: Path) -> None:
    """Checkpoints in shared storage outlive the call."""
    storage, steps = tmp_path / "storage", 2000
    how: dict[str, Any] = {"steps": steps, "num_cpus": 1, "storage": storage, "save_every": 0.1}

    def stop(name: str, progress: pocketnerf.Progress) -> None:
        if progress.step > 0:
            raise RuntimeError("stop")

    with pytest.raises(RuntimeError, match="stop"):
        cluster.train_many({"ball": ball}, tmp_path / "out", on_progress=stop, **how, **SMALL)
    table = cluster.train_many({"ball": ball}, tmp_path / "out", **how, **SMALL)
    assert table[0]["status"] == "trained"
    assert table[0]["resumed_at_step"] > 0
    assert files.read(tmp_path / "out" / "ball.pnerf") == local(ball, steps=steps)
    assert os.listdir(storage) == []


def test_sweep(nodes: Cluster, ball: Path, tmp_path: Path) -> None:
    settings = {"hidden_width": [8, 16], "seed": [0, 1]}
    how: dict[str, Any] = {**SMALL, "num_cpus": 0.5, "steps": 20}
    del how["hidden_width"]
    table = cluster.sweep(ball, tmp_path, settings, **how)
    made = [(row["hidden_width"], row["seed"]) for row in table]
    assert made == [(8, 0), (8, 1), (16, 0), (16, 1)]
    assert table.columns[:6] == ["hidden_width", "seed", "psnr", "psnr_min", "bytes", "seconds"]
    assert table.best("psnr")["psnr"] == max(row["psnr"] for row in table)
    more = cluster.sweep(ball, tmp_path, {"hidden_width": [8, 16, 32], "seed": [0]}, **how)
    assert [row["status"] for row in more] == ["skipped", "skipped", "trained"]


def test_render_path(nodes: Cluster, model: pocketnerf.Model, tmp_path: Path) -> None:
    path = [model.orbit(0.1 * frame, width=20, height=16) for frame in range(5)]
    how: dict[str, Any] = {"frames_per_task": 2, "num_cpus": 0.5, "quality": 1.0}
    frames = cluster.render_path(model, path, tmp_path / "frames", **how)
    assert [os.path.basename(frame) for frame in frames] == [f"0000{i}.png" for i in range(5)]
    for frame, camera in zip(frames, path):
        pocketnerf.write_png(tmp_path / "alone.png", model.render(camera, quality=1.0))
        assert files.read(frame) == files.read(tmp_path / "alone.png")

    os.unlink(frames[3])
    kept = os.stat(frames[2]).st_mtime_ns
    assert cluster.render_path(model, path, tmp_path / "frames", **how) == frames
    assert os.path.exists(frames[3])
    assert os.stat(frames[2]).st_mtime_ns == kept
    with pytest.raises(Error, match="results of other cameras"):
        cluster.render_path(model, path[:3], tmp_path / "frames", **how)


def test_programs(nodes: Cluster, ball: Path, tmp_path: Path) -> None:
    few: dict[str, Any] = {"num_cpus": 1, "steps": 20}
    chart = {"rounds": 1, "views": 1, "qualities": "1"}
    seeds = {"seed": [0, 1]}
    points = cluster.chart(ball, tmp_path / "chart", seeds, chart_options=chart, **few, **SMALL)
    assert [row["model"] for row in points] == ["seed=0", "seed=1"]
    assert all(row["ms_per_frame"] > 0 for row in points)
    assert (tmp_path / "chart" / "index.html").exists()

    spoilt = {"seeds": 1, "downscale_factor": 1, "modes": ["skipping"]}
    table = cluster.stress(ball, tmp_path / "stress", **spoilt, **few)
    assert [(row["mode"], row["verdict"]) for row in table] == [("skipping", "within")]
    assert cluster.stress(ball, tmp_path / "stress", **spoilt, **few).rows == table.rows
    with pytest.raises(Error, match="results of other options"):
        cluster.stress(ball, tmp_path / "stress", **spoilt, **{**few, "steps": 30})


def test_names() -> None:
    files.check_names(["lego", "a=1,b=2", "Scene_01.v2"])
    for names in [["../a"], ["a/b"], [""], [".hidden"], ["-x"], ["a."], ["a", "A"], ["results"]]:
        with pytest.raises(Error):
            files.check_names(names)
    with pytest.raises(TypeError, match="'stepps'"):
        cluster.train_many({"a": "builtin"}, "unused", stepps=5)


def test_table(tmp_path: Path) -> None:
    table = cluster.Table([{"name": "007", "psnr": 31.5}, {"name": "b", "psnr": None, "bytes": 12}])
    table.to_csv(tmp_path / "t.csv")
    read = cluster.Table.read_csv(tmp_path / "t.csv")
    assert read.rows[0] == {"name": "007", "psnr": 31.5, "bytes": None}
    assert read.rows[1] == {"name": "b", "psnr": None, "bytes": 12}
    assert table.best("psnr")["name"] == "007"
    with pytest.raises(Error, match="expected one of name, psnr, bytes"):
        table.best("ssim")
    pytest.importorskip("pandas")
    assert list(table.to_pandas().columns) == ["name", "psnr", "bytes"]
    parquet = pytest.importorskip("pyarrow.parquet")
    table.to_parquet(tmp_path / "t.parquet")
    assert parquet.read_table(tmp_path / "t.parquet").to_pylist() == read.rows


def test_imports() -> None:
    """Ray is loaded only by those who use it, and who lacks it is told."""
    check = "import sys, pocketnerf; assert 'ray' not in sys.modules"
    subprocess.run([sys.executable, "-c", check], check=True)
    lacking = "import sys; sys.modules['ray'] = None; import pocketnerf.cluster"
    failed = subprocess.run([sys.executable, "-c", lacking], capture_output=True, text=True)
    assert "pocketnerf.cluster needs Ray: pip install pocketnerf[ray]" in failed.stderr
