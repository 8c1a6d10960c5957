"""Is this data set whole and plausible? Every finding says what, where and how bad."""

from navtool.datasets.check.findings import CheckReport, Finding, Severity
from navtool.datasets.check.run import check_dataset

__all__ = ["CheckReport", "Finding", "Severity", "check_dataset"]
