"""One episode: where and how it is driven, and its recording."""

import resource
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from zlib import crc32

from navtool.base.lineage import code_version, config_hash
from navtool.base.meter import Meter
from navtool.sim.drive.drive import Drive
from navtool.sim.drive.failure import Failure
from navtool.sim.drive.make import roll_out
from navtool.sim.drive.vehicle import Vehicle
from navtool.sim.errors import SimError
from navtool.sim.record.bag_format import BagFormat
from navtool.sim.record.bag_writer import write_bag
from navtool.sim.record.config import SimulationConfig
from navtool.sim.record.messages import MessageFactory
from navtool.sim.record.rig import RIGS, RobotKind
from navtool.sim.record.stage import Stage, make_stage
from navtool.sim.record.streams import Entry, Take, entries
from navtool.sim.world.place import World

EPISODES_MOST = 10_000
SEED_MOST = 100_000
_FIRST_S, _SPREAD_S, _BETWEEN_S = 1_300_000_000, 400_000_000, 14_400
_PICTURES, _CLOUDS = "/camera/front/image_raw/compressed", "/velodyne_points"


@dataclass(frozen=True, slots=True)
class Plan:
    """What follows of an episode from its number, the seed and the configuration."""

    number: int
    place: str
    """Name of its place, and of the folder of the place's recordings."""
    world_seed: int
    drive_seed: int
    start_ns: int
    """Stamp of its first moment; no two episodes of a run overlap."""
    path: str
    """Path of its recording, in the output folder."""


def plan_episode(config: SimulationConfig, seed: int, number: int) -> Plan:
    """The plan of an episode.

    Guarantee: it depends on the arguments alone; places of different splits, scenarios or seeds have different names.
    """
    world_seed = seed * EPISODES_MOST + number // config.episodes_per_place
    scenario = f"{config.scenario.name}-{config.scenario.split.name}"
    place = f"{scenario}-{world_seed}"
    first_s = _FIRST_S + crc32(f"{scenario}-{seed}".encode()) % _SPREAD_S
    return Plan(
        number=number,
        place=place,
        world_seed=world_seed,
        drive_seed=seed * EPISODES_MOST + number,
        start_ns=(first_s + number * _BETWEEN_S) * 10**9,
        path=f"{place}/run-{number}{config.format.suffix}",
    )


@dataclass(frozen=True, slots=True)
class Episode:
    """A recorded episode."""

    plan: Plan
    duration_s: float
    failures: list[Failure]
    failed_share: float
    """Failed share of the duration, 0-1."""
    pictures: int
    """How many pictures are recorded."""
    sha256: str
    size_bytes: int
    code: str
    """Version of the code that made it."""
    peak_rss_mib: float = 0.0
    """Largest memory of the process that made it; 0 where another run did."""


@dataclass(frozen=True, slots=True)
class NotMade:
    """An episode that could not be driven, and why."""

    plan: Plan
    reason: str


def make_vehicle(config: SimulationConfig, world: World) -> Vehicle:
    """The robot of a configuration in a place."""
    if config.robot is RobotKind.wheeled:
        from navtool.sim.wheeled.robot import WheeledRobot  # noqa: PLC0415 - the other one needs no MuJoCo

        return WheeledRobot(world)
    from navtool.sim.legged.gaits import GaitName  # noqa: PLC0415
    from navtool.sim.legged.vehicle import LeggedVehicle  # noqa: PLC0415

    return LeggedVehicle(world, GaitName(config.gait.value))


def drive_episode(config: SimulationConfig, plan: Plan) -> tuple[Stage, Drive]:
    """The place of an episode, made ready, and the drive through it.

    Raises:
        SimError: There is no such place, or no way to drive there.
    """
    stage = _stage(config, plan.world_seed)
    vehicle = make_vehicle(config, stage.world)
    return stage, roll_out(vehicle, stage.world, config.drive, plan.drive_seed)


def take_of(config: SimulationConfig, plan: Plan, stage: Stage, drive: Drive) -> Take:
    """How an episode is recorded."""
    return Take(
        stage=stage,
        drive=drive,
        rig=RIGS[config.robot],
        camera=config.camera,
        lidar=config.lidar,
        recorder=config.recorder,
        truth_images=config.truth_images,
        seed=plan.drive_seed,
        start_ns=plan.start_ns,
    )


def make_episode(config: SimulationConfig, plan: Plan, root: Path, staging: Path, meter: Meter) -> Episode | NotMade:
    """Drive an episode and write its recording; what is not finished lies in ``staging``.

    Args:
        config: What decides it.
        plan: Which one.
        root: Folder of all recordings.
        staging: Folder on the same disk for what is not finished.
        meter: Counts how much of the drive has been recorded.

    Raises:
        SimError: The recording cannot be written.
    """
    try:
        stage, drive = drive_episode(config, plan)
    except SimError as error:
        return NotMade(plan, str(error))
    on_reached = meter.part(0, round(drive.duration_s * 1e9))
    on_reached(0)
    take, counts = take_of(config, plan, stage, drive), Counter[str]()
    factory = MessageFactory(ros1=config.format is BagFormat.ros1)
    counted = _counted(entries(take, factory), plan.start_ns, counts, on_reached)
    unfinished = staging / f"episode-{plan.number}"
    sha256, size = write_bag(root / plan.path, config.format, factory.store, take.topics(), counted, unfinished)
    return Episode(
        plan=plan,
        duration_s=drive.duration_s,
        failures=list(drive.failures),
        failed_share=drive.failed_share,
        pictures=counts[_PICTURES],
        sha256=sha256,
        size_bytes=size,
        code=code_version(),
        peak_rss_mib=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    )


def _counted(
    recorded: Iterable[Entry], start_ns: int, counts: Counter[str], on_reached: Callable[[int], None]
) -> Iterator[Entry]:
    """The same entries, counted; with each picture and cloud the recording has advanced."""
    for entry in recorded:
        counts[entry.topic] += 1
        if entry.topic in {_PICTURES, _CLOUDS}:
            on_reached(entry.record_ns - start_ns)
        yield entry


_KEPT: dict[tuple[str, int], Stage] = {}
"""The last place, which the next episode often is in too."""


def _stage(config: SimulationConfig, world_seed: int) -> Stage:
    key = config_hash(config.scenario), world_seed
    if key not in _KEPT:
        _KEPT.clear()
        _KEPT[key] = make_stage(config.scenario, world_seed)
    return _KEPT[key]
