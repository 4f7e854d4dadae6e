"""What Python costs: pictures through Python beside those of the Rust API, and a second thread of
Python beside training and rendering.

    python benches/overhead.py MODEL DATA [--rounds 9] [--size 400]

Both render the views of the split `test` of DATA, one after the other by turns; ratios are those of
a round. A second thread counts; its speed alone, beside training and beside rendering is compared on
one thread of the program fewer than there are cores, which is what a user would leave it.
"""

from __future__ import annotations

import argparse
import os
import statistics
import threading
import time

import numpy as np

import pocketnerf


def frames(model: pocketnerf.Model, cameras: list[pocketnerf.Camera]) -> float:
    """Seconds a frame."""
    camera = cameras[0]
    out = np.empty((camera.height, camera.width, 3), np.uint8)
    begun = time.perf_counter()
    for camera in cameras:
        model.render(camera, out=out, antialias=1)
    return (time.perf_counter() - begun) / len(cameras)


def counted(work: object, seconds: float) -> float:
    """Counts a second in another thread while `work` is called again and again."""
    stop, count = threading.Event(), [0]

    def run() -> None:
        while not stop.is_set():
            count[0] += 1

    thread = threading.Thread(target=run)
    thread.start()
    begun = time.perf_counter()
    while time.perf_counter() - begun < seconds:
        if callable(work):
            work()
        else:
            time.sleep(0.05)
    took = time.perf_counter() - begun
    stop.set()
    thread.join()
    return count[0] / took


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("model")
    parser.add_argument("data")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--size", type=int, default=400)
    given = parser.parse_args()
    model = pocketnerf.Model.open(given.model)
    read = pocketnerf.Dataset.load(given.data)
    first = read.cameras("test")[0]
    factor = max(1, first.width // given.size)
    dataset = pocketnerf.Dataset.load(given.data, downscale_factor=factor)
    cameras = dataset.cameras("test")
    size = f"{cameras[0].width}x{cameras[0].height}"
    ratios = []
    for _ in range(given.rounds):
        rust = pocketnerf.evaluate(
            given.model, given.data, downscale_factor=factor, antialias="off"
        )["seconds_per_frame"]
        python = frames(model, cameras)
        ratios.append(python / rust)
        print(f"{size}: Rust {1000 * rust:.2f} ms, Python {1000 * python:.2f} ms, ratio {ratios[-1]:.3f}")
    print(f"median ratio {statistics.median(ratios):.3f}")
    # All that a call costs beside its pixels; of a shared machine's times, the least.
    tiny, out = cameras[0].resized(1, 1), np.empty((1, 1, 3), np.uint8)
    times = []
    for _ in range(300):
        begun = time.perf_counter()
        model.render(tiny, out=out, antialias=1)
        times.append(time.perf_counter() - begun)
    median = statistics.median(times)
    print(f"1x1: median {1e6 * median:.0f} us, {100 * median / rust:.2f} % of a picture of {size}")
    cores = max(1, (os.cpu_count() or 2) - 1)
    pocketnerf.set_num_threads(cores)

    def train() -> None:
        pocketnerf.train("builtin:white", seconds=10, threads=cores, progress=False)

    for name, work in (("training", train), ("rendering", lambda: frames(model, cameras))):
        shares = []
        for _ in range(3):
            alone = counted(None, 3)
            shares.append(counted(work, 10) / alone)
        print(f"a second thread beside {name}: {', '.join(f'{share:.2f}' for share in shares)} of its speed alone")


if __name__ == "__main__":
    main()
