# Names of the room for type checkers: `__init__.py` loads each when it is asked for.

from opensuction.hysteresis.catalogue.catalogue import CATALOGUE as CATALOGUE
from opensuction.hysteresis.named_model import Model as Model
from opensuction.hysteresis.named_model import model as model
from opensuction.hysteresis.oscillator.motion import HystereticOscillator as HystereticOscillator
from opensuction.hysteresis.oscillator.output_error import OscillatorFit as OscillatorFit
from opensuction.hysteresis.oscillator.output_error import fit_oscillator as fit_oscillator

__all__ = [
    "CATALOGUE",
    "HystereticOscillator",
    "Model",
    "OscillatorFit",
    "fit_oscillator",
    "model",
]
