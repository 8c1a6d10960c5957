"""Splits never share a place or a run, whatever the data set."""

from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navtool.base.setting_error import SettingError
from navtool.train.errors import TrainError
from navtool.train.splits import GroupBy, Split, SplitConfig, Splits, split_episodes


@dataclass(frozen=True)
class Run:
    index: int
    start: int
    stop: int
    place: str
    source: str


def runs(*places: str, rows: int = 100) -> list[Run]:
    return [Run(i, i * rows, (i + 1) * rows, place, f"run_{i}.bag") for i, place in enumerate(places)]


@st.composite
def recorded(draw: st.DrawFn) -> list[Run]:
    """At least three places, some runs without one, some recordings cut into several episodes."""
    places = [*"abc", *draw(st.lists(st.sampled_from([*"abcdefgh", ""]), max_size=12))]
    lengths = draw(st.lists(st.integers(1, 500), min_size=len(places), max_size=len(places)))
    stops = [sum(lengths[: i + 1]) for i in range(len(places))]
    return [
        Run(i, stop - length, stop, place, f"run_{i}.bag")
        for i, (place, length, stop) in enumerate(zip(places, lengths, stops, strict=True))
    ]


@given(recorded(), st.integers(0, 1000))
@settings(max_examples=100, deadline=None)
def test_no_place_and_no_run_is_shared_and_nothing_is_lost(episodes: list[Run], seed: int) -> None:
    splits = split_episodes(episodes, SplitConfig(seed=seed))
    parts = [splits.episodes(split) for split in (Split.train, Split.val, Split.test)]
    assert all(parts)
    assert sorted(index for part in parts for index in part) == list(range(len(episodes)))
    assert splits.episodes(Split.all) == tuple(range(len(episodes)))
    for attribute in ("place", "source"):
        names = [{getattr(episodes[i], attribute) for i in part} - {""} for part in parts]
        assert sum(map(len, names)) == len(set().union(*names))


@given(recorded(), st.integers(0, 1000))
@settings(max_examples=30, deadline=None)
def test_the_same_seed_gives_the_same_split(episodes: list[Run], seed: int) -> None:
    config = SplitConfig(seed=seed)
    assert split_episodes(episodes, config) == split_episodes(list(episodes), config)


def test_another_seed_gives_another_split() -> None:
    episodes = runs(*"abcdefghij")
    assert len({split_episodes(episodes, SplitConfig(seed=seed)).test for seed in range(20)}) > 3


def test_fractions_are_met_where_groups_are_small() -> None:
    episodes = runs(*(f"place_{i}" for i in range(100)))
    splits = split_episodes(episodes, SplitConfig(val_fraction=0.2, test_fraction=0.1))
    assert (len(splits.train), len(splits.val), len(splits.test)) == (70, 20, 10)


def test_a_recording_of_several_places_joins_them() -> None:
    shared = [Run(0, 0, 9, "a", "x.bag"), Run(1, 9, 18, "b", "x.bag"), *runs("c", "d")]
    episodes = [Run(i, 9 * i, 9 * i + 9, run.place, run.source) for i, run in enumerate(shared)]
    for seed in range(10):
        splits = split_episodes(episodes, SplitConfig(seed=seed))
        home = next(part for part in (splits.train, splits.val, splits.test) if 0 in part)
        assert 1 in home


def test_lists_decide_and_the_rest_is_drawn() -> None:
    episodes = runs("field", "wood", "park", "field", "yard")
    splits = split_episodes(episodes, SplitConfig(test_places=["field"]))
    assert splits.test == (0, 3)
    assert splits.train
    assert splits.val
    everything = SplitConfig(train_places=["wood"], val_places=["park"], test_places=["field"])
    assert split_episodes(episodes, everything) == Splits(train=(1,), val=(2,), test=(0, 3))  # the yard stays out


def test_runs_stand_in_where_the_place_is_unknown() -> None:
    splits = split_episodes(runs("", "", "", ""), SplitConfig())
    assert all((splits.train, splits.val, splits.test))


def test_one_place_is_too_few_and_the_cure_works() -> None:
    episodes = runs("field", "field", "field")
    with pytest.raises(TrainError, match=r"1 place for 3 splits .*field") as caught:
        split_episodes(episodes, SplitConfig())
    assert caught.value.cure is not None
    assert "split.group_by=run" in caught.value.cure
    assert all(split_episodes(episodes, SplitConfig(group_by=GroupBy.run)).episodes(split) for split in Split)


@pytest.mark.parametrize("places", [("a", "b"), ("a", "a", "b"), ("a", "a"), ("a",)])
def test_each_cure_that_is_told_works(places: tuple[str, ...]) -> None:
    episodes = runs(*places)
    with pytest.raises(TrainError) as caught:
        split_episodes(episodes, SplitConfig())
    told = str(caught.value.cure)
    cures = {
        "split.test_fraction=0": SplitConfig(test_fraction=0.0),
        "split.group_by=run": SplitConfig(group_by=GroupBy.run),
    }
    works = {}
    for name, config in cures.items():
        try:
            split_episodes(episodes, config)
            works[name] = True
        except TrainError:
            works[name] = False
    assert {name: name in told for name in cures} == works
    assert "record more places" in told


def test_recordings_are_called_so_where_they_are_kept_apart() -> None:
    with pytest.raises(TrainError, match="2 recordings for 3 splits") as caught:
        split_episodes(runs("a", "a"), SplitConfig(group_by=GroupBy.run))
    assert "place" not in str(caught.value.cure)


def test_without_a_test_fraction_two_groups_are_enough() -> None:
    splits = split_episodes(runs("a", "b"), SplitConfig(test_fraction=0.0))
    assert (len(splits.train), len(splits.val), splits.test) == (1, 1, ())


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(TrainError, match="feild") as caught:
        split_episodes(runs("field", "wood", "park"), SplitConfig(test_places=["feild"]))
    assert caught.value.cure == "use one of field, park, wood"


def test_no_episode_at_all() -> None:
    with pytest.raises(TrainError, match="0 places for 3 splits"):
        split_episodes([], SplitConfig())


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"val_fraction": 0.0}, "val_fraction"),
        ({"test_fraction": 1.0}, "test_fraction"),
        ({"val_fraction": 0.5, "test_fraction": 0.5}, "nothing to train"),
        ({"val_places": ["a"], "test_places": ["a"]}, "two splits"),
    ],
)
def test_impossible_settings_are_refused(values: dict[str, object], message: str) -> None:
    with pytest.raises(SettingError, match=message):
        SplitConfig(**values)  # type: ignore[arg-type]  # the point of the test
