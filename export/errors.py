"""The error of the export package."""

from navtool.base.errors import NavtoolError


class ExportError(NavtoolError):
    """An artefact cannot be made or trusted."""
