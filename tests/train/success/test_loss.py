"""Laws of the masked squared error."""

import math

import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from navtool.train.success.loss import masked_mse

entries = st.lists(
    st.tuples(st.floats(0.0, 1.0, width=32), st.sampled_from([0.0, 1.0]), st.booleans()), min_size=1, max_size=40
)


@given(entries)
@settings(deadline=None, max_examples=100)
def test_is_the_mean_over_the_known_entries(rows: list[tuple[float, float, bool]]) -> None:
    prediction, target, known = (torch.tensor(column).view(1, -1) for column in zip(*rows, strict=True))
    errors = [(p - t) ** 2 for p, t, k in rows if k]
    expected = sum(errors) / len(errors) if errors else 0.0
    assert math.isclose(masked_mse(prediction, target, known).item(), expected, rel_tol=1e-5, abs_tol=1e-7)


def test_unknown_entries_have_no_influence_whatever_they_hold() -> None:
    prediction = torch.tensor([[0.2, 0.9], [0.4, 0.7]], requires_grad=True)
    known = torch.tensor([[True, False], [False, True]])
    loss = masked_mse(prediction, torch.tensor([[1.0, math.nan], [math.inf, 0.0]]), known)
    (gradient,) = torch.autograd.grad(loss, prediction)
    assert math.isclose(loss.item(), (0.64 + 0.49) / 2, rel_tol=1e-6)
    torch.testing.assert_close(gradient, torch.tensor([[-0.8, 0.0], [0.0, 0.7]]))


def test_nothing_known_gives_zero_with_zero_gradients() -> None:
    prediction = torch.rand(3, 10, requires_grad=True)
    loss = masked_mse(prediction, torch.ones(3, 10), torch.zeros(3, 10, dtype=torch.bool))
    (gradient,) = torch.autograd.grad(loss, prediction)
    assert loss.item() == 0.0
    assert torch.equal(gradient, torch.zeros(3, 10))


def test_half_precision_predictions_are_judged_in_float32() -> None:
    prediction = torch.rand(3, 10).bfloat16()
    loss = masked_mse(prediction, torch.ones(3, 10), torch.ones(3, 10, dtype=torch.bool))
    assert loss.dtype == torch.float32
    torch.testing.assert_close(loss, (prediction.float() - 1.0).square().mean())
