"""Results: a row each, as CSV, Parquet or pandas."""

from __future__ import annotations

import csv
import importlib
import io
from typing import Any, Dict, Iterator, List, Sequence

from pocketnerf import Error

from . import files

Row = Dict[str, Any]

TEXTS = {"name", "status", "error", "node", "split", "worst_view", "warnings", "options"}
"""Columns that stay text, even where a value looks like a number."""


class Table:
    """Rows of results: dictionaries of numbers, texts and None, in the order of the tasks.

    >>> table = Table([{"name": "a", "psnr": 30.5}, {"name": "b", "psnr": 31.0}])
    >>> len(table), table.columns, table.best("psnr")["name"]
    (2, ['name', 'psnr'], 'b')
    """

    def __init__(self, rows: Sequence[Row]) -> None:
        self.rows: List[Row] = list(rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def __getitem__(self, index: int) -> Row:
        return self.rows[index]

    def __repr__(self) -> str:
        failed = len(self.failed)
        return f"<Table: {len(self)} rows{f', {failed} with errors' if failed else ''}>"

    @property
    def columns(self) -> List[str]:
        """Names of all columns, in the order of their first appearance."""
        return list(dict.fromkeys(column for row in self.rows for column in row))

    @property
    def failed(self) -> List[Row]:
        """Rows with an error."""
        return [row for row in self.rows if row.get("error")]

    def best(self, column: str, *, least: bool = False) -> Row:
        """The row with the most of a figure, or with the least; rows without it do not count."""
        rows = [row for row in self.rows if isinstance(row.get(column), (int, float))]
        if not rows:
            raise Error(
                f"column {column!r}: found no numbers, expected one of {', '.join(self.columns)}"
            )
        return (min if least else max)(rows, key=lambda row: row[column])

    def to_csv(self, path: files.Path) -> None:
        """Writes a CSV file with a header. None is an empty cell."""
        text = io.StringIO(newline="")
        writer = csv.DictWriter(text, self.columns, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(self.rows)
        files.write(path, text.getvalue().encode())

    def to_parquet(self, path: files.Path) -> None:
        """Writes a Parquet file; needs pyarrow."""
        try:
            arrow = importlib.import_module("pyarrow")
            parquet = importlib.import_module("pyarrow.parquet")
        except ImportError as error:
            raise ImportError("Table.to_parquet needs pyarrow: pip install pyarrow") from error
        columns = {name: [row.get(name) for row in self.rows] for name in self.columns}
        buffer = io.BytesIO()
        parquet.write_table(arrow.table(columns), buffer)
        files.write(path, buffer.getvalue())

    def to_pandas(self) -> Any:
        """A pandas.DataFrame; needs pandas."""
        try:
            pandas = importlib.import_module("pandas")
        except ImportError as error:
            raise ImportError("Table.to_pandas needs pandas: pip install pandas") from error
        return pandas.DataFrame(self.rows, columns=self.columns)

    @staticmethod
    def read_csv(path: files.Path) -> Table:
        """Reads what ``to_csv`` writes."""
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        return Table([{key: value(key, text) for key, text in row.items()} for row in rows])


def value(column: str, text: str) -> Any:
    if text == "":
        return None
    if column not in TEXTS:
        for kind in (int, float):
            try:
                return kind(text)
            except ValueError:
                pass
    return text
