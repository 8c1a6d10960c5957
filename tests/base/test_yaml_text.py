"""YAML by people: safe, and no key twice."""

import pytest
import yaml

from navtool.base.yaml_text import load_yaml


@pytest.mark.parametrize(
    ("text", "line"),
    [("a: 1\nb: 2\na: 3\n", 1), ("b:\n  c: {d: 1, d: 1}\n", 2), ("- x: 1\n- y: 1\n  y: 2\n", 2)],
)
def test_a_key_that_stands_twice_is_named_with_its_place(text: str, line: int) -> None:
    with pytest.raises(yaml.YAMLError, match=rf"stands twice\s+in .*, line {line}"):
        load_yaml(text)


def test_everything_else_reads_as_usual() -> None:
    text = "base: &base {x: 1, y: 2}\nmore: {<<: *base, x: 3}\nsame: {x: {x: 1}, y: [x, x]}\n"
    assert load_yaml(text) == yaml.safe_load(text)
    with pytest.raises(yaml.YAMLError):
        load_yaml("!!python/object/apply:os.getcwd []")
