"""A small page with one of everything, for tests."""

import numpy as np

from opensuction.report.sheet import Curve, Level, Plot, Section, Sheet, Table


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
                    ),
                    Plot("A loop", "mm", "mm", (Curve("loop", wave, x=np.cos(time_s)),)),
                ),
            ),
        ),
    )
