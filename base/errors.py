"""The root of every error that navtool raises for bad input, and those that every command may meet."""


class NavtoolError(Exception):
    """Bad input, in words by which the user can mend it: what is wrong, where, and the cure.

    Each package derives one class from it; the command line turns all of them into one message and an exit code.

    Attributes:
        what: What is wrong, with the value and its unit where there is one.
        where: The file, topic, key or field that is at fault; None where there is no such place.
        cure: What the user can do about it; None where nothing is known.
    """

    def __init__(self, what: str, *, where: object = None, cure: str | None = None) -> None:
        self.what = what
        self.where = None if where is None else str(where)
        self.cure = cure
        head = what if self.where is None else f"{self.where}: {what}"
        super().__init__(head if cure is None else f"{head}\n  cure: {cure}")

    def __reduce__(self) -> tuple[object, ...]:
        """Cross process boundaries whole: the keyword arguments travel as state."""
        return (_rebuild, (type(self), self.what, self.where, self.cure))


class DatasetsError(NavtoolError):
    """An input cannot be used as it is: a file, a folder, a recording, a data set."""


class OccupiedError(DatasetsError):
    """Where the output is to go lies something else, or the same of other settings: a wrong call, no input's fault."""


class OutputError(DatasetsError):
    """The output cannot be written: no input's fault, so the work ends."""


def _rebuild(cls: type[NavtoolError], what: str, where: str | None, cure: str | None) -> NavtoolError:
    return cls(what, where=where, cure=cure)
