"""The quadruped: how much each ground shakes it and costs it in each gait, where it falls, and how fast it computes.

``python benchmarks/legged.py --docs`` also writes the figures into docs/legged.md. ``--metres`` and ``--beds`` shorten
the walks over the surfaces and the number of rock beds.
"""

import argparse
import itertools
import statistics
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from _report import Row, machine, write_report

from navtool.sim.drive.failure import FailureKind
from navtool.sim.legged.footing import Footing
from navtool.sim.legged.footings import rocks
from navtool.sim.legged.gaits import GaitName
from navtool.sim.legged.proprioception import BATTERY_EVERY, IMU_EVERY
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.track import LeggedTrack, track_of
from navtool.sim.legged.vibration import vibration_rms
from navtool.sim.legged.world_footing import WorldFooting
from navtool.sim.world.place import make_world
from navtool.sim.world.scenario import Scatter, ScenarioConfig

PAGE = Path(__file__).resolve().parents[1] / "docs" / "legged.md"
BEGIN, END = "<!-- figures: python benchmarks/legged.py --docs -->", "<!-- end of figures -->"
REAL_TIME_BAR = 10.0
METRES = 20.0
EQUAL_MPS = 0.3
"""At which all gaits walk over the surfaces, so that speed does not decide what shakes and what costs."""
BED_MPS = {GaitName.TROT: 0.6, GaitName.CRAWL: 0.3, GaitName.AMBLE: 0.6}
"""Over the rock beds: AMCO's top speed of 0.6 m/s, and the crawl's restricted one."""
SEEDS = (11, 12, 13)
HELD_OUT = tuple(range(11, 31))
"""Rock beds that nobody watched while the controller was changed; 101 to 130 were for that, 1 to 3 were watched."""
SURFACES = ("concrete", "asphalt", "gravel", "sand", "mulch", "grass", "tall_grass", "mud", "rock_bed")
ORDERED = ("concrete", "gravel", "rock_bed")
"""Stable, granular, poor foothold: what has to shake and cost more and more."""
STABLE = ("concrete", "asphalt")
START_M = -6.0
"""Where walks over the places begin: around the place's start, at -12 m, nothing grows."""
PATIENCE = 4.0
"""A walk is given so many times as long as its speed asks for: dense stems hold it now and then."""
SETTLE_S = 2.0
STEP_S = 0.2


@dataclass(frozen=True)
class Walk:
    """What one walk came to."""

    went_m: float
    vibration_mps2: float
    current_a: float
    stumbles: int
    fell: bool
    real_time: float


class Group(NamedTuple):
    """The walks of one gait over one kind of ground."""

    gait: GaitName
    ground: str
    walks: list[Walk]

    def mean(self, what: str) -> float:
        """The mean over the walks of one of their figures; not a number where a walk was too short for it."""
        return statistics.mean(float(getattr(walk, what)) for walk in self.walks)

    @property
    def falls(self) -> int:
        """How many walks ended on the ground."""
        return sum(walk.fell for walk in self.walks)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--docs", action="store_true")
    parser.add_argument("--metres", type=float, default=METRES)
    parser.add_argument("--beds", type=int, default=len(HELD_OUT))
    asked = parser.parse_args()
    surfaces = [
        Group(gait, name, [walk(surface(name, seed), gait, seed, EQUAL_MPS, asked.metres) for seed in SEEDS])
        for name in SURFACES
        for gait in GaitName
    ]
    beds = [
        Group(gait, "rocks", [walk(rocks(seed), gait, seed, BED_MPS[gait], METRES) for seed in HELD_OUT[: asked.beds]])
        for gait in GaitName
    ]
    write_report("legged", [*rows(surfaces), *(row for group in beds for row in group_rows(group))])
    if asked.docs:
        write_page(surfaces, beds, asked.metres)


def surface(name: str, seed: int) -> Footing:
    """A place without hills that is all of one surface; tall grass grows in patches that leave little free."""
    ground, patches = ("grass", 120) if name == "tall_grass" else (name, 0)
    grass = Scatter(count=patches, gap_m=-1.0, size=[0.5, 1.0])
    config = ScenarioConfig(name=name, ground=ground, side_m=36.0, course_m=24.0, hills_m=0.0, grass_patches=grass)
    return WorldFooting(make_world(config, seed))


def walk(footing: Footing, gait: GaitName, seed: int, speed_mps: float, metres: float) -> Walk:
    """Walk along the x axis, held on it as a driver would."""
    start_m = START_M if isinstance(footing, WorldFooting) else 0.0
    robot = LeggedRobot(footing, gait=gait, start=(start_m, 0.0, 0.0))
    start = time.process_time()
    state = robot.state()
    while state.position_m[0] < start_m + metres and not state.fallen and state.time_s < PATIENCE * metres / speed_mps:
        turn = min(max(-0.5 * state.position_m[1] - state.yaw_rad, -0.4), 0.4)
        state = robot.step(speed_mps, turn, STEP_S)
    seconds = time.process_time() - start
    return figures(track_of(robot, seed), state.time_s / seconds)


def figures(track: LeggedTrack, real_time: float) -> Walk:
    fallen = track.truth.fallen
    upright_s = float(track.time_s[np.argmax(fallen) if fallen.any() else -1])
    hz = 1.0 / float(track.time_s[1])
    imu_hz, battery_hz = round(hz / IMU_EVERY), round(hz / BATTERY_EVERY)
    imu = track.measured.imu[round((SETTLE_S - 1.0) * imu_hz) : round(upright_s * imu_hz), :3]
    battery = track.measured.battery[round(SETTLE_S * battery_hz) : round(upright_s * battery_hz), 0]
    went = float(track.truth.position_m[-1, 0] - track.truth.position_m[0, 0])
    return Walk(
        went_m=went,
        vibration_mps2=vibration_rms(imu, imu_hz) if len(imu) > 2 * imu_hz else float("nan"),
        current_a=float(-battery.mean()) if len(battery) else float("nan"),
        stumbles=sum(failure.kind is FailureKind.stumble for failure in track.failures),
        fell=bool(fallen.any()),
        real_time=real_time,
    )


def rows(groups: list[Group]) -> Iterator[Row]:
    for group in groups:
        yield from group_rows(group)
    for gait in GaitName:
        for what, name in (("vibration_mps2", "vibration"), ("current_a", "current")):
            found = [group.mean(what) for ground in ORDERED for group in groups if group[:2] == (gait, ground)]
            rises = min(after / before for before, after in itertools.pairwise(found))
            label = f"{gait.value}: least rise of {name} from {' to '.join(ORDERED)}"
            yield Row(what=label, ours=rises, unit="times", bar=1.0, holds=rises > 1.0)
    trot, crawl = (
        statistics.mean(
            group.mean("vibration_mps2") for group in groups if group.gait is gait and group.ground in ORDERED
        )
        for gait in (GaitName.TROT, GaitName.CRAWL)
    )
    yield Row(what="trot's vibration over the crawl's", ours=trot / crawl, unit="times", bar=1.0, holds=trot > crawl)


def group_rows(group: Group) -> Iterator[Row]:
    what, walks = f"{group.gait.value} {group.ground}", len(group.walks)
    real_time = statistics.median(walk.real_time for walk in group.walks)
    safe = group.ground in STABLE
    yield Row(what=f"{what}: vibration", ours=group.mean("vibration_mps2"), unit="m/s2 rms")
    yield Row(what=f"{what}: current", ours=group.mean("current_a"), unit="A")
    yield Row(what=f"{what}: stumbles", ours=group.mean("stumbles"), unit="a walk")
    yield Row(
        what=f"{what}: falls",
        ours=group.falls,
        unit=f"of {walks} walks",
        bar=0.0 if safe else None,
        holds=not safe or group.falls == 0,
    )
    yield Row(what=f"{what}: went", ours=group.mean("went_m"), unit="m")
    yield Row(
        what=f"{what}: real time",
        ours=real_time,
        unit="times, one core",
        bar=REAL_TIME_BAR,
        holds=real_time >= REAL_TIME_BAR,
    )


def write_page(surfaces: list[Group], beds: list[Group], metres: float) -> None:
    """Write the figures between the two marks of the page."""
    head, rest = PAGE.read_text(encoding="utf-8").split(BEGIN)
    about = (
        f"Over the surfaces of the simulated places, {metres:g} m at {EQUAL_MPS} m/s, {len(SEEDS)} places each; over"
        f" the rock beds 20 m at 0.6 m/s, the crawl at 0.3 m/s, {len(beds[0].walks)} held-out beds. Means over walks;"
        " real time is the median of processor time on one core."
    )
    lines = [
        BEGIN,
        "",
        about,
        "",
        "| ground | gait | went, m | vibration, m/s2 rms | current, A | stumbles | falls | real time |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for group in [*surfaces, *beds]:
        real_time = statistics.median(walk.real_time for walk in group.walks)
        lines.append(
            f"| {group.ground.replace('_', ' ')} | {group.gait.value} | {group.mean('went_m'):.1f}"
            f" | {group.mean('vibration_mps2'):.2f}"
            f" | {group.mean('current_a'):.2f} | {group.mean('stumbles'):.1f}"
            f" | {group.falls} of {len(group.walks)} | {real_time:.1f} x |"
        )
    lines += ["", f"Measured on {machine()['processor']}.", ""]
    PAGE.write_text(head + "\n".join(lines) + END + rest.split(END)[1], encoding="utf-8")


if __name__ == "__main__":
    main()
