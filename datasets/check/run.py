"""All checks, one after the other."""

from collections.abc import Callable
from pathlib import Path

from navtool.datasets.check.content import check_clouds, check_streams, check_values, check_video
from navtool.datasets.check.files import check_counters, check_files, check_metadata
from navtool.datasets.check.findings import CheckReport, Finding, Findings, Severity
from navtool.datasets.check.judgement import check_calibrations, check_labels, check_leakage
from navtool.datasets.check.native import check_native
from navtool.datasets.errors import DatasetsError
from navtool.datasets.reader import NavDataset

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
}
"""By the names under which they are reported."""


def check_dataset(root: Path, progress: Callable[[str], None] | None = None) -> CheckReport:
    """Look at everything in a data set, down to the last row, frame and footer.

    Nothing is changed. Damage is reported as a finding; only a folder that is no data set of ours raises.

    Args:
        progress: Called with the name of each check as it begins.

    Raises:
        DatasetsError: If there is no data set of this schema version here.
    """
    report = CheckReport(str(root))
    try:
        dataset = NavDataset(root, verify=True)
    except DatasetsError as error:
        if error.where == str(root):
            raise
        report.checks.append("metadata")
        report.findings.append(Finding(Severity.FAIL, "metadata", str(error.where), error.what))
        return report
    report.episodes, report.rows = len(dataset.episodes), len(dataset)
    for name, check in CHECKS.items():
        if progress is not None:
            progress(name)
        report.checks.append(name)
        try:
            report.findings += [Finding(severity, name, where, what) for severity, where, what in check(dataset)]
        except DatasetsError as error:
            report.findings.append(Finding(Severity.FAIL, name, str(error.where), error.what))
    return report
