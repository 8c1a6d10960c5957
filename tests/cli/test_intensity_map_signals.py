"""The command is interrupted or killed: nothing half made is taken for maps, and it can be run again."""

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from intensity_drive import intensity_drive

pytestmark = pytest.mark.slow
NAVTOOL = str(Path(sys.executable).with_name("navtool"))
PATIENCE_S = 60.0


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_run_that_is_ended_leaves_no_maps(
    write_recording: Callable[..., Path], tmp_path: Path, how: signal.Signals
) -> None:
    bag = write_recording("mcap", intensity_drive(clouds=400, speed_mps=0.005))
    out = tmp_path / "out" / "maps"
    command = [NAVTOOL, "intensity-map", str(bag), "--out", str(out), "--json"]
    # a shell's background job ignores SIGINT, and so would the programs that it starts
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)  # noqa: S603
    signal.signal(signal.SIGINT, before)
    begun_s = time.monotonic()
    while not (out.parent / ".maps.unfinished" / "arrays" / "000010.npz").exists():
        assert time.monotonic() - begun_s < PATIENCE_S
        time.sleep(0.02)
    running.send_signal(how)
    _, said = running.communicate(timeout=PATIENCE_S)
    assert running.returncode == (130 if how is signal.SIGINT else -how)
    assert "Traceback" not in said
    assert not out.exists()
    if how is signal.SIGINT:
        assert not list(out.parent.iterdir())
    again = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603
    assert json.loads(again.stdout)["maps"] == 400
    assert [path.name for path in out.parent.iterdir()] == ["maps"]
