#!/usr/bin/env python3
"""A point of nerfstudio for `pocketnerf chart --peers`.

OUTPUT_FILE is what this writes:
    ns-eval --load-config outputs/.../config.yml --output-path OUTPUT_FILE

Format read in nerfstudio-project/nerfstudio: nerfstudio/scripts/eval.py, commit a71c107, and
nerfstudio/pipelines/base_pipeline.py, commit 4bd26ff.
It holds method and experiment, the views' mean PSNR, SSIM and LPIPS, and pictures and rays a
second. That time includes the metrics of a picture, LPIPS too: it is longer than rendering,
and `source` says so. Better measure rendering alone and give --ms-per-frame.
"""

import json

from _row import Wrong, main, number, scores

COMMAND = "ns-eval"


def read(text, options):
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        raise Wrong("not JSON, expected what ns-eval --output-path writes") from None
    results = found.get("results") if isinstance(found, dict) else None
    if not isinstance(results, dict) or "psnr" not in results:
        keys = sorted(found)[:6] if isinstance(found, dict) else type(found).__name__
        raise Wrong(f"JSON of {keys}, expected `results` with `psnr` as ns-eval writes them")
    row = scores(results)
    names = [found.get("method_name"), found.get("experiment_name")]
    row["setting"] = " ".join(str(name) for name in names if name)
    row["source"] = COMMAND
    pixels = options.width * options.height
    if "fps" in results and "num_rays_per_sec" in results:
        fps = number(results["fps"], "fps", 1e-9)
        rays = number(results["num_rays_per_sec"], "num_rays_per_sec", 1e-9)
        # nerfstudio makes large pictures smaller by itself; sizes of one scene differ a little.
        if abs(rays / fps - pixels) > 0.01 * pixels:
            raise Wrong(
                f"pictures of about {rays / fps:.0f} pixels, "
                f"expected {options.width}x{options.height} = {pixels}"
            )
        row["ms_per_frame"] = 1000.0 / fps
        if options.ms_per_frame is None:
            row["source"] = f"{COMMAND}; its time includes the metrics"
    return row


main(__doc__, read, program="nerfstudio")
