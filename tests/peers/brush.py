#!/usr/bin/env python3
"""A point of Brush (Gaussian splats) for `pocketnerf chart --peers`.

OUTPUT_FILE is what this prints on standard output; without RUST_LOG there is nothing in it:
    RUST_LOG=info brush SCENE --eval-split-every 8 > OUTPUT_FILE

Format read in ArthurBrussee/brush: apps/brush-cli/src/lib.rs, commit 0c9da0c, and
crates/brush-train/src/eval.rs, commit 019324a.
It holds how many views are evaluated, and their mean PSNR and SSIM; the last evaluation
counts. Brush evaluates on black, so black is written unless --background says that it was
changed. Its own training time is that of the steps alone, without loading: not taken.
"""

import re

from _row import Wrong, lines, main, scores

VIEWS = re.compile(r"Loaded dataset with \d+ training, (\d+) eval views")
LINE = re.compile(r"Eval iter \d+: PSNR (\S+), ssim (\S+)")


def read(text, _):
    found = LINE.findall(text)
    if not found:
        raise Wrong(
            f"{lines(text)}, none of them a result, "
            "expected `Eval iter N: PSNR .., ssim ..` as brush prints with RUST_LOG=info"
        )
    psnr, ssim = found[-1]
    views = VIEWS.findall(text)
    return {**scores({"psnr": psnr, "ssim": ssim}), **({"views": views[-1]} if views else {})}


main(
    __doc__,
    read,
    program="brush",
    background="0,0,0",
    source="brush, RUST_LOG=info",
)
