"""``python -m pocketnerf``: the command line."""

import sys

from ._native import main


def run() -> int:
    """Runs the program with the arguments of this process."""
    return main(sys.argv[1:], [sys.executable, "-m", "pocketnerf"])


if __name__ == "__main__":
    sys.exit(run())
