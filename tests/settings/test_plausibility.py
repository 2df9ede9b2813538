import pytest

from opensuction.controller import machine_profile
from opensuction.controller.calibration import PLAIN_PD, assume_nominal
from opensuction.hysteresis.modified_dahl import PUBLISHED
from opensuction.kernel.errors import InputError
from opensuction.settings import calibration_section
from opensuction.simulation import rig as rigs


def test_every_identified_machine_is_plausible_to_itself() -> None:
    for name in machine_profile.PROFILES:
        rig = rigs.rig(name, 1)
        calibration_section.check(rigs.identify(rig).calibration, rig.profile.transmission, "file")


@pytest.mark.requirement("OS-R28")
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
        calibration_section.check(
            assume_nominal(PUBLISHED._replace(**changes), PLAIN_PD), PUBLISHED, "my.toml"
        )
    assert str(raised.value).startswith("my.toml: ")


def test_plays_and_curves_of_another_machine_are_refused_though_the_model_fits() -> None:
    own = assume_nominal(PUBLISHED, PLAIN_PD)
    calibration_section.check(own, PUBLISHED, "my.toml")
    wide = own.plays._replace(thresholds_mm=2.0 * own.plays.thresholds_mm)
    far = own.table._replace(first_mm=own.table.first_mm + 20.0)
    lines = own.lines._replace(widths_mm=2.0 * own.lines.widths_mm)
    for changed, words in (
        (own._replace(plays=wide), "the gap of the plays is 44.4 mm"),
        (own._replace(table=far), "the zero of the recording"),
        (own._replace(lines=lines), "the gap of driven is 44.4 mm"),
        (own._replace(lines=own.lines._replace(offset_mm=20.0)), "the zero of the recording"),
    ):
        with pytest.raises(InputError, match=words):
            calibration_section.check(changed, PUBLISHED, "my.toml")
