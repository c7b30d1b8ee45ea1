"""Rows of a long run as they come: Parquet parts written whole, so that a run that ends anywhere goes on from there.

A part holds the rows of one range of numbers and is named by it, `rows-START-STOP.parquet`; what is missing is what the
names leave out. When all are there they become one Parquet file, each row once and in order, the same to the last byte
however the run was cut, resumed and shared out. Needs pyarrow (the extra `parquet`).
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from hashlib import sha256
from itertools import chain
from pathlib import Path
from typing import Any, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import CamgeomError, Problem, ProfileError, not_installed
from camgeom.immutable import immutable

MANIFEST = "run.json"
GROUP = 65_536
"""rows of a row group of the whole file"""
LAST = ("verdict", "reason")
"""columns that stand behind the figures"""

Column = Sequence[Any] | npt.NDArray[np.generic]
"""numbers, truths or words; None in a list where a row has none"""


@final
@immutable(eq=True)
class Parts:
    """The rows of one run on their way into a Parquet file.

    path       the whole file; its parts are kept in a folder beside it until all rows are there
    described  all that the rows rest on, as plain data by name: parts of another run are refused by what differs
    total      rows of the whole run
    """

    path: Path
    described: Mapping[str, Any]
    total: int

    def __post_init__(self) -> None:
        if self.complete:
            return
        mine, theirs = self._digests(), _noted(self.folder / MANIFEST)
        if theirs is None:
            self._note(mine)
        elif theirs != mine:
            unlike = ", ".join(sorted(name for name in mine.keys() | theirs if mine.get(name) != theirs.get(name)))
            text = f"holds the rows of another run, which differs in: {unlike}"
            raise ProfileError([Problem(str(self.folder), text, None, "", "delete it or choose another folder")])

    @property
    def folder(self) -> Path:
        """Where the parts are."""
        return self.path.with_suffix(".parts")

    @property
    def complete(self) -> bool:
        """Whether the whole file is there and holds just this run."""
        arrow = pyarrow()
        if not self.path.is_file():
            return False
        try:
            metadata = arrow.parquet.read_schema(self.path).metadata or {}
        except arrow.ArrowInvalid:
            return False
        return bool(metadata.get(b"camgeom") == json.dumps(self._digests()).encode())

    def _digests(self) -> dict[str, str]:
        """A digest of everything described, by name."""
        plain = {**self.described, "rows": self.total}
        return {name: sha256(json.dumps(value, sort_keys=True).encode()).hexdigest() for name, value in plain.items()}

    def _note(self, digests: Mapping[str, str]) -> None:
        from camgeom.export.files import write_whole

        write_whole(self.folder / MANIFEST, json.dumps(digests, indent=1))

    @property
    def written(self) -> list[range]:
        """Ranges of the parts that are there, in order."""
        names = (re.fullmatch(r"rows-(\d+)-(\d+)\.parquet", file.name) for file in self.folder.iterdir())
        return sorted((range(int(n[1]), int(n[2])) for n in names if n), key=lambda one: (one.start, one.stop))

    @property
    def gaps(self) -> list[range]:
        """Ranges of the rows that are still to be computed."""
        if self.complete:
            return []
        found, at = [], 0
        for one in self.written:
            if one.start > at:
                found.append(range(at, one.start))
            at = max(at, one.stop)
        return [*found, range(at, self.total)] if at < self.total else found

    def write(self, piece: range, columns: Mapping[str, Column]) -> None:
        """The rows of a range as a part. Raises ExportError where it cannot be written; earlier parts stand."""
        from camgeom.export.files import atomic_write

        with atomic_write(self._part(piece)) as stream:
            table = _table(columns)
            listed = [one.name for one in table.schema if not pyarrow().types.is_floating(one.type)]
            # To compress a part and back again takes longer than to write and read it.
            pyarrow().parquet.write_table(table, stream, use_dictionary=listed, compression="none")

    def _part(self, piece: range) -> Path:
        return self.folder / f"rows-{piece.start:09d}-{piece.stop:09d}.parquet"

    def join(self, path: Path | None = None) -> Path:
        """The whole file, each row once and in order; the parts are removed, unless it is written to another `path`.

        Raises ExportError where it cannot be written, CamgeomError where rows are missing; the parts then stand.
        """
        from camgeom.export.files import atomic_write

        arrow = pyarrow()
        if self.complete:
            return self.path
        if self.gaps:
            raise CamgeomError(f"{self.folder}: rows are missing; run the same command again")
        schema = self._schema().with_metadata({"camgeom": json.dumps(self._digests())})
        groups = _grouped(self._tables(schema))
        first = next(groups, schema.empty_table())
        unlike = _unlike(first)
        alike = [name for name in schema.names if name not in unlike]
        packed = {name: "none" if name in unlike else "snappy" for name in schema.names}
        with atomic_write(path or self.path) as stream, arrow.parquet.ParquetWriter(
            stream, schema, use_dictionary=alike, compression=packed
        ) as writer:
            for table in chain([first], groups):
                writer.write_table(table, GROUP)
        if path is not None:
            return path
        self.clear()
        return self.path

    def clear(self) -> None:
        """Remove the parts, the whole file being in its place."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def _schema(self) -> Any:
        """Columns of all parts in the order of their first rows; a column takes the widest type that it has in any."""
        arrow = pyarrow()
        columns: dict[str, Any] = {}
        for piece in self.written:
            for one in arrow.parquet.read_schema(self._part(piece)):
                columns[one.name] = _wider(columns.get(one.name, one.type), one.type)
        names = [*(name for name in columns if name not in LAST), *(name for name in LAST if name in columns)]
        return arrow.schema([(name, columns[name]) for name in names])

    def _tables(self, schema: Any) -> Iterator[Any]:
        """The parts in order with all columns; rows that two runs at once have written twice are taken once."""
        arrow, at = pyarrow(), 0
        for piece in self.written:
            if piece.stop <= at:
                continue
            table = arrow.parquet.ParquetFile(self._part(piece)).read()
            if table.num_rows != len(piece):
                text = f"holds {table.num_rows} rows and not {len(piece)}; delete it and run the same command again"
                raise CamgeomError(f"{self._part(piece)}: {text}")
            table = table.slice(max(at - piece.start, 0))
            at, empty = piece.stop, arrow.nulls(table.num_rows)
            columns = [table[one.name] if one.name in table.column_names else empty for one in schema]
            yield arrow.table([c.cast(one.type, safe=False) for c, one in zip(columns, schema)], schema=schema)


def read_rows(path: Path, names: Iterable[str] | None = None) -> list[dict[str, Any]]:
    """The rows of a Parquet file as records, of the columns of these names that it has; default all."""
    file = pyarrow().parquet.ParquetFile(path)
    wanted = None if names is None else [name for name in file.schema_arrow.names if name in set(names)]
    records: list[dict[str, Any]] = file.read(wanted).to_pylist()
    return records


def pyarrow() -> Any:
    """The library, imported when rows are asked for as Parquet. Raises ExportError where it is absent."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise not_installed("Parquet", "pyarrow", "parquet") from None
    return pyarrow


def _noted(manifest: Path) -> dict[str, str] | None:
    """The digests of the run whose parts are there, None where there is none."""
    try:
        found: dict[str, str] = json.loads(manifest.read_bytes())
    except FileNotFoundError:
        return None
    except ValueError:
        raise CamgeomError(f"{manifest}: is not of this program; delete its folder or choose another") from None
    return found


def _table(columns: Mapping[str, Column]) -> Any:
    arrow = pyarrow()
    return arrow.table({name: _array(column) for name, column in columns.items()})


def _unlike(table: Any) -> set[str]:
    """Columns of numbers of which hardly two are alike: to keep each value once, or to compress them, takes three times
    as long as to write them, and leaves them as long as they are."""
    floats = [one.name for one in table.schema if pyarrow().types.is_floating(one.type)]
    return {name for name in floats if 2 * len(np.unique(table[name].to_numpy())) > table.num_rows}


def _array(column: Column) -> Any:
    """A column of one type: truths, whole numbers of 64 bits, floating-point numbers, or words where any is one."""
    arrow = pyarrow()
    if isinstance(column, np.ndarray):
        endless = ~np.isfinite(column) if column.dtype.kind == "f" else None
        return arrow.array(column, mask=endless)
    kinds = {type(value) for value in column} - {type(None)}
    if str in kinds:
        return arrow.array([None if value is None else str(value) for value in column], arrow.string())
    if kinds == {bool}:
        return arrow.array(column, arrow.bool_())
    if kinds == {int} and all(value is None or abs(value) < 2**63 for value in column):
        return arrow.array(column, arrow.int64())
    if not kinds:
        return arrow.nulls(len(column))
    return arrow.array([None if value is None else float(value) for value in column], arrow.float64())


def _wider(one: Any, other: Any) -> Any:
    """The type that holds both."""
    arrow = pyarrow()
    for kind in (arrow.string(), arrow.float64()):
        if kind in (one, other):
            return kind
    if arrow.types.is_null(one) or one == other:
        return other
    return one if arrow.types.is_null(other) else arrow.float64()


def _grouped(tables: Iterator[Any]) -> Iterator[Any]:
    """The same rows in tables of `GROUP`, so that the file does not tell where the parts ended."""
    arrow = pyarrow()
    held: list[Any] = []
    rows = 0
    for table in tables:
        held.append(table)
        rows += table.num_rows
        while rows >= GROUP:
            whole = arrow.concat_tables(held)
            yield whole.slice(0, GROUP).combine_chunks()
            held, rows = [whole.slice(GROUP)], rows - GROUP
    if rows:
        yield arrow.concat_tables(held).combine_chunks()
