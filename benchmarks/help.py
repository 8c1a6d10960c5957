"""How long a user waits for ``navtool --help``: the whole process, against Python's own start."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from _report import Row, median_seconds, write_report

BAR_S = 0.3


def main() -> None:
    """Time both in turn."""
    command = [str(Path(sys.executable).with_name("navtool")), "--help"]
    ours, peer = median_seconds(_run(command), _run([sys.executable, "-c", "pass"]), rounds=5)
    row = Row(what="navtool --help", ours=ours, peer=peer, ratio=ours / peer, unit="s", bar=BAR_S, holds=ours <= BAR_S)
    write_report("help", [row])


def _run(command: list[str]) -> Callable[[], object]:
    return lambda: subprocess.run(command, check=True, capture_output=True)  # noqa: S603


if __name__ == "__main__":
    main()
