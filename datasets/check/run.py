"""All checks, one after the other."""

from collections.abc import Callable
from pathlib import Path

import pyarrow as pa

from navtool.base.errors import DatasetsError
from navtool.base.progress import Progress, Silent
from navtool.datasets.check.content import check_clouds, check_streams, check_values, check_video
from navtool.datasets.check.files import check_counters, check_files, check_metadata
from navtool.datasets.check.findings import CheckReport, Finding, Findings, Severity, first_line
from navtool.datasets.check.judgement import check_calibrations, check_labels, check_leakage
from navtool.datasets.check.native import check_native
from navtool.datasets.check.splits import check_own_splits, check_splits, read_splits, told_splits
from navtool.datasets.store.reader import NavDataset

CHECKS: dict[str, Callable[[NavDataset], Findings]] = {
    "metadata": check_metadata,
    "files": check_files,
    "counters": check_counters,
    "values": check_values,
    "clouds": check_clouds,
    "video": check_video,
    "streams": check_streams,
    "native": check_native,
    "labels": check_labels,
    "calibration": check_calibrations,
    "leakage": check_leakage,
    "splits": check_own_splits,
}
"""By the names under which they are reported."""


_DAMAGE = (ArithmeticError, LookupError, TypeError, ValueError, OSError, pa.ArrowException)
"""What libraries answer values of other types, shapes and numbers with than the data set's own."""


def check_dataset(root: Path, *, splits: Path | None = None, progress: Progress | None = None) -> CheckReport:
    """Look at everything in a data set, down to the last row, frame and footer.

    Nothing is changed. Damage is reported as a finding; only a folder that is no data set of ours raises.

    Args:
        splits: A file that names splits of the data set, such as a run's ``lineage.json``; they are looked at too.
        progress: Learns how many checks are done.

    Raises:
        DatasetsError: If there is no data set of this schema version here, or the file names no splits.
    """
    report = CheckReport(str(root))
    named = None if splits is None else read_splits(splits)
    try:
        dataset = NavDataset(root, verify=True)
    except DatasetsError as error:
        if error.where == str(root):
            raise
        report.checks.append("metadata")
        report.findings.append(Finding(Severity.FAIL, "metadata", str(error.where), error.what))
        return report
    report.episodes, report.rows = len(dataset.episodes), len(dataset)
    checks = CHECKS
    if named is not None:
        report.splits = told_splits(dataset, named)
        checks = CHECKS | {"named splits": lambda opened: check_splits(opened, named, str(splits))}
    shown = progress or Silent()
    shown.begin(len(checks), len(checks))
    for name, check in checks.items():
        report.checks.append(name)
        try:
            for severity, where, what in check(dataset):
                report.findings.append(Finding(severity, name, where, what))
        except DatasetsError as error:
            report.findings.append(Finding(Severity.FAIL, name, str(error.where), error.what))
        except _DAMAGE as error:
            what = f"cannot be looked at: {type(error).__name__}: {first_line(error)}"
            report.findings.append(Finding(Severity.FAIL, name, str(root), what))
        shown.advance(1, 0)
        shown.done(len(report.checks), name)
    return report
