"""How well intensity maps show what is there: F-scores beside peers, approaches to glass, doors, and a long run.

``python benchmarks/mim_quality.py`` looks at training places; ``--split test`` judges on held-out ones, and ``--docs``
writes docs/results/mim.json and mim.md. ``--parts`` chooses what is measured; figures of other parts stay as they are.
It prints as it goes and can be stopped at any time: parts that are finished are written.
"""

import argparse
import itertools
import sys
from collections.abc import Callable, Iterator
from functools import partial

import cv2
import numpy as np
from _mim_about import about
from _mim_door import WAYS, door
from _mim_glass import FOUND_M, MOST_RAD, Approach, approach
from _mim_long import MINUTES, long_run
from _mim_methods import ALL_PASSED, OURS, TWO_CELLS, Drive, judge_drive
from _mim_results import Result, bootstrap, poisson, pooled_f, wilson, write_results

from navtool.pipeline.intensity_map.config import IntensityMapConfig
from navtool.pipeline.intensity_map.score import QUESTIONS, no_counts
from navtool.sim.world.scenario import Split

SCENARIOS = ("mim_1", "mim_2", "mim_3", "mim_4")
OUTDOORS = ("mim_3", "mim_4")
BARS = dict(zip(SCENARIOS, (0.90, 0.88, 0.90, 0.85), strict=True))
PAPER = {
    OURS: (0.82, 0.79, 0.84, 0.74),
    "laser scan": (0.12, 0.17, 0.35, 0.37),
    "occupancy grid": (0.20, 0.16, 0.33, 0.36),
    "glass by intensity peaks": (0.76, 0.46, None, None),
}
"""Table I; Glass-SLAM was tried indoors alone."""
SEEDS, SECONDS, FIRST = 8, 20.0, {Split.train: 300, Split.test: 1}
APPROACHES, OBLIQUE, DOORS, SHARE_BAR = 40, 20, 40, 0.95
FALSE_SEEDS, FALSE_BAR, TEN_MINUTES_S = 15, 1.0, 600.0
GROWTH_BAR_MIB = 1.0
PARTS = (*SCENARIOS, "glass", "false_glass", "door", "memory")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--split", choices=[split.value for split in Split], default=Split.train.value)
    parser.add_argument("--seeds", type=int, default=SEEDS, help="drives of each scenario")
    parser.add_argument("--seconds", type=float, default=SECONDS, help="of a drive")
    parser.add_argument("--false-glass-seeds", type=int, default=FALSE_SEEDS, help="drives of mim_3 and of mim_4")
    parser.add_argument("--minutes", type=int, default=MINUTES, help="of the long run")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument("--docs", action="store_true", help="write docs/results/mim.json and mim.md")
    asked = parser.parse_args()
    cv2.setNumThreads(1)
    split, config = Split(asked.split), IntensityMapConfig()
    parts: dict[str, Callable[[], Iterator[Result]]] = {
        # first, while the process is small
        "memory": partial(memory_rows, split, asked.minutes, config),
        "glass": partial(glass_rows, split, config),
        "false_glass": partial(false_glass_rows, split, asked.false_glass_seeds, asked.seconds, config),
        "door": partial(door_rows, split, config),
        **{name: partial(score_rows, name, split, asked.seeds, asked.seconds, config) for name in SCENARIOS},
    }
    told = about(split, seeds_of(split, asked.seeds), asked.seconds, asked.minutes)
    try:
        for name in (name for name in parts if name in asked.parts):
            rows = list(parts[name]())
            for row in rows:
                verdict = "" if row.holds is None else "holds" if row.holds else "MISSED"
                print(f"{row.what}: {row.ours} {row.interval or ''} {row.bar or ''} {verdict}", flush=True)
            if asked.docs:
                write_results(rows, told)
    except KeyboardInterrupt:
        sys.exit("stopped; what was finished is written")


def score_rows(name: str, split: Split, seeds: int, seconds: float, config: IntensityMapConfig) -> Iterator[Result]:
    """The F-scores of a scenario, of the map, of its peers, and of each class."""
    drives: list[Drive] = []
    for seed in seeds_of(split, seeds):
        drives.append(judge_drive(name, split, seed, seconds, config))
        score, one = drives[-1].counts[OURS].score("avoid"), drives[-1]
        told = f"{one.clouds} clouds, {one.moved_m:.1f} m"
        print(f"{name} {seed}: {told}, {score}", flush=True)
    yield from scenario_rows(name, drives, command(split, name))


def false_glass_rows(split: Split, seeds: int, seconds: float, config: IntensityMapConfig) -> Iterator[Result]:
    """How often there is glass where there is none: outdoors, without scoring anything else."""
    count, spans = 0, 0.0
    for name, seed in itertools.product(OUTDOORS, seeds_of(split, seeds)):
        one = judge_drive(name, split, seed, seconds, config, scored=False)
        count, spans = count + one.false_glass, spans + one.seconds / TEN_MINUTES_S
        print(f"{name} {seed}: {one.false_glass} false panes in {one.seconds:.0f} s", flush=True)
    # drives of a whole number of steps: their sum is off by rounding
    spans = round(spans, 6)
    low, high = poisson(count)
    yield Result(
        what=f"false panes in 10 minutes outdoors ({count} in {10 * spans:.1f} minutes)",
        ours=count / spans,
        interval=(low / spans, high / spans),
        bar=FALSE_BAR,
        holds=count / spans <= FALSE_BAR,
        command=command(split, "false_glass"),
    )


def scenario_rows(name: str, drives: list[Drive], how: str) -> Iterator[Result]:
    place = SCENARIOS.index(name)
    for method in drives[0].counts:
        counts = [drive.counts[method] for drive in drives if method in drive.counts]
        row = partial(Result, command=how)
        ours = pooled_f(counts, "avoid")
        bar = BARS[name] if method == OURS else None
        yield row(
            what=f"{name}: F, must be avoided, {method}",
            ours=ours,
            interval=bootstrap(counts, "avoid"),
            paper=PAPER[method][place] if method in PAPER else None,
            bar=bar,
            holds=None if bar is None else ours is not None and ours >= bar,
        )
        if method in (ALL_PASSED, TWO_CELLS):
            continue
        yield row(
            what=f"{name}: F without tolerance, must be avoided, {method}",
            ours=pooled_f(counts, "avoid", exact=True),
            interval=bootstrap(counts, "avoid", exact=True),
        )
        total = sum(counts, start=no_counts())
        asked = QUESTIONS if method == OURS else ("avoid", "transparent")
        for question in asked:
            score = total.score(question)
            for what, value in (("precision", score.precision), ("recall", score.recall), ("F", score.f)):
                if value is not None and (question, what) != ("avoid", "F"):
                    yield row(what=f"{name}: {what}, {question}, {method}", ours=value)


def glass_rows(split: Split, config: IntensityMapConfig) -> Iterator[Result]:
    """Approaches to panes: near their normal, as a robot drives at one, and more obliquely."""
    for label, low, high, bar, number in (
        ("", 0.0, MOST_RAD, SHARE_BAR, APPROACHES),
        (" obliquely", MOST_RAD, 2 * MOST_RAD, None, OBLIQUE),
    ):
        found: list[Approach] = []
        for seed in range(number):
            one = approach([split is Split.test, seed, round(np.degrees(low))], (low, high), config)
            found.append(one)
            angle = np.degrees(one.angle_rad)
            print(f"pane of {2 * one.half_m:.1f} m at {angle:.0f} degrees: found at {one.found_m:.2f} m", flush=True)
        count = sum(one.found_m >= FOUND_M for one in found)
        degrees = f"{np.degrees(low):.0f} to {np.degrees(high):.0f} degrees"
        yield Result(
            what=f"share of {number} panes found at {FOUND_M} m or more, approached{label} at {degrees}",
            ours=count / number,
            interval=wilson(count, number),
            bar=bar,
            holds=None if bar is None else count / number >= bar,
            command=command(split, "glass"),
        )
        yield Result(
            what=f"median distance at which they are found, m, {degrees}",
            ours=float(np.median([one.found_m for one in found])),
            command=command(split, "glass"),
        )


def door_rows(split: Split, config: IntensityMapConfig) -> Iterator[Result]:
    """Doors of 0.9 m after each way of inflation."""
    looks = [door([split is Split.test, seed], config) for seed in range(DOORS)]
    for way in WAYS:
        count = sum(look.open[way.name] for look in looks)
        ours = way is WAYS[0]
        print(f"door after {way.name} inflation: {count} of {DOORS} open", flush=True)
        yield Result(
            what=f"share of {DOORS} doors of 0.9 m open to a robot of 0.5 m after inflation: {way.name}",
            ours=count / DOORS,
            interval=wilson(count, DOORS),
            bar=SHARE_BAR if ours else None,
            holds=count / DOORS >= SHARE_BAR if ours else None,
            command=command(split, "door"),
        )


def memory_rows(split: Split, minutes: int, config: IntensityMapConfig) -> Iterator[Result]:
    """Half an hour of clouds."""
    run = long_run(split, FIRST[split], minutes, config)
    print(f"{run.clouds} clouds: {run.growth_mib:.2f} MiB more; cells of glass {run.cells}", flush=True)
    yield Result(
        what=f"growth of the process over {run.clouds} clouds, MiB",
        ours=run.growth_mib,
        bar=GROWTH_BAR_MIB,
        holds=run.growth_mib <= GROWTH_BAR_MIB,
        command=command(split, "memory"),
    )
    yield Result(
        what=f"cells of the glass memory in the last third of {minutes} minutes, most",
        ours=max(run.cells[-len(run.cells) // 3 :]),
        command=command(split, "memory"),
    )
    yield Result(
        what=f"cells of the glass memory in the first third of {minutes} minutes, most",
        ours=max(run.cells[: len(run.cells) // 3]),
        command=command(split, "memory"),
    )


def seeds_of(split: Split, seeds: int) -> range:
    return range(FIRST[split], FIRST[split] + seeds)


def command(split: Split, part: str) -> str:
    return f"python benchmarks/mim_quality.py --split {split.value} --parts {part}"


if __name__ == "__main__":
    main()
