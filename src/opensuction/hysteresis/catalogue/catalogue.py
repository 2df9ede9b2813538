"""Every hysteresis model by name.

A new model is one entry here, written in the file of its family, and one case in
``tests/conformance/hysteresis_cases.py``. Where the entry has a form, identification, comparison
and their commands offer the model.
"""

from opensuction.hysteresis.catalogue.duhem_family import BOUC_WEN, DAHL, MODIFIED_DAHL
from opensuction.hysteresis.catalogue.hysteresis_model import HysteresisModel
from opensuction.hysteresis.catalogue.play_family import (
    MAXWELL_SLIP,
    PLAY,
    PRANDTL_ISHLINSKII,
    PREISACH,
)
from opensuction.hysteresis.catalogue.readout_model import (
    GENERALISED,
    PLAY_READOUT,
    RESIDUAL_READOUT,
)

CATALOGUE: dict[str, HysteresisModel] = {
    model.name: model
    for model in (
        MODIFIED_DAHL,
        DAHL,
        BOUC_WEN,
        PLAY,
        PRANDTL_ISHLINSKII,
        PREISACH,
        PLAY_READOUT,
        GENERALISED,
        RESIDUAL_READOUT,
        MAXWELL_SLIP,
    )
}
"""Models by the name a person types."""
