"""What the scripts beside this file share: options, the row, and how a wrong file is refused."""

import argparse
import csv
import math
import os
import sys

COLUMNS = (
    "program scene setting split views width height background psnr ssim lpips "
    "ms_per_frame train_seconds bytes source machine"
).split()


class Wrong(Exception):
    """The file is not what was expected: one line."""


def number(found, name, low=0.0, high=math.inf):
    """A figure of the output. The chart refuses what is not finite, so better here."""
    try:
        value = float(found)
    except (TypeError, ValueError, OverflowError):
        value = math.nan
    if not (math.isfinite(value) and low <= value <= high):
        bounds = f"from {low:g}" + ("" if high == math.inf else f" to {high:g}")
        raise Wrong(f"{name} is {str(found)[:40]!r}, expected a number {bounds}")
    return value


def scores(found):
    """PSNR, and SSIM and LPIPS where the output has them."""
    row = {"psnr": number(found.get("psnr"), "psnr")}
    if found.get("ssim") is not None:
        row["ssim"] = number(found["ssim"], "ssim", -1.0, 1.0)
    if found.get("lpips") is not None:
        row["lpips"] = number(found["lpips"], "lpips")
    return row


def lines(text):
    """How many, for messages."""
    return f"{len(text.splitlines())} lines"


def positive(kind):
    def parse(text):
        value = kind(text)
        if not (math.isfinite(value) and value > 0):
            raise ValueError
        return value

    parse.__name__ = f"positive {kind.__name__}"  # argparse says it
    return parse


def color(text):
    """As pocketnerf writes it: R,G,B from 0 to 1."""
    parts = {"white": "1,1,1", "black": "0,0,0"}.get(text, text).split(",")
    if len(parts) != 3 or not all(0 <= float(part) <= 1 for part in parts):
        raise ValueError
    return ",".join(f"{float(part):g}" for part in parts)


def options(doc):
    parser = argparse.ArgumentParser(
        description=doc, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("output", metavar="OUTPUT_FILE", help="what the program wrote or printed")
    add("--scene", required=True, metavar="NAME", help="as the chart calls it")
    add("--width", required=True, type=positive(int), metavar="W", help="of the compared pictures")
    add("--height", required=True, type=positive(int), metavar="H")
    add("--setting", metavar="TEXT", help="what was run: a method, a config")
    add("--split", metavar="NAME", help="which views: test")
    add("--views", type=positive(int), metavar="N", help="how many of them")
    add("--background", type=color, metavar="COLOR", help="white, black or R,G,B from 0 to 1")
    add("--ms-per-frame", type=positive(float), metavar="MS", help="time of one picture")
    add("--train-seconds", type=positive(float), metavar="S", help="wall time of training")
    add("--bytes", type=positive(int), metavar="N", help="size of the model's file")
    add("--machine", metavar="TEXT", help="what it ran on")
    add("--source", metavar="TEXT", help="who measured (default: the program's command)")
    add("--append", metavar="peers.csv", help="add to this file, which begins if it is not there")
    return parser.parse_args()


def append(path, row):
    """Columns stay those of the file: it may be one that somebody wrote."""
    with open(path, "a+", newline="", encoding="utf-8") as file:
        file.seek(0)
        before = file.read()
        columns = [name.strip() for name in next(csv.reader(before.splitlines()), [])]
        missing = [name for name, value in row.items() if name not in columns]
        if before and missing:
            raise Wrong(f"columns {columns}, expected {missing} among them")
        file.seek(0, os.SEEK_END)
        if before and not before.endswith("\n"):
            file.write("\n")
        write(file, columns or COLUMNS, row, header=not before)


def write(file, columns, row, header):
    writer = csv.DictWriter(file, columns, lineterminator="\n")
    if header:
        writer.writeheader()
    writer.writerow(row)


def main(doc, read, **known):
    """Makes the row. `read` takes the file's text and the options and gives the columns that
    the output holds; `known` are those that every output of the program shares. What is given
    by option counts most."""
    given = options(doc)
    file = given.output
    try:
        with open(file, encoding="utf-8", errors="replace") as opened:
            row = {**known, **read(opened.read(), given)}
        told = {name: getattr(given, name, None) for name in COLUMNS}
        row.update((name, value) for name, value in told.items() if value is not None)
        if given.append:
            file = given.append
            append(file, row)
        else:
            sys.stdout.reconfigure(encoding="utf-8")
            write(sys.stdout, COLUMNS, row, header=True)
    except OSError as error:
        refuse(f"{file}: cannot be read or written: {error.strerror}, expected a file")
    except UnicodeDecodeError:
        refuse(f"{file}: not a text in UTF-8, expected a table of points")
    except Wrong as wrong:
        refuse(f"{file}: {wrong}")


def refuse(message):
    sys.exit(" ".join(message.split()))
