"""What ``labels.json`` says of a data set whose episodes were labelled in others."""

from collections import Counter
from collections.abc import Sequence

from navtool.base.errors import DatasetsError
from navtool.base.files import read_json
from navtool.datasets.labels.report import LabelReport
from navtool.datasets.store.reader import NavDataset

_MADE_WITH = ("schema_version", "config", "config_hash", "code_version")
_COUNTED = ("episodes", "rows", "failed_rows", "known_steps", "all_steps", "negatives", "reasons")
_REBUILD = "run `navtool label` on it again"


def joint_summary(chosen: Sequence[tuple[NavDataset, slice]]) -> dict[str, object] | None:
    """How the labels of these rows were made, and what they are; None where they were not made.

    What each rule said of its episodes, and the notes, stay in the data sets that were labelled.

    Raises:
        DatasetsError: The data sets were labelled with other settings, or some of them were not.
    """
    datasets = list(dict.fromkeys(dataset for dataset, _ in chosen))
    made = [_made(dataset) for dataset in datasets]
    if all(found is None for found in made):
        return None
    if len({None if found is None else found["config_hash"] for found in made}) > 1:
        where = ", ".join(str(dataset.root) for dataset in datasets)
        raise DatasetsError("labelled with other settings", where=where, cure="run `navtool label` on each alike first")
    first = made[0] or {}
    events = [found["events"] for found in made if found is not None and found.get("events")]
    return {
        **{key: first[key] for key in _MADE_WITH if key in first},
        **_counts(chosen),
        "events": events[0] if len(events) == 1 else events or None,
    }


def _made(dataset: NavDataset) -> dict[str, object] | None:
    path = dataset.layout.beside / "labels.json"
    return read_json(path, _REBUILD) if path.is_file() else None


def _counts(chosen: Sequence[tuple[NavDataset, slice]]) -> dict[str, object]:
    report = LabelReport(dataset="", episodes=len(chosen), rows=sum(rows.stop - rows.start for _, rows in chosen))
    for dataset, rows in chosen:
        report.add_rows(dataset.column("label.outcome")[rows], dataset.column("label.known")[rows])
        report.add_reasons(Counter(dataset.column("label.reason")[rows].tolist()))
    return {key: value for key, value in report.to_json().items() if key in _COUNTED}
