"""The lines of an events file, CSV or JSON, as mappings with exactly the known columns."""

import csv
import io
import json
from collections.abc import Iterator, Mapping
from decimal import Decimal
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.base.from_plain import did_you_mean

COLUMNS = ("bag", "start", "end", "outcome", "reason")


def event_records(path: Path, faults: list[str]) -> Iterator[tuple[str, Mapping[str, object]]]:
    """Each line's place in the file and its fields, in order; faulty lines are added to ``faults`` and left out.

    Raises:
        DatasetsError: If the file cannot be read, is neither CSV nor JSON, or has another header.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise DatasetsError(
            f"cannot be read ({error.strerror})", where=path, cure="check the path of the events file"
        ) from error
    except UnicodeDecodeError as error:
        raise DatasetsError("is not UTF-8 text", where=path, cure="save the file as UTF-8") from error
    if path.suffix.lower() == ".csv":
        return _csv_records(path, text, faults)
    if path.suffix.lower() == ".json":
        return _json_records(path, text, faults)
    raise DatasetsError("is neither .csv nor .json", where=path, cure="name the file by its format")


def _csv_records(path: Path, text: str, faults: list[str]) -> Iterator[tuple[str, Mapping[str, object]]]:
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    header: list[str] | None = None
    try:
        for cells in reader:
            line = f"line {reader.line_num}"
            stripped = [cell.strip() for cell in cells]
            if not any(stripped):
                continue
            if header is None:
                header = stripped
                _check_header(path, header)
            elif len(cells) != len(header):
                faults.append(f"{line}: {len(cells)} values under {len(header)} columns (quote a text that has commas)")
            else:
                yield line, dict(zip(header, stripped, strict=True))
    except csv.Error as error:
        faults.append(f"line {reader.line_num}: {error}")
    if header is None:
        raise DatasetsError("is empty", where=path, cure=f"start it with the header {','.join(COLUMNS)}")


def _check_header(path: Path, header: list[str]) -> None:
    if sorted(header) == sorted(COLUMNS):
        return
    unknown = [f"{name!r}{did_you_mean(name, COLUMNS)}" for name in header if name not in COLUMNS]
    missing = [name for name in COLUMNS if name not in header]
    repeated = sorted({name for name in header if header.count(name) > 1})
    parts = [
        f"{what} {', '.join(names)}"
        for what, names in (("unknown column", unknown), ("missing", missing), ("repeated", repeated))
        if names
    ]
    raise DatasetsError(
        f"line 1: {'; '.join(parts)}", where=path, cure=f"the header is {','.join(COLUMNS)}, separated by commas"
    )


def _json_records(path: Path, text: str, faults: list[str]) -> Iterator[tuple[str, Mapping[str, object]]]:
    def whole(pairs: list[tuple[str, object]]) -> dict[str, object]:
        names = [name for name, _ in pairs]
        if len(set(names)) < len(names):
            raise ValueError(f"a key is repeated in {names}")
        return dict(pairs)

    try:
        content = json.loads(text, parse_float=Decimal, object_pairs_hook=whole)
    except ValueError as error:
        raise DatasetsError(f"is not JSON ({error})", where=path, cure="correct the file's syntax") from error
    if not isinstance(content, list):
        raise DatasetsError("is not a list", where=path, cure="write a list of objects, one an event")
    for number, entry in enumerate(content, start=1):
        line = f"entry {number}"
        if not isinstance(entry, dict):
            faults.append(f"{line}: is not an object")
        elif set(entry) != set(COLUMNS):
            unknown = [f"{name!r}{did_you_mean(name, COLUMNS)}" for name in sorted(set(entry) - set(COLUMNS))]
            missing = sorted(set(COLUMNS) - set(entry))
            parts = [f"{what} {', '.join(n)}" for what, n in (("unknown key", unknown), ("missing", missing)) if n]
            faults.append(f"{line}: {'; '.join(parts)}")
        else:
            yield line, entry
