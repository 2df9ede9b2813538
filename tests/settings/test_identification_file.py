"""The parameter file: written, read back, and refused in every way it can be wrong."""

import math
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from opensuction.controller.calibration import PLAIN_PD, Feedforward
from opensuction.hysteresis.modified_dahl import PUBLISHED, ModifiedDahl
from opensuction.kernel.errors import InputError
from opensuction.settings import identification_file
from opensuction.settings.identification_file import (
    IdentificationFile,
    Identified,
    IdentifiedParameter,
    Quantity,
    Source,
)
from tests.settings.play_model_file import LINES, NOMINAL, of_preisach

MONOTONE = ModifiedDahl(slope=0.97, velocity_gain=0.4, decay_per_mm=0.04, offset_mm=-7.0)


def identified(model: ModifiedDahl = PUBLISHED, compensator: str = "exact-inverse") -> Identified:
    return Identified(
        about=IdentificationFile(
            format_version=1,
            software_version="0.1.0",
            date_utc=datetime(2026, 11, 21, 12, tzinfo=UTC),
            model="modified-dahl",
            method="variable-projection",
            compensator=compensator,
            well_posed=model.slope > 2.0 * model.velocity_gain,
            rmse=0.83,
            rmse_unit="mm",
            rmse_percent_of_range=1.1,
            recording=Source(
                file='bench "3".csv',
                sha256="0123456789abcdef" * 4,
                samples=800,
                fitted_samples=400,
                input=Quantity("head_mm", "mm", False, 0.0, 100.0),
                output=Quantity("tip_mm", "mm", False, -6.0, 90.0),
            ),
        ),
        parameters={
            "slope": IdentifiedParameter(
                model.slope, "mm/mm", [model.slope - 0.01, model.slope + 0.01]
            ),
            "velocity_gain": IdentifiedParameter(model.velocity_gain, "mm/mm", []),
            "decay": IdentifiedParameter(model.decay_per_mm, "1/mm", []),
            "offset": IdentifiedParameter(model.offset_mm, "mm", []),
            "initial_lag": IdentifiedParameter(3.0, "mm", []),
        },
        servo=None,
    )


def written(folder: Path, content: Identified | str) -> Path:
    path = folder / "machine.toml"
    text = content if isinstance(content, str) else identification_file.to_toml(content)
    path.write_text(text, encoding="utf-8")
    return path


def refusal(folder: Path, content: Identified | str) -> str:
    """What a compensator's user is told about a file."""
    path = written(folder, content)
    with pytest.raises(InputError) as raised:
        identification_file.to_calibration(identification_file.load(path), path)
    message = str(raised.value)
    assert len(message.splitlines()) == 1
    assert str(path) in message
    return message


def test_what_is_written_is_read_back_to_the_last_bit(tmp_path: Path) -> None:
    assert identification_file.load(written(tmp_path, identified())) == identified()


@given(
    value=st.floats(allow_nan=False, allow_infinity=False),
    name=st.text(st.characters(exclude_categories=["Cs"]), max_size=20),
)
def test_any_number_and_any_name_survive_the_file(
    tmp_path_factory: pytest.TempPathFactory, value: float, name: str
) -> None:
    original = identified()
    about = original.about._replace(recording=original.about.recording._replace(file=name))
    changed = original._replace(
        about=about, parameters={"offset": IdentifiedParameter(value, name, [value, value])}
    )
    folder = tmp_path_factory.getbasetemp()
    assert identification_file.load(written(folder, changed)) == changed


def test_calibration_is_the_model_with_the_papers_servo(tmp_path: Path) -> None:
    found = identification_file.to_calibration(identified(), tmp_path)
    assert found.model == PUBLISHED
    assert found.feedforward == PLAIN_PD


def test_a_servo_section_gives_the_feedforward(tmp_path: Path) -> None:
    servo = "\n[servo]\nvelocity_v_s_per_mm = 1.2\nfriction_v = 0.9\n"
    path = written(tmp_path, identification_file.to_toml(identified()) + servo)
    found = identification_file.to_calibration(identification_file.load(path), path)
    assert found.feedforward == Feedforward(velocity_v_s_per_mm=1.2, friction_v=0.9)


def test_a_servo_section_is_checked(tmp_path: Path) -> None:
    servo = "\n[servo]\nvelocity_v_s_per_mm = 1.2\nfriction_v = -0.9\n"
    assert "friction_v" in refusal(tmp_path, identification_file.to_toml(identified()) + servo)


CHANGES = [
    ("format_version = 1", "format_version = 4", "update opensuction"),
    ("format_version = 1\n", "", "no format_version"),
    ("format_version = 1", "format_version = true", "no format_version"),
    ("samples = 800\n", "", "recording.samples is missing"),
    ('rmse_unit = "mm"', 'rmse_unit = "mm"\ncolour = "red"', "unknown key colour"),
    ("well_posed = false", "well_posed = true", "say the opposite"),
    ('model = "modified-dahl"', 'model = "play-sum"', "no compensator uses"),
    ('compensator = "exact-inverse"', 'compensator = "exact"', "exact-inverse"),
    ('compensator = "exact-inverse"', 'compensator = "none"', "exact-inverse"),
    ('compensator = "exact-inverse"', 'compensator = "direct-inverse"', "would jump"),
    ('column = "head_mm"\nunit = "mm"', 'column = "head_mm"\nunit = "deg"', "in deg"),
    ('column = "tip_mm"\nunit = "mm"', 'column = "tip_mm"\nunit = ""', "no known unit"),
    ('value = 0.077\nunit = "1/mm"', 'value = 0.077\nunit = "1/cm"', "should be '1/mm'"),
    ('rmse_unit = "mm"', 'rmse_unit = "m"', "rmse_unit is 'm'"),
    ("value = 0.077", "value = 0.0", "decay_per_mm"),
    ("value = 0.077", "value = nan", "parameters.decay: value"),
    ("value = 0.077", 'value = "0.077"', "parameters.decay: value"),
    ("value = 0.9677", "value = 1.2", "slope.ci95"),
    ("[parameters.decay]", "[parameters.dekay]", "did you mean 'decay'"),
    ("0123456789abcdef", "0123", "sha256"),
    ("date_utc = 2026", 'date_utc = "yesterday" # ', "date_utc"),
]


@pytest.mark.parametrize(("before", "after", "words"), CHANGES, ids=[c[1][:50] for c in CHANGES])
def test_a_file_changed_for_the_worse_is_refused(
    tmp_path: Path, before: str, after: str, words: str
) -> None:
    text = identification_file.to_toml(identified())
    assert before in text
    assert words in refusal(tmp_path, text.replace(before, after, 1))


def test_a_missing_parameter_and_missing_parameters_are_refused(tmp_path: Path) -> None:
    complete = identified()
    without = {name: found for name, found in complete.parameters.items() if name != "offset"}
    assert "parameters.offset is missing" in refusal(
        tmp_path, complete._replace(parameters=without)
    )
    assert "no section parameters" in refusal(tmp_path, complete._replace(parameters={}))


def test_another_settings_file_is_no_parameter_file(tmp_path: Path) -> None:
    assert "no parameter file" in refusal(tmp_path, "travel_mm = 90.0\n")


def test_a_continuous_model_may_use_the_printed_compensator(tmp_path: Path) -> None:
    content = identified(MONOTONE, "direct-inverse")
    assert identification_file.to_calibration(content, tmp_path).model == MONOTONE


def test_an_infinite_interval_is_refused(tmp_path: Path) -> None:
    text = identification_file.to_toml(identified())
    start = text.index("ci95 = [")
    end = text.index("]", start)
    assert "ci95" in refusal(tmp_path, text[:start] + f"ci95 = [0.0, {math.inf}" + text[end:])


def test_a_model_of_plays_is_read_back_and_drives(tmp_path: Path) -> None:
    original = of_preisach()
    path = written(tmp_path, original)
    assert identification_file.load(path) == original
    found = identification_file.to_calibration(identification_file.load(path), path)
    assert found.model == NOMINAL
    np.testing.assert_array_equal(found.lines.gains, LINES.gains)


UNDRIVEN = [
    ("gains = ", "gaines = ", "driven: unknown key gaines"),
    ("0.32", "-0.32", "driven cannot drive a head: it is not monotone: a gain is -0.32"),
    ("0.32", "nan", "driven: gains"),
    ("16.0", "-16.0", "driven.widths_mm holds -16, none should be below 0"),
    ("cell_mm = 50.0", "cell_mm = 0.0", "driven: cell_mm"),
    ("velocity_gain = 0.8", "velocity_gain = -0.8", "modified_dahl: velocity_gain"),
    ("[modified_dahl]", "[modified_doll]", "unknown key modified_doll"),
    ("[driven]", "[drive]", "unknown key drive"),
    ('"model-preview"', '"preview"', "model-preview"),
    ('undriven = ""', 'undriven = "its loops drift"', "drives no head: its loops drift"),
    (
        'model = "preisach"',
        'model = "bouc-wen"',
        "a search whose steps no tick could bound; identif",
    ),
    ('column = "head_mm"\nunit = "mm"', 'column = "head_mm"\nunit = "deg"', "in deg"),
]


@pytest.mark.parametrize(("before", "after", "words"), UNDRIVEN)
def test_a_model_of_plays_changed_for_the_worse_is_refused(
    tmp_path: Path, before: str, after: str, words: str
) -> None:
    text = identification_file.to_toml(of_preisach())
    assert before in text
    assert words in refusal(tmp_path, text.replace(before, after, 1))


def test_a_model_of_plays_needs_both_of_its_sections(tmp_path: Path) -> None:
    assert "has no section driven" in refusal(tmp_path, of_preisach()._replace(driven=None))
    lacking = of_preisach()._replace(nominal=None)
    assert "has no section modified_dahl" in refusal(tmp_path, lacking)
