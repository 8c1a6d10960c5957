"""The quadruped: how much faster than real time it walks, and how much each ground shakes it and costs it.

``python benchmarks/legged.py`` walks every gait 20 m over every ground with three seeds.
"""

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from _report import Row, write_report

from navtool.sim.drive.failure import FailureKind
from navtool.sim.legged.footing import Footing
from navtool.sim.legged.footings import concrete, granular, grass, mud, rocks
from navtool.sim.legged.gaits import GaitName
from navtool.sim.legged.proprioception import ODOMETRY_EVERY
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.track import LeggedTrack, track_of
from navtool.sim.legged.vibration import vibration_rms

REAL_TIME_BAR = 10.0
GOAL_M = 20.0
SPEED_MPS = {GaitName.TROT: 0.6, GaitName.CRAWL: 0.3, GaitName.AMBLE: 0.6}
"""AMCO's top speed of 0.6 m/s, and the crawl's restricted one."""
SEEDS = (1, 2, 3)
GROUNDS: dict[str, Callable[[int], Footing]] = {
    "concrete": lambda _: concrete(),
    "granular": granular,
    "grass": grass,
    "mud": lambda _: mud(),
    "rocks": rocks,
}
SETTLE_S = 2.0
IMU_HZ, BATTERY_HZ = 250, 10


@dataclass(frozen=True)
class Walk:
    """What one walk came to."""

    went_m: float
    vibration_mps2: float
    current_a: float
    stumbles: int
    fell: bool
    odometry_error: float
    real_time: float


def main() -> None:
    """Walk them all and print the tables."""
    rows = []
    for gait in GaitName:
        for name, ground in GROUNDS.items():
            walks = [_walk(ground(seed), gait, seed) for seed in SEEDS]
            rows += _rows(f"{gait.value} {name}", walks, safe=name == "concrete")
    write_report("legged", rows)


def _walk(footing: Footing, gait: GaitName, seed: int) -> Walk:
    robot = LeggedRobot(footing, gait=gait)
    speed = SPEED_MPS[gait]
    start = time.process_time()
    state = robot.state()
    while state.position_m[0] < GOAL_M and not state.fallen and state.time_s < 1.5 * GOAL_M / speed:
        state = robot.step(speed, 0.0, 0.2)
    seconds = time.process_time() - start
    return _figures(track_of(robot, seed), state.time_s / seconds)


def _figures(track: LeggedTrack, real_time: float) -> Walk:
    down = np.argmax(track.truth.fallen) if track.truth.fallen.any() else len(track.truth.fallen)
    upright_s = float(down) * 0.002
    imu = track.measured.imu[round((SETTLE_S - 1.0) * IMU_HZ) : round(upright_s * IMU_HZ), :3]
    battery = track.measured.battery[round(SETTLE_S * BATTERY_HZ) : round(upright_s * BATTERY_HZ), 0]
    odometry = track.measured.odometry[-1, :2]
    truth = track.truth.position_m[(len(track.measured.odometry) - 1) * ODOMETRY_EVERY, :2]
    went = float(track.truth.position_m[-1, 0])
    return Walk(
        went_m=went,
        vibration_mps2=vibration_rms(imu, IMU_HZ),
        current_a=float(-battery.mean()),
        stumbles=sum(failure.kind is FailureKind.stumble for failure in track.failures),
        fell=bool(track.truth.fallen.any()),
        odometry_error=float(np.hypot(*(odometry - truth))) / max(went, 1.0),
        real_time=real_time,
    )


def _rows(what: str, walks: list[Walk], *, safe: bool) -> list[Row]:
    falls = sum(walk.fell for walk in walks)
    real_time = statistics.median(walk.real_time for walk in walks)
    return [
        Row(what=f"{what}: vibration", ours=statistics.mean(w.vibration_mps2 for w in walks), unit="m/s2 rms"),
        Row(what=f"{what}: current", ours=statistics.mean(w.current_a for w in walks), unit="A"),
        Row(what=f"{what}: stumbles", ours=statistics.mean(w.stumbles for w in walks), unit="a walk"),
        Row(
            what=f"{what}: falls",
            ours=falls,
            unit=f"of {len(walks)} walks",
            bar=0.0 if safe else None,
            holds=not safe or falls == 0,
        ),
        Row(what=f"{what}: went", ours=statistics.mean(w.went_m for w in walks), unit="m"),
        Row(what=f"{what}: odometry off", ours=statistics.mean(w.odometry_error for w in walks), unit="of the way"),
        Row(
            what=f"{what}: real time",
            ours=real_time,
            unit="times, one core",
            bar=REAL_TIME_BAR,
            holds=real_time >= REAL_TIME_BAR,
        ),
    ]


if __name__ == "__main__":
    main()
