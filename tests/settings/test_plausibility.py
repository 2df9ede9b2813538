import pytest

from opensuction.controller import machine_profile
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.kernel.errors import InputError
from opensuction.settings import plausibility
from opensuction.simulation import bench


def test_every_identified_machine_is_plausible_to_itself() -> None:
    for name in machine_profile.PROFILES:
        rig = bench.rig(name, 1)
        model = bench.identify(rig).calibration.model
        plausibility.check(model, rig.profile.transmission, "file")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"velocity_gain": 0.3}, "should be from 11.1 to 33.3 mm"),
        ({"velocity_gain": 2.0}, "gap"),
        ({"slope": 0.5}, "slope"),
        ({"offset_mm": 40.0}, "another"),
        ({"offset_mm": -60.0}, "another"),
    ],
)
def test_another_machines_model_is_refused(changes: dict[str, float], words: str) -> None:
    with pytest.raises(InputError, match=words) as raised:
        plausibility.check(PUBLISHED._replace(**changes), PUBLISHED, "my.toml")
    assert str(raised.value).startswith("my.toml: ")
