import numpy as np
import pytest

from navtool.pipeline.arrays import Array
from navtool.sim.proprioception import BATTERY_EVERY, GRAVITY_MPS2, ODOMETRY_EVERY, Proprioception, measure
from navtool.sim.rig import TRACK_WIDTH_M, WHEEL_RADIUS_M
from navtool.sim.robot import STEP_S
from navtool.sim.scene import Scene
from navtool.sim.track import Track, drive


@pytest.fixture(scope="module")
def drives(place: Scene) -> list[tuple[Track, Proprioception]]:
    tracks = [drive(place, seed, 22.0, mischief=0.7) for seed in range(5)]
    return [(track, measure(track, np.random.default_rng(seed))) for seed, track in enumerate(tracks)]


def near_contact(track: Track) -> Array:
    return np.convolve(track.contact, np.ones(81), mode="same") > 0


def test_a_collision_shows_in_the_imu_as_a_spike_and_nothing_else_does(
    drives: list[tuple[Track, Proprioception]],
) -> None:
    spikes = 0
    for track, samples in drives:
        level = np.linalg.norm(samples.imu[:, :2], axis=1)
        assert level[~near_contact(track)].max() < 7.0
        for event in track.failures:
            if event.reason == "collision":
                start = round(event.start_s / STEP_S)
                assert level[start - 3 : start + 10].max() > 15.0
                spikes += 1
    assert spikes >= 3


def test_the_imu_feels_gravity_upwards_and_the_turn(drives: list[tuple[Track, Proprioception]]) -> None:
    for track, samples in drives:
        assert samples.imu[:, 2].mean() == pytest.approx(GRAVITY_MPS2, abs=0.1)
        assert samples.imu[:, 5] == pytest.approx(track.turn_radps, abs=0.06)


def test_rough_ground_and_speed_shake_it(drives: list[tuple[Track, Proprioception]]) -> None:
    shaken, calm = [], []
    for track, samples in drives:
        energy = track.roughness * np.abs(track.speed_mps)
        clear = ~near_contact(track)
        shaken.append(samples.imu[clear & (energy > 0.4), 2])
        calm.append(samples.imu[clear & (energy < 0.05), 2])
    assert np.concatenate(shaken).std() > 3 * np.concatenate(calm).std()


def test_odometry_drifts_mildly_from_its_own_start(drives: list[tuple[Track, Proprioception]]) -> None:
    for track, samples in drives:
        true = np.stack([track.x_m, track.y_m], axis=-1)[::ODOMETRY_EVERY] - (track.x_m[0], track.y_m[0])
        yaw = track.yaw_rad[0]
        true = true @ np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
        error = np.linalg.norm(samples.odometry[:, :2] - true, axis=1)
        driven = np.abs(track.speed_mps).sum() * STEP_S
        assert 1e-3 < error[-1] < 0.06 * driven
        assert samples.odometry[:, 3] == pytest.approx(track.speed_mps[::ODOMETRY_EVERY], abs=0.06)


def test_wheels_turn_as_the_robot_moves_and_strain_where_it_does_not(
    drives: list[tuple[Track, Proprioception]],
) -> None:
    for track, samples in drives:
        left, right = samples.joints[:, 1, 0], samples.joints[:, 1, 1]
        assert (left + right) * WHEEL_RADIUS_M / 2 == pytest.approx(track.speed_mps[::ODOMETRY_EVERY], abs=0.02)
        turn = (right - left) * WHEEL_RADIUS_M / TRACK_WIDTH_M
        assert turn == pytest.approx(track.turn_radps[::ODOMETRY_EVERY], abs=0.06)
        rates = np.diff(samples.joints[:, 0, 0]) / (ODOMETRY_EVERY * STEP_S)
        assert rates == pytest.approx(left[1:], abs=0.8)
        current = samples.battery[:, 0]
        assert (current < 0).all(), "ROS counts discharge as negative"
        blocked = (np.abs(track.speed_mps) < 0.05) & (track.command_mps > 0.4)
        blocked = blocked[::BATTERY_EVERY][5:]
        if blocked.any():
            assert current[5:][blocked].mean() < 1.5 * np.median(current)
