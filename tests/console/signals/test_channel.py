"""Every column can be drawn, and the useful ones say what they are."""

from opensuction.console.signals.channel import CHANNELS, Group, Origin, unit_of
from opensuction.runtime.loop import ROW_COLUMNS


def test_every_column_of_the_ring_can_be_asked_for() -> None:
    assert set(ROW_COLUMNS) <= set(CHANNELS)
    for name in ROW_COLUMNS:
        assert CHANNELS[name].columns == (ROW_COLUMNS.index(name),)


def test_units_come_from_the_names() -> None:
    assert unit_of("inputs.readings.head_mm") == "mm"
    assert unit_of("outputs.demand.reference_mm_per_s") == "mm/s"
    assert unit_of("inputs.readings.monitor.heart_rate_per_min") == "1/min"
    assert unit_of("state.compensation.plays_mm.3") == "mm"
    assert unit_of("state.alarms.clocks.held_s.0") == "s"
    assert unit_of("outputs.phase") == ""


def test_channels_of_a_group_stand_together() -> None:
    groups = [one.group for one in CHANNELS.values()]
    assert groups == sorted(groups, key=list(Group).index)


def test_the_tip_is_never_called_measured() -> None:
    tips = [one for one in CHANNELS.values() if one.is_tip or one.title.startswith("Tip")]
    assert len(tips) == 6
    assert Origin.MEASURED not in {one.origin for one in tips}


def test_what_single_precision_does_not_tell_apart_says_so() -> None:
    assert not CHANNELS["outputs.verdict.trips"].is_exact
    assert not CHANNELS["loop.time_s"].is_exact
    assert CHANNELS["inputs.readings.head_mm"].is_exact
