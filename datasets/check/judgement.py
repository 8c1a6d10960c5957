"""Can it be trained on: labels, calibration, leakage?"""

import numpy as np

from navtool.datasets.check.findings import Findings, Severity, name_of
from navtool.datasets.check.plausible_labels import check_plausible
from navtool.datasets.robot.calibration import Calibration
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.schema import Contents
from navtool.datasets.streams.table import row_of, sensor_of

RARE_SHARE = 0.01
"""Outcomes rarer than this are hard to learn."""


def check_labels(dataset: NavDataset) -> Findings:
    """There are labels, known steps, and both outcomes in a share that can be learnt from."""
    if not (dataset.layout.beside / "labels.json").is_file():
        yield Severity.WARN, "label.*", "not labelled yet: run `navtool label`"
        return
    outcomes, known = dataset.column("label.outcome"), dataset.column("label.known")
    if not known.any():
        yield Severity.WARN, "label.known", "no step is known: nothing can be trained on it"
    if np.unique(outcomes).size == 1:
        word = "success" if outcomes[0] == 1 else "failure"
        yield Severity.WARN, "label.outcome", f"every row is a {word}: a model cannot learn to tell them apart"
        yield from check_plausible(dataset)
        return
    failed = float((outcomes == 0).mean())
    if not RARE_SHARE <= failed <= 1 - RARE_SHARE:
        yield Severity.WARN, "label.outcome", f"{failed:.2%} of the rows are failures: record more of the other kind"
    yield from check_plausible(dataset)


def check_calibrations(dataset: NavDataset) -> Findings:
    """Where the sensors sit and how the camera projects is known."""
    for episode in dataset.episodes:
        calibration = dataset.calibration(episode.index)
        contents = dataset.description.contents
        lacking = [
            name
            for name, value, wanted in (
                ("camera", calibration.camera, contents.camera),
                ("base_camera", calibration.base_camera, contents.camera),
                ("base_lidar", calibration.base_lidar, contents.lidar),
                ("base_imu", calibration.base_imu, contents.imu),
            )
            if wanted and value is None
        ]
        lacking += _further_lacking(calibration, contents)
        if lacking:
            yield Severity.WARN, name_of(episode), f"{', '.join(lacking)} unknown"


def _further_lacking(calibration: Calibration, contents: Contents) -> list[str]:
    """What is unknown of further cameras and LiDARs."""
    lacking = [
        f"camera.{sensor_of(stream)}"
        for stream in contents.camera_streams
        if sensor_of(stream) and calibration.camera_of(stream) is None
    ]
    streams = [*(stream for stream in contents.camera_streams if sensor_of(stream)), *contents.lidar_streams]
    poses = calibration.poses()
    return lacking + [f"{row_of(s).pose}.{sensor_of(s)}" for s in streams if poses.get(s) is None]


def check_leakage(dataset: NavDataset) -> Findings:
    """No run is in the data set twice, no two are of one time, and runs of one place lie apart."""
    seen: dict[str, str] = {}
    for entry in dataset.lineage()["recordings"]:
        if entry["sha256"] in seen:
            yield Severity.FAIL, entry["source"], f"is the same recording as {seen[entry['sha256']]}"
        seen[entry["sha256"]] = entry["source"]
    spans = sorted((entry["start_ns"], entry["end_ns"], entry["source"]) for entry in dataset.provenance())
    latest_ns, latest = -1, ""
    for start_ns, end_ns, source in spans:
        if start_ns < latest_ns:
            both = f"{(min(latest_ns, end_ns) - start_ns) * 1e-9:.1f} s of it are of the same time as {source}"
            yield Severity.WARN, latest, f"{both}: if it is the same run, splits may share it"
        latest_ns, latest = max((latest_ns, latest), (end_ns, source))
    if len(dataset.episodes) > 1 and not all(episode.place for episode in dataset.episodes):
        yield Severity.WARN, "places", "unknown for some episodes: splits can only keep runs apart (ingest with place=)"
