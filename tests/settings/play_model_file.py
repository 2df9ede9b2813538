"""A parameter file of a model of plays, as `opensuction identify` writes it."""

from datetime import UTC, datetime

import numpy as np

from opensuction.hysteresis.bank.play_lines import PlayLines
from opensuction.hysteresis.modified_dahl import ModifiedDahl
from opensuction.settings import calibration_section
from opensuction.settings.identification_file import (
    IdentificationFile,
    Identified,
    IdentifiedParameter,
    Quantity,
    Source,
)

NOMINAL = ModifiedDahl(slope=0.95, velocity_gain=0.8, decay_per_mm=0.085, offset_mm=-7.0)
LINES = PlayLines(
    widths_mm=np.array([16.0, 20.0, 24.0]),
    lows_mm=np.zeros(3),
    cell_mm=50.0,
    gains=np.array([[0.3, 0.32], [0.3, 0.31], [0.33, 0.34]]),
    decay_mm=1.0,
    lag=0.0,
    offset_mm=-7.0,
)


def of_preisach() -> Identified:
    """A file of a Preisach model."""
    return Identified(
        about=IdentificationFile(
            format_version=3,
            software_version="0.1.0",
            date_utc=datetime(2026, 11, 24, 12, tzinfo=UTC),
            model="preisach",
            method="non-negative",
            compensator="model-preview",
            well_posed=False,
            rmse=0.09,
            rmse_unit="mm",
            rmse_percent_of_range=0.1,
            recording=Source(
                file="bench.csv",
                sha256="0123456789abcdef" * 4,
                samples=8000,
                fitted_samples=8000,
                input=Quantity("head_mm", "mm", False, 0.0, 100.0),
                output=Quantity("tip_mm", "mm", False, -6.0, 80.0),
            ),
        ),
        parameters={"cell_4_0": IdentifiedParameter(1.2, "mm", [])},
        servo=None,
        driven=calibration_section.write(LINES, "preisach"),
        nominal=NOMINAL,
    )
