# Names of the room for type checkers: `__init__.py` loads each when it is asked for.

from opensuction.hysteresis.catalogue.catalogue import CATALOGUE as CATALOGUE
from opensuction.hysteresis.named_model import Model as Model
from opensuction.hysteresis.named_model import model as model

__all__ = ["CATALOGUE", "Model", "model"]
