"""A report as plain values."""

from navtool.base.lineage import plain


def fields_of(report: object) -> dict[str, object]:
    """The fields of a report as plain values."""
    found = plain(report)
    return found if isinstance(found, dict) else {}
