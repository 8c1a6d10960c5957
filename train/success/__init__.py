"""Samples, loss and figures of models that predict success along a trajectory."""
