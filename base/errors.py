"""The error of the datasets package."""

from navtool.base.navtool_error import NavtoolError


class DatasetsError(NavtoolError):
    """A recording, a topic map or a data set cannot be used as it is."""


class OutputError(DatasetsError):
    """The output cannot be written: no input's fault, so the work ends."""
