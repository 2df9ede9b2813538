"""Rows of a machine are followed from one control process to the next, and none is left out."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from opensuction.console.signals.source import SignalSource
from opensuction.kernel.record import Array
from opensuction.safety.condition import Condition
from tests.console.signals.block import find
from tests.console.written_machine import WrittenMachine
from tests.controller.bedside import at_bed

TICK = find("tick")


def ticks(*found: Array) -> list[int]:
    return [int(tick) for rows in found for tick in rows[:, TICK]]


@pytest.fixture
def machine(tmp_path: Path) -> Iterator[WrittenMachine]:
    """It ticks when it is told to."""
    made = WrittenMachine(tmp_path, "")
    yield made
    made.stop()


def test_rows_come_once_and_all_of_them(tmp_path: Path, machine: WrittenMachine) -> None:
    source, seen = SignalSource(tmp_path), []
    for count in (0, 3, 1, 0, 250):
        for _ in range(count):
            machine.tick()
        seen += [block.rows for block in source.read().blocks]
    assert ticks(*seen) == list(range(1, 256))


def test_what_was_overwritten_is_told(tmp_path: Path, machine: WrittenMachine) -> None:
    source = SignalSource(tmp_path)
    source.read()
    for _ in range(1500):
        machine.tick()
    blocks = source.read().blocks
    assert sum(block.missed for block in blocks) > 400
    assert sum(block.missed + len(block.rows) for block in blocks) == 1500


def test_another_control_process_is_followed(tmp_path: Path, machine: WrittenMachine) -> None:
    source = SignalSource(tmp_path)
    first = source.read()
    assert first.facts is not None
    assert first.facts.source == 1
    for _ in range(5):
        machine.tick()
    machine.stop()
    after = WrittenMachine(tmp_path, "", run="20261123T130000-another")
    after.tick()
    found = source.read()
    assert found.facts is not None
    assert (found.facts.source, found.facts.run) == (2, "20261123T130000-another")
    by_source = [(block.source, len(block.rows)) for block in found.blocks]
    assert by_source == [(1, 5), (2, 2)]
    assert [one.source for one in found.occurrences if one.kind == "phase"] == [2]
    after.stop()


def test_phases_and_alarms_are_told_with_their_instant(
    tmp_path: Path, machine: WrittenMachine
) -> None:
    source = SignalSource(tmp_path)
    source.read()
    machine.tick()
    machine.set({"outputs.phase": 3.0, "outputs.signals.present": 1 << Condition.CATHETER_JAMMED})
    machine.tick()
    found = source.read()
    told = {one.kind: one for one in found.occurrences}
    rows = found.blocks[0].rows
    assert told["phase"].name == "inserting"
    assert told["phase"].tick == 3
    assert told["phase"].time_s == rows[1, 0]
    assert (told["alarm"].name, told["alarm"].detail) == ("catheter-jammed", "raised")
    assert told["alarm"].sentence == "the catheter is jammed"
    assert told["alarm"].priority == "high"


def test_what_nobody_asked_for_is_left_out(tmp_path: Path, machine: WrittenMachine) -> None:
    source = SignalSource(tmp_path)
    for _ in range(40):
        machine.tick()
    source.skip()
    machine.tick()
    found = source.read()
    assert ticks(*(block.rows for block in found.blocks)) == [42]
    assert not found.occurrences


def test_the_past_goes_on_to_where_all_are(tmp_path: Path, machine: WrittenMachine) -> None:
    source = SignalSource(tmp_path)
    for _ in range(700):
        machine.tick()
    source.skip()
    past = source.before(source.next - 600)
    assert past is not None
    seen = []
    while (found := past.read()) is not None:
        seen.append(found.blocks[0].rows)
        if past.is_over:
            break
        machine.tick()
        source.read()
    machine.tick()
    seen += [block.rows for block in source.read().blocks]
    assert ticks(*seen) == list(range(102, 704))


@pytest.mark.usefixtures("machine")
def test_the_tip_goes_by_the_machines_own_transmission(tmp_path: Path) -> None:
    block = SignalSource(tmp_path).read().blocks[0]
    assert 0.5 < block.gain < 1.0
    loop, _ = at_bed("neonate")
    tip = loop.controller.limits.tip
    assert (block.gain, block.offset_mm) == (tip.gain, tip.offset_mm)


def test_no_machine_is_no_error(tmp_path: Path) -> None:
    source = SignalSource(tmp_path)
    source.skip()
    assert source.read() == (None, (), ())
    assert source.before(1) is None
