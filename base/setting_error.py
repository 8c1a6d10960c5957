"""What a dataclass of settings says of values that it refuses, by the keys that a user writes."""

from collections.abc import Iterable
from typing import NamedTuple

from navtool.base.errors import NavtoolError


class Fault(NamedTuple):
    """What is wrong with one setting."""

    key: str
    """Dotted, as called in the dataclass that was built; empty where no one setting of it is at fault."""
    what: str
    """The value with its unit, and what it has to be."""
    cure: str | None = None
    """What the user can do about it, where the fault does not say it."""


class SettingError(NavtoolError):
    """Settings that cannot be used, from Python, a YAML file or the command line.

    Attributes:
        faults: Every fault that was found, one at least.
        file: The file that the settings come from; None where they come from none.
    """

    def __init__(self, *faults: Fault, file: object = None, cure: str | None = None) -> None:
        """Faults that are said together.

        Args:
            faults: One at least.
            file: The file that the settings come from.
            cure: What the user can do where a fault does not say it.
        """
        self.faults = faults
        self.file = None if file is None else str(file)
        self._cure = cure
        if len(faults) > 1:
            super().__init__("; ".join(map(_with_cure, faults)), where=self.file, cure=cure)
            return
        (fault,) = faults
        cure = fault.cure or cure
        if self.file is None:
            super().__init__(fault.what, where=fault.key or None, cure=cure)
        else:
            super().__init__(_named(fault), where=self.file, cure=cure)

    def __reduce__(self) -> tuple[object, ...]:
        """Cross process boundaries whole."""
        return (_rebuild, (self.faults, self.file, self._cure))

    def below(self, group: str) -> "SettingError":
        """The same of a dataclass that is called so by the one that it is part of."""
        faults = (fault._replace(key=dotted(group, fault.key)) for fault in self.faults)
        return SettingError(*faults, file=self.file, cure=self._cure)


def dotted(group: str, key: str) -> str:
    """The key of a group's setting as it is called from outside the group; either may be empty."""
    return ".".join(part for part in (group, key) if part)


def refuse(*checks: Iterable[Fault]) -> None:
    """Refuse a dataclass's values if a check of it found a fault.

    Raises:
        SettingError: One did; it names the faults of all checks.
    """
    faults = [fault for check in checks for fault in check]
    if faults:
        raise SettingError(*faults)


def _named(fault: Fault) -> str:
    return f"{fault.key}: {fault.what}" if fault.key else fault.what


def _with_cure(fault: Fault) -> str:
    return f"{_named(fault)} ({fault.cure})" if fault.cure else _named(fault)


def _rebuild(faults: tuple[Fault, ...], file: str | None, cure: str | None) -> SettingError:
    return SettingError(*faults, file=file, cure=cure)
