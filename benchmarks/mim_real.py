"""What passes for solid and for pliable in real clouds, and how far their intensities tell one from the other.

``python benchmarks/mim_real.py`` prints it and draws each cloud's layers beside the benchmarks' output; ``--docs``
writes docs/results/mim_real.json and mim_real.md, and the picture of the one cloud whose licence allows it.
"""

import argparse
import json
import textwrap
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace

import numpy as np
from _mim_results import DOCS, Result, told
from _real_clouds import RealCloud, real_clouds
from _report import OUT, machine
from numpy.typing import NDArray

from navtool.cli.compose import compose
from navtool.configs.intensity_map_job import IntensityMapJob
from navtool.methods.along.pictures import png_bytes
from navtool.methods.along.sweeps import Sweep, SweepDrops
from navtool.methods.intensity_map.mapped import MappedSweep
from navtool.methods.intensity_map.pictures import draw_map
from navtool.pipeline.intensity_map.config import IntensityMapConfig
from navtool.pipeline.intensity_map.glass_memory import GlassMemory
from navtool.pipeline.intensity_map.layer_points import sort_points
from navtool.pipeline.intensity_map.layers import intensity_layers
from navtool.pipeline.intensity_map.mapper import IntensityMap, map_cloud
from navtool.pipeline.intensity_map.obstacles import CellClass
from navtool.pipeline.intensity_map.solidity import solidity
from navtool.pipeline.roc import roc

SOLID = ("tree", "bush", "person", "pole", "log", "fence", "barrier", "building", "vehicle", "object", "rubble")
PLIABLE = ("grass",)
COMMAND = "python benchmarks/mim_real.py --docs"
PICTURE = "mim_vlp16.png"
FEW = 5
"""Cells of a label that are worth a row."""
ABOUT = """
One cloud each, with the preset of its sensor and the height above the ground measured in the cloud; all else as by
default. Numbers are cells of the 20 m x 20 m grid with returns in a layer. Solidity is the figure that is held against
the threshold Gamma: mean intensity of the cells around, the largest of the layers, in units of R.

RELLIS-3D's labels are its own for the Ouster; its Velodyne has those of the nearest labelled point of the Ouster within
0.3 m. A cell has the label of most of its points. Nothing that is made from RELLIS-3D or KITTI but these figures is
kept here: their licences are non-commercial.

What it means: R is what a white diffuse surface gives. In the near infrared trunks, people, cars and walls give a
fraction of that, and leaves and grass no less than they: the medians below are close together, and an area under the
curve near 0.5 says that no threshold tells the two apart. The paper's "above 0.75 R is solid" holds for a sensor whose
scale saturates on ordinary walls, as the simulated one's does. So a real sensor's threshold has to be fitted, and the
area that `navtool fit intensity_threshold` tells says whether that helps. """


@dataclass(frozen=True, slots=True)
class Looked:
    """A cloud with its map."""

    cloud: RealCloud
    config: IntensityMapConfig
    made: IntensityMap
    solidity: NDArray[np.float32]
    """Solidity of the cells with returns."""
    label: NDArray[np.str_] | None
    """Labels of the same cells."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--docs", action="store_true", help="write docs/results/mim_real.json and mim_real.md")
    docs = parser.parse_args().docs
    rows: list[Result] = []
    for cloud in real_clouds():
        looked = look(cloud)
        rows += figures(looked)
        png = draw(looked)
        OUT.mkdir(exist_ok=True)
        name = f"mim_{''.join(letter if letter.isalnum() else '_' for letter in cloud.name.lower())}.png"
        (OUT / name).write_bytes(png)
        print(f"-> {OUT / name}")
        if docs and cloud.may_be_shown:
            DOCS.mkdir(parents=True, exist_ok=True)
            (DOCS / PICTURE).write_bytes(png)
    for row in rows:
        print(f"{row.what}: {shown(row.ours)}")
    if docs:
        write(rows)


def look(cloud: RealCloud) -> Looked:
    """Map a cloud, twice at the same place: glass counts from the second cloud on."""
    config = compose("intensity_map", [f"sensor={cloud.preset}"], IntensityMapJob).map
    config = replace(config, layers=replace(config.layers, sensor_height_m=cloud.sensor_height_m))
    memory, here = GlassMemory(), np.zeros(3)
    for time_s in (0.0, 0.1):
        memory, made = map_cloud(memory, cloud.xyz, cloud.intensity, here, time_s, 0.0, config)
    grid, layers = config.grid, config.layers
    points = sort_points(cloud.xyz, cloud.intensity, grid, layers)
    solid = solidity(intensity_layers(points, grid, layers), grid, layers, config.obstacles).reshape(-1)
    cells = np.flatnonzero(made.obstacles.seen)
    label = None if cloud.label is None else _labels(cloud, config, cells)
    return Looked(cloud, config, made, solid[cells], label)


def _labels(cloud: RealCloud, config: IntensityMapConfig, cells: NDArray[np.int64]) -> NDArray[np.str_]:
    """The label of most points in each cell, of those that lie in a layer."""
    assert cloud.label is not None
    number = np.arange(len(cloud.xyz), dtype=np.float32)
    # the numbers take the place of the intensities, to find out which points lie in which cell
    scale = replace(config.layers, full_scale=float(len(number)))
    points = sort_points(cloud.xyz, number, config.grid, scale)
    label = cloud.label[np.rint(points.share.astype(np.float64) * len(number)).astype(np.int64)]
    cell = points.cell % config.grid.cells**2
    names, kind = np.unique(label, return_inverse=True)
    counts = np.zeros((config.grid.cells**2, len(names)), np.int64)
    np.add.at(counts, (cell, kind), 1)
    return np.asarray(names[counts[cells].argmax(axis=1)])


def figures(looked: Looked) -> Iterator[Result]:
    """What a reader asks of a cloud."""
    name, solid = looked.cloud.name, looked.solidity
    threshold = looked.config.obstacles.threshold
    share = np.clip(looked.cloud.intensity / looked.config.layers.full_scale, 0, 1)

    def row(what: str, ours: float) -> Result:
        return Result(what=f"{name}: {what}", ours=ours, command=COMMAND)

    yield row("points", float(len(looked.cloud.xyz)))
    yield row("height of the sensor, m", looked.cloud.sensor_height_m)
    for quantile in (0.05, 0.5, 0.95):
        yield row(f"intensity that {quantile:.0%} of all points stay below, R", float(np.quantile(share, quantile)))
    yield row("cells with returns", float(solid.size))
    yield row(f"of them solid with Gamma = {threshold:g}, share", float((solid > threshold).mean()))
    yield row("transparent cells", float((looked.made.classes == CellClass.transparent).sum()))
    if looked.label is None:
        return
    kinds, counts = np.unique(looked.label, return_counts=True)
    for kind in kinds[counts >= FEW]:
        of_kind = solid[looked.label == kind]
        yield row(f"{kind}: cells", float(of_kind.size))
        yield row(f"{kind}: median solidity, R", float(np.median(of_kind)))
        yield row(f"{kind}: solid with Gamma = {threshold:g}, share", float((of_kind > threshold).mean()))
    for what, some, others in (
        ("trees, people and the like from bushes", SOLID, ("bush",)),
        ("solid from grass", SOLID, PLIABLE),
    ):
        positive = np.isin(looked.label, some) & ~np.isin(looked.label, others)
        negative = np.isin(looked.label, others)
        if min(positive.sum(), negative.sum()) >= FEW:
            curve = roc(solid[positive], solid[negative])
            yield row(f"{what}: area under the ROC curve", curve.area)
            yield row(f"{what}: best Gamma, R", curve.best().threshold)


def draw(looked: Looked) -> bytes:
    """The layers, the classes and the plan as a picture."""
    cloud = looked.cloud
    sweep = Sweep(0, cloud.xyz, cloud.intensity, np.zeros(3), SweepDrops())
    return png_bytes(draw_map(MappedSweep(0, sweep, looked.made, 0.0, looked.config), 0.0))


def shown(value: float | None) -> str:
    """A figure for readers: counts whole, others with three digits."""
    return f"{value:,.0f}" if value is not None and value >= 100 else told(value)


def write(rows: list[Result]) -> None:
    """The figures for programs and for readers."""
    about = [" ".join(paragraph.split()) for paragraph in ABOUT.strip().split("\n\n")]
    document = {"about": about, "machine": machine(), "rows": [asdict(row) for row in rows]}
    (DOCS / "mim_real.json").write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
    lines = ["# Intensity maps of real clouds", "", f"Generated by `{COMMAND}`.", ""]
    lines += [line for paragraph in about for line in (*textwrap.wrap(paragraph, 120), "")]
    for cloud in dict.fromkeys(row.what.partition(": ")[0] for row in rows):
        lines += [f"## {cloud}", "", "| what | figure |", "|---|---|"]
        lines += [
            f"| {row.what.partition(': ')[2]} | {shown(row.ours)} |"
            for row in rows
            if row.what.startswith(f"{cloud}: ")
        ]
        lines.append("")
    if (DOCS / PICTURE).is_file():
        lines += [f"![classes, plan and layers of the VLP-16's cloud]({PICTURE})", ""]
        lines += ["The VLP-16's cloud: an indoor capture from the decoder tests of Nebula (Apache-2.0).", ""]
    (DOCS / "mim_real.md").write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
