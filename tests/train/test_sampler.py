"""The order of samples is a function of (seed, epoch)."""

from hypothesis import given
from hypothesis import strategies as st

from navtool.train.sampler import EpochSampler


@given(st.integers(1, 300), st.integers(2, 40), st.integers(0, 99), st.integers(0, 99))
def test_each_index_comes_once_and_no_batch_is_single(size: int, batch_size: int, seed: int, epoch: int) -> None:
    sampler = EpochSampler(size, batch_size=batch_size, seed=seed)
    sampler.set_epoch(epoch)
    order = list(sampler)
    assert len(order) == len(sampler)
    assert len(set(order)) == len(order)
    assert set(order) <= set(range(size))
    assert size - len(order) == (1 if size % batch_size == 1 and size > 1 else 0)


@given(st.integers(0, 99), st.integers(0, 99))
def test_an_epoch_has_one_order_whatever_was_iterated_before(seed: int, epoch: int) -> None:
    fresh, used = (EpochSampler(50, batch_size=8, seed=seed) for _ in range(2))
    for earlier in range(3):
        used.set_epoch(earlier)
        list(used)
    fresh.set_epoch(epoch)
    used.set_epoch(epoch)
    assert list(fresh) == list(used) == list(used)


def test_seeds_and_epochs_differ() -> None:
    orders = set()
    for seed in range(5):
        sampler = EpochSampler(50, batch_size=8, seed=seed)
        for epoch in range(5):
            sampler.set_epoch(epoch)
            orders.add(tuple(sampler))
    assert len(orders) == 25
