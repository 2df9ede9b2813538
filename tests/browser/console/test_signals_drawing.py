"""Rows as the page keeps and draws them: no peak is lost, and what is missing is no line."""

from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Page

pytestmark = pytest.mark.browser

MODULES = """
const { Buffer } = await import("/js/signals/buffer.js");
const { decimate } = await import("/js/signals/decimate.js");
const { Marks } = await import("/js/signals/marks.js");
const frame = (tick, time_s, values, more = {}) => ({
  rows: values.length, missed: 0, source: 1, tick, time_s, period_s: 0.001,
  steps: Uint32Array.from(values, (_, i) => i), values: [Float32Array.from(values)], ...more,
});
const channels = [{ name: "x", unit: "mm" }];
"""


def play(modules: "Page", script: str) -> Any:
    """What a script of the page's own modules gives."""
    return modules.evaluate(f"async () => {{ {MODULES} {script} }}")


def test_a_peak_of_one_tick_in_a_minute_is_drawn(modules: "Page") -> None:
    found = play(
        modules,
        """
        const buffer = new Buffer(channels);
        const values = new Array(60000).fill(0);
        values[31415] = 7; values[27182] = -3;
        for (let i = 0; i < 60; i += 1) {
            buffer.push(frame(1000 * i, 100 + i, values.slice(1000 * i, 1000 * i + 1000)));
        }
        const [times, line] = decimate(buffer, [0], 100, 160, 500);
        return [times.length, Math.max(...line), Math.min(...line), times[line.indexOf(7)],
                times.every((one, i) => i === 0 || one >= times[i - 1])];
        """,
    )
    points, most, least, at_s, is_sorted = found
    assert points <= 2 * 501
    assert (most, least) == (7, -3)
    assert at_s == pytest.approx(131.415, abs=0.12)
    assert is_sorted


def test_rows_that_are_missing_are_no_line(modules: "Page") -> None:
    found = play(
        modules,
        """
        const buffer = new Buffer(channels);
        buffer.push(frame(0, 10, [1, 1, 1]));
        buffer.push(frame(500, 10.5, [2, 2, 2], { missed: 497 }));
        buffer.push(frame(503, 10.503, [NaN, 3]));
        const [, line] = decimate(buffer, [0], 10, 11, 500);
        return [line, buffer.missed, buffer.received];
        """,
    )
    assert found == [[1, 1, 1, None, 2, 2, 2, None, 3], 497, 8]


def test_rows_that_come_again_are_taken_once(modules: "Page") -> None:
    found = play(
        modules,
        """
        const buffer = new Buffer(channels);
        buffer.push(frame(0, 10, [1, 2, 3, 4]));
        buffer.push(frame(2, 10.002, [3, 4, 5, 6]));
        return [buffer.received, Array.from(buffer.tick.slice(0, 6)), buffer.skipped];
        """,
    )
    assert found == [6, [0, 1, 2, 3, 4, 5], 0]


def test_ticks_that_the_loop_missed_are_counted(modules: "Page") -> None:
    found = play(
        modules,
        """
        const buffer = new Buffer(channels);
        buffer.push(frame(0, 10, [1, 2, 3], { steps: Uint32Array.of(0, 1, 5) }));
        return [buffer.skipped, buffer.received];
        """,
    )
    assert found == [3, 3]


def test_what_is_so_already_is_no_other_mark(modules: "Page") -> None:
    found = play(
        modules,
        """
        const marks = new Marks();
        const phase = (time_s, name) => marks.add({ what: "phase", time_s, name, detail: "" });
        const alarm = (time_s, detail) => marks.add({ what: "alarm", time_s, name: "jam", detail });
        const told = [
            phase(1, "parked"), phase(5, "checking"), phase(3, "parked"), phase(5, "checking"),
            alarm(6, "raised"), alarm(7, "raised"), alarm(8, "ended"), alarm(9, "raised"),
        ];
        marks.add({ what: "source", name: "source", detail: "", time_s: 20, until_s: 12 });
        told.push(phase(20.1, "checking"));
        return [told, marks.phases(0, 30).map((one) => [one.name, one.from_s])];
        """,
    )
    told, phases = found
    assert told == [True, True, False, False, True, False, True, True, True]
    assert phases == [["parked", 1], ["checking", 5], ["checking", 20.1]]
