"""A small page with one of everything, for tests."""

import numpy as np

from opensuction.report.sheet import Curve, Lane, Level, Plot, Section, Sheet, Stretch, Table


def sheet() -> Sheet:
    time_s = np.linspace(0.0, 20.0, 2001)
    wave = np.sin(time_s)
    return Sheet(
        title="A study",
        verdict="2 of 2 claims hold",
        good=True,
        lead="What it came to.",
        run=(("seeds", "1 to 5"),),
        sections=(
            Section(
                "First part",
                ("A sentence.",),
                (
                    Table(
                        "Numbers", ("name", "value", "ok"), (("a", 1.5, True), ("b", None, False))
                    ),
                ),
                (
                    Plot(
                        "Over time",
                        "Time (s)",
                        "mm",
                        (Curve("wave", wave), Curve("other", -wave, "head", dashed=True)),
                        time_s,
                        "Two waves.",
                        (Level(0.5, "half"),),
                        shades=(Stretch("first half", "in", 0.0, 10.0),),
                        span=(0.0, 20.0),
                    ),
                    Plot("A loop", "mm", "mm", (Curve("loop", wave, x=np.cos(time_s)),)),
                    Plot(
                        "What was on",
                        "Time (s)",
                        "",
                        (),
                        lanes=(
                            Lane("pump", (Stretch("on", "in", 2.0, 9.0),)),
                            Lane("alarms", (Stretch("late", "notice", 8.0, 8.0),), named=True),
                        ),
                        span=(0.0, 20.0),
                    ),
                ),
            ),
        ),
    )
