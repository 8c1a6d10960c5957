"""First weights that keep the spread of the inputs through a network's layers."""

from torch import nn


def spread_relu(module: nn.Module) -> None:
    """Draw the weights of every linear and convolutional layer below for a ReLU after it (He et al. 2015)."""
    for layer in module.modules():
        if isinstance(layer, nn.Linear | nn.Conv1d | nn.Conv2d):
            nn.init.kaiming_normal_(layer.weight, nonlinearity="relu")
            if layer.bias is not None:
                nn.init.zeros_(layer.bias)


def spread_sigmoid(layer: nn.Linear) -> None:
    """Draw the weights of a layer whose sigmoid follows (Glorot and Bengio 2010)."""
    nn.init.xavier_normal_(layer.weight)
    nn.init.zeros_(layer.bias)
