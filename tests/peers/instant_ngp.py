#!/usr/bin/env python3
"""A point of instant-ngp for `pocketnerf chart --peers`.

OUTPUT_FILE is what this prints on standard output:
    python scripts/run.py --scene SCENE --nerf_compatibility --n_steps N \\
        --test_transforms SCENE/transforms_test.json > OUTPUT_FILE

Format read in NVlabs/instant-ngp, scripts/run.py, commit eedd3cb.
It holds the mean PSNR and SSIM of the views. run.py compares on black, whatever the scene's
background is, so black is written unless --background says that it was changed.
"""

import re

from _row import Wrong, lines, main, scores

LINE = re.compile(r"^PSNR=(\S+) \[min=\S+ max=\S+\] SSIM=(\S+)$", re.MULTILINE)


def read(text, _):
    found = LINE.findall(text)
    if not found:
        raise Wrong(
            f"{lines(text)}, none of them a result, "
            "expected `PSNR=.. [min=.. max=..] SSIM=..` as run.py --test_transforms prints"
        )
    psnr, ssim = found[-1]
    return scores({"psnr": psnr, "ssim": ssim})


main(
    __doc__,
    read,
    program="instant-ngp",
    background="0,0,0",
    source="scripts/run.py --test_transforms",
)
