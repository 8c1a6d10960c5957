"""Events files: the same events in both formats and in every form of time, and every faulty line named at once."""

import csv
import io
import json
from datetime import UTC, datetime
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.base.errors import DatasetsError
from navtool.datasets.labels.event_time import time_ns
from navtool.datasets.labels.events import Bag, Event, read_events

ZERO = 1_432_227_731_250_000_000
BAGS = (
    Bag("outdoor/run1.bag", ZERO, ZERO + 500_000_000, ZERO + 60_000_000_000),
    Bag("outdoor/run2.bag", ZERO + 10**12, ZERO + 10**12, ZERO + 10**12 + 60_000_000_000),
    Bag("indoor/run2.bag", ZERO + 2 * 10**12, ZERO + 2 * 10**12, ZERO + 2 * 10**12 + 60_000_000_000),
)
HEADER = "bag,start,end,outcome,reason\n"


def read(tmp_path: Path, text: str, name: str = "events.csv") -> tuple[Event, ...]:
    path = tmp_path / name
    path.write_text(text)
    return read_events(path, BAGS)


def faults(tmp_path: Path, text: str, name: str = "events.csv") -> list[str]:
    with pytest.raises(DatasetsError) as caught:
        read(tmp_path, text, name)
    assert caught.value.where == str(tmp_path / name)
    assert caught.value.cure
    return caught.value.what.splitlines()


EVENTS = st.lists(
    st.tuples(
        st.sampled_from([bag.name for bag in BAGS]),
        st.integers(500, 30_000),
        st.integers(0, 29_000),
        st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), max_size=8),
    ),
    max_size=5,
)


@given(drawn=EVENTS, order=st.permutations(["bag", "start", "end", "outcome", "reason"]))
def test_both_formats_give_the_same_events(
    tmp_path_factory: pytest.TempPathFactory, drawn: list[tuple[str, int, int, str]], order: list[str]
) -> None:
    folder = tmp_path_factory.getbasetemp()
    rows = [
        {"bag": bag, "start": start / 1000, "end": (start + length) / 1000, "outcome": 0, "reason": reason}
        for bag, start, length, reason in drawn
    ]
    table = io.StringIO()
    writer = csv.DictWriter(table, order)
    writer.writeheader()
    writer.writerows(rows)
    (folder / "events.csv").write_text(table.getvalue(), encoding="utf-8", newline="")
    (folder / "events.json").write_text(json.dumps(rows), encoding="utf-8")
    from_csv, from_json = (read_events(folder / f"events.{kind}", BAGS) for kind in ("csv", "json"))
    zero = {bag.name: bag.zero_ns for bag in BAGS}
    assert [(e.bag, e.start_ns, e.end_ns, e.outcome, e.reason) for e in from_json] == [
        (bag, zero[bag] + start * 10**6, zero[bag] + (start + length) * 10**6, 0, reason or "event")
        for bag, start, length, reason in drawn
    ]
    assert [(e.bag, e.start_ns, e.end_ns, e.reason) for e in from_csv] == [
        (e.bag, e.start_ns, e.end_ns, e.reason) for e in from_json
    ]


@given(ns=st.integers(0, 60 * 10**9))
def test_every_form_of_a_time_is_exact(ns: int) -> None:
    absolute = ZERO + ns
    assert time_ns(f"{ns // 10**9}.{ns % 10**9:09d}", ZERO) == absolute
    assert time_ns(f"{absolute // 10**9}.{absolute % 10**9:09d}", 0) == absolute
    assert time_ns(absolute, 0) == time_ns(str(absolute), 0) == absolute
    whole_us = absolute // 1000 * 1000
    moment = datetime.fromtimestamp(whole_us // 10**9, UTC).replace(microsecond=whole_us // 1000 % 10**6)
    assert time_ns(moment.isoformat(), 0) == whole_us
    assert time_ns(moment.isoformat().replace("+00:00", "Z"), 0) == whole_us


@pytest.mark.parametrize(
    "value", ["-1", "1e12", "123456789012345.5", "nan", "", "soon", "2015-05-21T17:02:11", None, True]
)
def test_what_is_no_time_is_refused(value: object) -> None:
    with pytest.raises(ValueError, match=r"neither|no time zone"):
        time_ns(value, ZERO)


def test_a_recording_answers_to_its_full_name_its_file_and_its_stem(tmp_path: Path) -> None:
    for name in ("outdoor/run1.bag", "run1.bag", "run1"):
        (event,) = read(tmp_path, f"{HEADER}{name},1,2.5,0,hit a root\n")
        assert (event.bag, event.reason, event.outcome) == ("outdoor/run1.bag", "hit a root", 0)
        assert (event.start_ns, event.end_ns) == (ZERO + 10**9, ZERO + 2_500_000_000)


def test_quotes_spaces_blank_lines_and_a_byte_order_mark_are_taken(tmp_path: Path) -> None:
    text = '\ufeffbag , start,end,outcome,reason\n\nrun1, 1 ,2, 0 ,"mud, deep"\n,,,,\n'
    (event,) = read(tmp_path, text)
    assert (event.reason, event.line) == ("mud, deep", "line 3")


def test_all_faulty_lines_are_named_at_once_with_their_numbers(tmp_path: Path) -> None:
    text = HEADER + "\n".join(
        [
            "run1,1,2,0,fine",
            "run3,1,2,0,unknown bag",
            "run2,1,2,0,two of them",
            "run1,5,4,0,backwards",
            "run1,1,2,2,outcome",
            "run1,soon,2,0,time",
            "run1,1,2,0",
            "run1,90,95,0,after the end",
            "run1,1.5,3,1,contradicts the first",
        ]
    )
    told = faults(tmp_path, text)
    assert told[0] == "8 faults"
    by_line = {line.strip().split(":")[0]: line for line in told[1:]}
    assert "unknown bag 'run3'" in by_line["line 3"]
    assert "outdoor/run1.bag" in by_line["line 3"]
    assert "indoor/run2.bag, outdoor/run2.bag; name which" in by_line["line 4"]
    assert "ends 1 s before it starts" in by_line["line 5"]
    assert "outcome '2' is neither success (1) nor failure (0)" in by_line["line 6"]
    assert "start 'soon'" in by_line["line 7"]
    assert "4 values under 5 columns" in by_line["line 8"]
    assert "lies outside of outdoor/run1.bag, which lasts from 0.500 s to 60.000 s" in by_line["line 9"]
    assert "line 2 and line 10 overlap" in told[-1]


def test_an_endless_list_of_faults_is_cut(tmp_path: Path) -> None:
    told = faults(tmp_path, HEADER + "run9,1,2,0,x\n" * 30)
    assert told[0] == "30 faults"
    assert told[-1].strip() == "and 10 more"


def test_touching_and_agreeing_portions_contradict_nothing(tmp_path: Path) -> None:
    text = "run1,1,2,0,a\nrun1,2,3,1,touches\nrun1,1.5,2,0,agrees\nindoor/run2.bag,1,2,1,another bag\n"
    assert len(read(tmp_path, HEADER + text)) == 4
    assert "overlap" in faults(tmp_path, HEADER + "run1,1,1,0,an instant\nrun1,1,2,1,around it\n")[-1]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        ("bag;start;end;outcome;reason\n", "missing bag, start, end, outcome, reason"),
        ("bag,start,end,outcom,reason\n", "unknown column 'outcom' (did you mean 'outcome'?); missing outcome"),
        ("bag,start,end,outcome,reason,bag\n", "repeated bag"),
        (HEADER + 'run1,1,2,0,"never closed\n', "unexpected end of data"),
    ],
)
def test_a_broken_table_is_refused(tmp_path: Path, text: str, said: str) -> None:
    assert said in "\n".join(faults(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "is not JSON"),
        ("{}", "is not a list"),
        ("[1]", "entry 1: is not an object"),
        ('[{"bag": "run1", "bag": "run1"}]', "a key is repeated"),
        ('[{"bag": "run1", "start": 1, "end": 2, "outcome": 0}]', "entry 1: missing reason"),
        ('[{"bag": 1, "start": 1, "end": 2, "outcome": 0, "reason": ""}]', "unknown bag 1"),
        ('[{"bag": "run1", "start": NaN, "end": 2, "outcome": 0, "reason": ""}]', "start nan is neither"),
        ('[{"bag": "run1", "start": 1, "end": 2, "outcome": true, "reason": ""}]', "outcome True"),
        ('[{"bag": "run1", "start": 1, "end": 2, "outcome": 0, "reason": null}]', "reason None is not a line of text"),
        ('[{"bag": "run1", "start": 1, "end": 2, "outcome": 0, "reason": "a\\nb"}]', "is not a line of text"),
    ],
)
def test_broken_json_is_refused(tmp_path: Path, text: str, said: str) -> None:
    assert said in "\n".join(faults(tmp_path, text, "events.json"))


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    (tmp_path / "latin.csv").write_bytes("bag,start,end,outcome,reason\nrun1,1,2,0,Gruß\n".encode("latin-1"))
    for name, said in (("absent.csv", "cannot be read"), ("latin.csv", "is not UTF-8"), ("events.txt", "neither .csv")):
        if name.endswith(".txt"):
            (tmp_path / name).write_text(HEADER)
        with pytest.raises(DatasetsError, match=said):
            read_events(tmp_path / name, BAGS)
