#!/usr/bin/env python3
"""A point of torch-ngp for `pocketnerf chart --peers`.

OUTPUT_FILE is the log in the workspace, WORKSPACE/log_ngp.txt, after
    python main_nerf.py SCENE --workspace WORKSPACE -O --test

Format read in ashawkey/torch-ngp: main_nerf.py, commit 87bb685, and nerf/utils.py, commit
0793857. The log grows with every run; the last evaluation that finished counts. Training
evaluates val views now and then and test views at its end, so --test first is surest.
It holds the views' mean PSNR, and SSIM and LPIPS where these meters are switched on in
main_nerf.py. Evaluation composites on white, so white is written unless --background says
that it was changed.
"""

import re

from _row import Wrong, lines, main, scores

EVALUATION = re.compile(
    r"^\+\+> Evaluate at epoch \d+ \.\.\.\n(.*?)^\+\+> Evaluate epoch \d+ Finished\.$",
    re.MULTILINE | re.DOTALL,
)
METER = re.compile(r"^(PSNR|SSIM|LPIPS)(?: \(\w+\))? = (\S+)$", re.MULTILINE)


def read(text, _):
    # From the last beginning on: one that was cut off must not take the next one's figures.
    start = "++> Evaluate at epoch "
    pieces = [EVALUATION.match(start + piece) for piece in text.split(start)[1:]]
    meters = [METER.findall(piece[1]) for piece in pieces if piece]
    found = {name.lower(): value for name, value in meters[-1]} if meters else {}
    if "psnr" not in found:
        raise Wrong(
            f"{lines(text)}, {len(meters)} finished evaluations, "
            "expected `PSNR = ..` in the last one, as in WORKSPACE/log_ngp.txt"
        )
    return scores(found)


main(
    __doc__,
    read,
    program="torch-ngp",
    background="1,1,1",
    source="main_nerf.py, its last evaluation",
)
