"""The error of the export package."""

from navtool.pipeline.errors import NavtoolError


class ExportError(NavtoolError):
    """An artefact cannot be made or trusted."""
