"""Runs the benchmarks, each in a process of its own: ``python -m benchmarks [NAME]``."""

import subprocess
import sys
from pathlib import Path

BENCHMARKS = {
    "help": "help.py",
    "agnn": "agnn.py",
    "reliability": "reliability.py",
    "cloud_features": "cloud_reliability_auc.py",
    "mim": "mim.py",
    "ingest": "ingest.py",
    "reads": "reads.py",
    "relabel": "relabel.py",
    "sim": "sim.py",
    "legged": "legged.py",
}


def main() -> int:
    """Run one or all; a missed bar is a figure, not a failure."""
    wanted = sys.argv[1:] or list(BENCHMARKS)
    unknown = [name for name in wanted if name not in BENCHMARKS]
    if unknown:
        print(f"unknown benchmark {', '.join(unknown)}; known are {', '.join(BENCHMARKS)}", file=sys.stderr)
        return 2
    folder = Path(__file__).parent
    commands = [[sys.executable, str(folder / BENCHMARKS[name])] for name in wanted]
    return max(subprocess.run(command, check=False).returncode for command in commands)  # noqa: S603


if __name__ == "__main__":
    sys.exit(main())
