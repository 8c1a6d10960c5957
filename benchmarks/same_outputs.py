"""Do two versions of navtool write the same files? For changes that are to move code and no byte.

``python benchmarks/same_outputs.py --before CHECKOUT``: runs the same commands with the command line of another
checkout and with this one's, in the same folder one after the other, and compares every file and every ``--json``.
The version of the code is taken out of both, and what two runs of one version do not write alike is left out by name.
Exit code 1 where anything differs.
"""

import argparse
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DATA = Path(os.environ.get("NAVTOOL_DATA", ROOT.parent / "shared" / "data"))
VERSION = re.compile(rb"\+src\.[0-9a-f]{12}")
OF_THE_MOMENT = ("seconds", "peak_rss_mib", "maps_per_s", "samples_per_s", "data_wait_share", "digest", "model.ts")
"""Keys of JSON that differ between equal runs, and what hangs on them; of ``model.ts`` the tensors are compared."""
LEFT_OUT = re.compile(r"(^|/)(tensorboard|checkpoints|logs|\.hydra|journal|history\.csv|perf[^/]*)(/|$)|\.log$|\.ckpt$")
"""Files with times, or in a library's own format with its paths and dates."""

SIMULATED = [
    ("mcap", ["scenario=demo", "drive.duration_s=6", "drive.careful=0", "format=mcap"], 4),
    ("db3", ["scenario=graspe_1", "robot=quadruped", "drive.duration_s=3", "format=db3"], 1),
    ("plants", ["scenario=mim_2", "lidar.returns=dual", "drive.duration_s=4", "format=mcap"], 1),
    ("ros1", ["scenario=mim_1", "lidar.returns=dual", "drive.duration_s=3", "format=ros1"], 1),
]
SMALL_MODEL = ["experiment=demo", "trainer.epochs=1", "trainer.batch_size=8", "split.group_by=run", "seed=3"]


def steps() -> Iterator[tuple[str, list[str]]]:
    """Name and arguments of each command, in order; relative paths are below the working folder."""
    for name, settings, episodes in SIMULATED:
        yield f"simulate {name}", ["simulate", *settings, "--episodes", str(episodes), "--out", f"bags/{name}"]
        sheet = ["--preview", f"{name}.png", "--out", f"bags/{name}"]
        yield f"sheet {name}", ["simulate", *settings, "--episodes", str(episodes), *sheet]
        yield (
            f"ingest {name}",
            ["ingest", f"bags/{name}", "--out", f"sets/{name}", "place='{parent}'", "fps=5", "--json"],
        )
        yield f"label {name}", ["label", f"sets/{name}", "--json"]
        yield f"check {name}", ["check", f"sets/{name}", "--json"]
    for path in sorted((DATA / "bags").glob("*")):
        for recording in sorted(entry for entry in path.iterdir() if entry.suffix in {"", ".bag", ".mcap"}):
            name = f"{path.name}-{recording.name}"
            yield f"inspect {name}", ["inspect", str(recording), "--json"]
            yield (
                f"page {name}",
                ["inspect", str(recording), "--report", f"{name}.html", "--write-robot", f"{name}.yaml"],
            )
            yield f"ingest {name}", ["ingest", str(recording), "--out", f"sets/{name}", "--workers", "2", "--json"]
    yield "map of a bag", ["intensity-map", "bags/ros1/mim_1-test-0", "--out", "maps/bag", "sensor=simulated"]
    yield "map of an episode", ["intensity-map", "sets/ros1", "--out", "maps/episode", "--json"]
    jackal = DATA / "bags" / "jackal_velodyne_scan"
    yield "map of a scan", ["intensity-map", str(jackal), "--out", "maps/scan", "sensor=vlp16"]
    yield "fit", ["fit", "intensity_threshold", "bags/plants/mim_2-test-0", "--out", "fit", "--json"]
    yield "train", ["train", "--data", "sets/mcap", "--out", "run", *SMALL_MODEL]
    yield "evaluate", ["evaluate", "run", "--split", "all", "--json"]
    yield "export", ["export", "run", "--out", "artefact"]
    yield "verify", ["verify", "artefact"]


def write_all(navtool: Path, folder: Path) -> None:
    """Run every step in a new folder; what is printed as JSON, and each exit code, become files too."""
    folder.mkdir()
    for name, arguments in steps():
        command = [str(navtool), *arguments]
        # one thread: sums in another order are other sums
        settings = {**os.environ, "OMP_NUM_THREADS": "1", "COLUMNS": "200"}
        done = subprocess.run(command, cwd=folder, env=settings, capture_output=True, text=True, check=False)  # noqa: S603
        said = without_moment(json.loads(done.stdout)) if "--json" in arguments and done.stdout else None
        error = done.stderr if done.returncode else ""
        record = {"exit": done.returncode, "json": said, "error": error}
        printed = folder / "printed" / f"{name.replace(' ', '_')}.json"
        printed.parent.mkdir(exist_ok=True)
        printed.write_text(json.dumps(record, indent=1))
        print(f"  {name}: exit code {done.returncode}", flush=True)


def without_moment(value: object) -> object:
    """JSON without what differs between equal runs."""
    if isinstance(value, dict):
        return {key: without_moment(entry) for key, entry in value.items() if key not in OF_THE_MOMENT}
    return [without_moment(entry) for entry in value] if isinstance(value, list) else value


def hashes(folder: Path) -> dict[str, str]:
    """The SHA-256 of every file by its path, without the version of the code."""
    found: dict[str, str] = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_file() and not LEFT_OUT.search(name):
            found |= {name: _sha256(path)} if path.suffix != ".ts" else _tensors(path, name)
    return found


def _tensors(path: Path, name: str) -> dict[str, str]:
    """What a TorchScript archive holds beside its program, which names files and lines of the code it is from."""
    with zipfile.ZipFile(path) as archive:
        members = [member for member in archive.namelist() if re.search(r"/(data|constants)/|\.json$", member)]
        return {
            f"{name}:{member.partition('/')[2]}": hashlib.sha256(archive.read(member)).hexdigest() for member in members
        }


def _sha256(path: Path) -> str:
    content = VERSION.sub(b"+src.000000000000", path.read_bytes())
    if path.name in {"manifest.json", "metrics.json"}:
        content = json.dumps(without_moment(json.loads(content))).encode()
    return hashlib.sha256(content).hexdigest()


def main() -> int:
    """Compare, print what differs, and count."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--before", type=Path, required=True, help="a checkout with its .venv, such as of the last release"
    )
    parser.add_argument("--keep", type=Path, help="a new folder in which both outputs stay")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        base = chosen.keep or Path(made)
        base.mkdir(parents=True, exist_ok=True)
        work = base / "work"
        found: dict[str, dict[str, str]] = {}
        for name, checkout in (("before", chosen.before.resolve()), ("after", ROOT)):
            print(f"{name}: {checkout}")
            if checkout != (base / name).resolve():
                write_all(checkout / ".venv" / "bin" / "navtool", work)
                shutil.rmtree(base / name, ignore_errors=True)
                shutil.move(work, base / name)
            found[name] = hashes(base / name)
    names = sorted({*found["before"], *found["after"]})
    differ = [name for name in names if found["before"].get(name) != found["after"].get(name)]
    for name in differ:
        missing = [side for side in found if name not in found[side]]
        print(f"DIFFERS: {name}{f' (not there {missing[0]})' if missing else ''}")
    print(f"{len(names)} files and members compared, {len(differ)} differ")
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
