"""Faults of a running machine do no harm, are recorded, and replay to the bit."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.machine import port
from opensuction.machine.twin import twin_faults
from opensuction.machine.twin.live_judge import LiveJudge
from opensuction.records.entry import Outcome
from opensuction.records.records import Records
from opensuction.session.cycle import resolution
from tests.runtime.kept import replayed, told_of
from tests.runtime.simulated_room import SimulatedRoom, simulated

FAULTS = ("encoder-frozen@inserting+0.2", "power-lost@suctioning", "message-lost@inserting+0.3")
"""Of a sensor, of the drives' energy, of the link."""


@pytest.fixture
def room(tmp_path: Path) -> Iterator[SimulatedRoom]:
    with simulated() as made:
        made.record(tmp_path)
        yield made


def test_cycles_with_faults_replay_and_the_oracle_finds_no_harm(
    room: SimulatedRoom, tmp_path: Path
) -> None:
    witness = LiveJudge(port.open_truth(room.folder), room.cap_mm)
    for fault in FAULTS:
        twin_faults.heal(room.folder, room.host)
        assert room.wait(lambda: witness.look() > 0 and room.phase() in RESTING, 60.0)
        witness.begin()
        twin_faults.inject(room.folder, [resolution.parse(fault)], room.host)
        room.begin_cycle(witness.look)
        assert room.wait(lambda: (witness.look(), room.phase() in RESTING)[1], 60.0), fault
        assert room.phase() in (Phase.HALTED, Phase.PARKED)
    assert room.wait(room.is_out)
    verdict = witness.verdict()
    assert verdict.harm == ()
    assert not verdict.inside_at_end
    assert verdict.missed_ticks == 0
    assert len({one.condition for one in verdict.told}) > 1
    room.end_recorder()
    recordings = sorted(tmp_path.glob("*.mcap"))
    for recording in recordings:
        found = replayed(recording)
        assert found.identical, (recording.name, found.first)
    kinds = {kind for one in recordings for kind, _ in told_of(one)}
    assert {"trip", "alarm", "phase", "request"} <= kinds
    with Records.open(str(room.folder / "records.db")) as records:
        cycles = records.history.list_cycles("twin-1")
        assert len(cycles) >= len(FAULTS)
        assert Outcome.ABORTED in {one.outcome for one in cycles}
        assert records.audit().broken is None
