"""What a stranger installs: the wheel, with the newest and the lowest versions that it allows, through every verb.

``make test-wheel`` runs it. Each environment is made anew; the bags are simulated with the wheel itself.
"""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / ".wheel"
EXTRAS = ("train", "sim")
RESOLUTIONS = ("highest", "lowest-direct")
NEEDED = {  # how the verbs are called that need an extra, and which
    "train": ("train", "--data", "dataset", "--out", "run"),
    "evaluate": ("evaluate", "run"),
    "export": ("export", "run", "--out", "artefact"),
    "verify": ("verify", "artefact"),
    "simulate": ("simulate", "--out", "more"),
}
UNWANTED = ("Traceback", "Warning:")


class ChainError(Exception):
    """A verb did not do what it should."""


def main(uv: str) -> None:
    """Try every combination; the first that fails ends it."""
    shutil.rmtree(FOLDER, ignore_errors=True)
    _run(uv, "build", "--quiet", "--wheel", "--out-dir", FOLDER / "dist", ROOT)
    (wheel,) = (FOLDER / "dist").glob("*.whl")
    shutil.rmtree(ROOT / "build", ignore_errors=True)
    for resolution in RESOLUTIONS:
        whole = _installed(uv, wheel, resolution, EXTRAS)
        base = _installed(uv, wheel, resolution, ())
        work = FOLDER / f"{resolution}-work"
        work.mkdir()
        _chain(whole, work)
        _base(base, work)
        print(f"{resolution}: every verb works", flush=True)


def _installed(uv: str, wheel: Path, resolution: str, extras: Sequence[str]) -> Path:
    """The command line of a new environment with the wheel and what it asks for."""
    environment = FOLDER / f"{resolution}-{'-'.join(extras) or 'base'}"
    python = environment / "bin" / "python"
    wanted = [part for extra in extras for part in ("--extra", extra)]
    _run(uv, "venv", "--quiet", "--python", sys.executable, environment)
    # What the wheel asks for has to be asked for directly, else only the wheel itself is the lowest.
    install = (uv, "pip", "install", "--quiet", "--python", python)
    _run(*install, "--resolution", resolution, "-r", ROOT / "pyproject.toml", *wanted)
    _run(*install, "--no-deps", wheel)
    return environment / "bin" / "navtool"


def _chain(navtool: Path, work: Path) -> None:
    """From nothing to a verified artefact."""
    drive = ("scenario=demo", "drive.duration_s=12", "episodes_per_place=1", "--episodes", "3")
    _verb(navtool, work, "simulate", *drive, "--out", "bags")
    _verb(navtool, work, "inspect", _recording(work))
    _verb(navtool, work, "ingest", "bags", "--out", "dataset", "place='{parent}'", "fps=2")
    _verb(navtool, work, "label", "dataset")
    _verb(navtool, work, "check", "dataset")
    _verb(navtool, work, "intensity-map", _recording(work), "--out", "maps")
    small = ("experiment=demo", "trainer.epochs=1", "trainer.batch_size=8")
    _verb(navtool, work, "train", "--data", "dataset", "--out", "run", *small)
    _verb(navtool, work, "check", "dataset", "--splits", "run/lineage.json")
    _verb(navtool, work, "evaluate", "run")
    _verb(navtool, work, "export", "run", "--out", "artefact")
    _verb(navtool, work, "verify", "artefact")


def _base(navtool: Path, work: Path) -> None:
    """What works without extras does; every other verb names its extra as the cure."""
    _verb(navtool, work, "inspect", _recording(work))
    _verb(navtool, work, "ingest", "bags", "--out", "dataset-base", "place='{parent}'", "fps=2")
    _verb(navtool, work, "label", "dataset-base")
    _verb(navtool, work, "check", "dataset-base")
    _verb(navtool, work, "intensity-map", _recording(work), "--out", "maps-base")
    for verb, call in NEEDED.items():
        done = _called(navtool, work, *call)
        extra = "sim" if verb == "simulate" else "train"
        lines = done.stderr.strip().splitlines()
        if done.returncode == 0 or len(lines) != 2 or lines[1].strip() != f"cure: pip install 'navtool[{extra}]'":
            raise ChainError(f"{navtool} {verb} does not name its extra:\n{done.stderr}")


def _recording(work: Path) -> str:
    return str(sorted((work / "bags").rglob("*.mcap"))[0])


def _verb(navtool: Path, work: Path, *call: str) -> None:
    begun = time.monotonic()
    done = _called(navtool, work, *call)
    told = done.stdout + done.stderr
    if done.returncode or any(word in told for word in UNWANTED):
        raise ChainError(f"{navtool} {' '.join(call)}: exit code {done.returncode}\n{told}")
    print(f"{navtool.parents[1].name}: {call[0]} {time.monotonic() - begun:.1f} s", flush=True)


def _called(navtool: Path, work: Path, *call: str) -> subprocess.CompletedProcess[str]:
    # nothing of this checkout is to be found in the place of what is installed
    around = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    return subprocess.run((navtool, *call), cwd=work, env=around, capture_output=True, text=True, check=False)


def _run(*call: str | Path) -> None:
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ChainError(f"{' '.join(map(str, call))}\n{done.stdout}{done.stderr}")


if __name__ == "__main__":
    try:
        main(*sys.argv[1:])
    except ChainError as failed:
        sys.exit(f"failed: {failed}")
