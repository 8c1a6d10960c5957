"""Laws of the feature graph: eq. (6) and (7) against naive loops, Lemma 1 and 2, what reliability does."""

import math

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import Tensor

from navtool.base.setting_error import SettingError
from navtool.pipeline.feature_graph import FeatureGraphConfig, feature_graph, reliability_matrix

SIZES = [3, 2, 2, 1]
NODES = sum(SIZES)

unit = st.floats(0.0, 1.0, width=32)
graphs = st.tuples(
    st.lists(unit, min_size=NODES, max_size=NODES), unit, unit, st.floats(0.5, 40.0, width=32, exclude_min=True)
)


def naive_reliability(i: int, j: int, r_image: float, r_point: float) -> float:
    image, point = range(SIZES[0]), range(SIZES[0], SIZES[0] + SIZES[1])
    if (i in image and j in point) or (i in point and j in image):
        return 0.5 * (r_image + r_point)
    if i in image or j in image:
        return r_image
    if i in point or j in point:
        return r_point
    return 1.0


def weights_of(f_vec: list[float], r_image: float, r_point: float, decay: float) -> Tensor:
    reliability = reliability_matrix(torch.tensor([r_image]), torch.tensor([r_point]), SIZES)
    return feature_graph(torch.tensor([f_vec]), reliability, decay)[0]


@given(graphs)
@settings(deadline=None, max_examples=50)
def test_equations_6_and_7_as_printed(graph: tuple[list[float], float, float, float]) -> None:
    f_vec, r_image, r_point, decay = graph
    weights = weights_of(f_vec, r_image, r_point, decay)
    for i in range(NODES):
        for j in range(NODES):
            r = naive_reliability(i, j, r_image, r_point)
            expected = 0.0 if i == j else math.exp(-decay * abs(f_vec[i] - f_vec[j]) * (2.0 - r))
            assert weights[i, j].item() == pytest.approx(expected, rel=1e-4, abs=1e-12)


@given(graphs)
@settings(deadline=None, max_examples=50)
def test_lemma_1_symmetric_zero_diagonal_positive_elsewhere(graph: tuple[list[float], float, float, float]) -> None:
    weights = weights_of(*graph)
    assert torch.equal(weights, weights.t())
    assert torch.equal(weights.diagonal(), torch.zeros(NODES))
    off_diagonal = weights[~torch.eye(NODES, dtype=torch.bool)]
    assert bool((off_diagonal > 0.0).all())
    assert bool((off_diagonal <= 1.0).all())


@given(graphs)
@settings(deadline=None, max_examples=50)
def test_lemma_2_laplacian_is_positive_semidefinite(graph: tuple[list[float], float, float, float]) -> None:
    weights = weights_of(*graph).double()
    laplacian = torch.diag(weights.sum(dim=1)) - weights
    assert torch.linalg.eigvalsh(laplacian).min().item() > -1e-9


def test_batch_equals_its_samples_and_leading_dimensions_broadcast() -> None:
    generator = torch.Generator().manual_seed(0)
    f_vec = torch.rand(2, 5, NODES, generator=generator)
    r = torch.rand(2, 2, generator=generator)
    reliability = reliability_matrix(r[:, 0], r[:, 1], SIZES)
    together = feature_graph(f_vec, reliability.unsqueeze(1))
    for sample in range(2):
        for candidate in range(5):
            alone = feature_graph(f_vec[sample, candidate], reliability[sample])
            assert torch.equal(together[sample, candidate], alone)


@pytest.mark.parametrize(("sensor", "nodes"), [(0, range(3)), (1, range(3, 5))])
def test_lower_reliability_weakens_every_edge_of_its_sensor_and_no_other(sensor: int, nodes: range) -> None:
    f_vec = [0.05, 0.2, 0.35, 0.5, 0.62, 0.74, 0.86, 0.98]
    r = [0.8, 0.8]
    trusted = weights_of(f_vec, r[0], r[1], 15.0)
    r[sensor] = 0.3
    doubted = weights_of(f_vec, r[0], r[1], 15.0)
    for i in range(NODES):
        for j in range(NODES):
            if i != j and (i in nodes or j in nodes):
                assert doubted[i, j] < trusted[i, j]
            else:
                assert doubted[i, j] == trusted[i, j]


def test_full_reliability_is_the_plain_distance_graph() -> None:
    f_vec = torch.linspace(0.0, 1.0, NODES)
    plain = torch.exp(-15.0 * (f_vec.unsqueeze(0) - f_vec.unsqueeze(1)).abs()) - torch.eye(NODES)
    torch.testing.assert_close(weights_of(f_vec.tolist(), 1.0, 1.0, 15.0), plain)


def test_weakest_edge_does_not_underflow_at_the_largest_decay() -> None:
    decay = FeatureGraphConfig(edge_decay=40.0).edge_decay
    weights = weights_of([0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0], 0.0, 0.0, decay)
    assert weights[0, 1].item() == pytest.approx(math.exp(-80.0), rel=1e-4)


def test_half_precision_features_give_a_float32_graph() -> None:
    f_vec = torch.rand(2, NODES, generator=torch.Generator().manual_seed(0)).bfloat16()
    ones = torch.ones(2, dtype=torch.bfloat16)
    weights = feature_graph(f_vec, reliability_matrix(ones, ones, SIZES))
    assert weights.dtype == torch.float32
    assert torch.equal(weights, feature_graph(f_vec.float(), torch.ones(NODES, NODES)))


def test_gradient_is_that_of_finite_differences() -> None:
    f_vec = torch.tensor([[0.1, 0.25, 0.4, 0.55, 0.6, 0.7, 0.85, 0.95]], requires_grad=True)
    reliability = reliability_matrix(torch.tensor([0.4]), torch.tensor([0.7]), SIZES)
    mix = torch.rand(NODES, NODES, generator=torch.Generator().manual_seed(1))
    (gradient,) = torch.autograd.grad((feature_graph(f_vec, reliability, 5.0) * mix).sum(), f_vec)
    step = 1e-3
    for node in range(NODES):
        shift = torch.zeros(1, NODES)
        shift[0, node] = step
        ahead, behind = (feature_graph(f_vec.detach() + sign * shift, reliability, 5.0) * mix for sign in (1.0, -1.0))
        slope = (ahead.double().sum() - behind.double().sum()) / (2.0 * step)
        assert gradient[0, node].item() == pytest.approx(slope.item(), rel=2e-2, abs=2e-3)


@pytest.mark.filterwarnings("ignore:.torch.jit.script. is deprecated:DeprecationWarning")
def test_scripted_equals_eager() -> None:
    generator = torch.Generator().manual_seed(0)
    f_vec, r = torch.rand(4, NODES, generator=generator), torch.rand(4, 2, generator=generator)
    eager = reliability_matrix(r[:, 0], r[:, 1], SIZES)
    scripted = torch.jit.script(reliability_matrix)(r[:, 0], r[:, 1], SIZES)
    assert torch.equal(scripted, eager)
    assert torch.equal(torch.jit.script(feature_graph)(f_vec, scripted, 15.0), feature_graph(f_vec, eager, 15.0))


def test_config_counts_nodes_and_refuses_what_makes_no_graph() -> None:
    assert FeatureGraphConfig().nodes() == 120
    assert FeatureGraphConfig(image=1, point=2, velocity=3, trajectory=4).sizes() == [1, 2, 3, 4]
    with pytest.raises(SettingError, match="velocity: 0"):
        FeatureGraphConfig(velocity=0)
    for decay in (0.0, -1.0, 41.0, math.nan):
        with pytest.raises(SettingError, match="edge_decay"):
            FeatureGraphConfig(edge_decay=decay)
