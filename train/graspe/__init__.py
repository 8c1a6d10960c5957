"""The GrASPE network, one encoder a file."""
