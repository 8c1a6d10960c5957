"""Nested plain values as one table."""


def flatten(value: object, prefix: str = "") -> dict[str, object]:
    """The leaves of nested dicts by their dotted names, such as ``trainer.epochs``; lists are leaves."""
    if not isinstance(value, dict):
        return {prefix: value}
    leaves: dict[str, object] = {}
    for key, entry in value.items():
        leaves |= flatten(entry, f"{prefix}.{key}" if prefix else str(key))
    return leaves
