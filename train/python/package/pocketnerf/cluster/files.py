"""Names of files, and files that are there as a whole or not at all."""

from __future__ import annotations

import json
import os
import re
from typing import Any, Dict, Iterable, Mapping, Union

from pocketnerf import Error
from pocketnerf._native import write_file as write

__all__ = ["check_made_of", "check_names", "everywhere", "make_folder", "read", "write"]

Path = Union[str, "os.PathLike[str]"]

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9._,=+-]{0,199}")
"""File names on every system: no separators, no leading dot or dash."""

_RESERVED = {"results"}


def check_names(names: Iterable[object]) -> None:
    """Refuses names of scenes that are no file names, or that some systems hold to be the same."""
    seen: Dict[str, str] = {}
    for name in names:
        if not isinstance(name, str) or not _NAME.fullmatch(name) or name.endswith("."):
            raise Error(
                f"scene {name!r}: found a name that is no file name, expected letters, digits and "
                "._,=+- (at most 200, the first a letter, a digit or _); rename the scene"
            )
        folded = name.lower()
        if folded in _RESERVED:
            raise Error(f"scene {name!r}: the name is reserved for the table; rename the scene")
        if folded in seen:
            raise Error(
                f"scenes {seen[folded]!r} and {name!r}: found names that differ in case alone, "
                "expected different file names; rename one"
            )
        seen[folded] = name


def read(path: Path) -> bytes:
    with open(path, "rb") as file:
        return file.read()


def make_folder(path: Path) -> str:
    """Makes a folder where there is none, and gives its absolute path."""
    try:
        os.makedirs(path, exist_ok=True)
    except FileExistsError:
        raise Error(
            f"{os.fspath(path)}: found a file, expected a folder; choose another place"
        ) from None
    return os.path.abspath(path)


def check_made_of(path: Path, made_of: Mapping[str, Any]) -> None:
    """Refuses to mix results of different calls; the file says what those there are made of."""
    if not os.path.exists(path):
        write(path, json.dumps(made_of, indent=1).encode())
        return
    found = json.loads(read(path))
    for what, value in made_of.items():
        if found.get(what) != value:
            raise Error(
                f"{os.fspath(path)}: found results of other {what}, expected those of this call; "
                "choose another folder, or delete this one"
            )


def everywhere(path: Path) -> str:
    """A path that means the same on nodes, which have other working folders; else as it is, such
    as ``builtin``."""
    return os.path.abspath(path) if os.path.exists(path) else os.fspath(path)
