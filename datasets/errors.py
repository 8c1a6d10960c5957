"""The error of the datasets package."""

from navtool.pipeline.errors import NavtoolError


class DatasetsError(NavtoolError):
    """A recording, a topic map or a data set cannot be used as it is."""
