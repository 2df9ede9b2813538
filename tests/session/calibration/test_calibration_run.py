"""A calibration confirms a sound machine and refuses a poor recording of it, with the reason."""

from datetime import UTC, datetime

import numpy as np
import pytest

from opensuction.kernel.errors import InputError
from opensuction.report import sheet
from opensuction.report.calibration import calibration_page
from opensuction.report.calibration.calibration_page import Excitation
from opensuction.result.plain import to_json
from opensuction.session.calibration import calibration_file, calibration_run
from opensuction.session.calibration.calibration_run import VALIDATION_RUN, Calibrated
from opensuction.session.choice import CalibrationChoice, RigChoice
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.rig import IDENTIFICATION_RUN, Recording, Rig

CHOICE = CalibrationChoice(RigChoice("bench", seed=5))
NOW = datetime(2026, 11, 21, 12, tzinfo=UTC)

Sound = tuple[Rig, Recording, Recording]


@pytest.fixture(scope="module")
def sound() -> Sound:
    rig = rigs.rig("bench", CHOICE.rig.seed)
    return (
        rig,
        rigs.recording(rig, IDENTIFICATION_RUN),
        rigs.recording(rig, VALIDATION_RUN),
    )


def judged(
    sound: Sound, first: Recording, second: Recording, compensation: str = "preview"
) -> Calibrated:
    equipment = calibration_run.resolve(CHOICE)
    found = calibration_run.judged(equipment, compensation, sound[0], first, second)
    return calibration_file.confirmed(found, NOW)


def excitations(found: Calibrated) -> tuple[Excitation, Excitation]:
    first, second = (
        Excitation(one.head_mm, one.laser_mm, DT_S) for one in (found.first, found.second)
    )
    return first, second


def reason(found: Calibrated) -> str:
    assert not found.accepted
    return " ".join(found.reasons)


def test_a_sound_machine_is_accepted_and_the_second_run_has_other_noise(sound: Sound) -> None:
    found = judged(*(sound, *sound[1:]))
    assert found.accepted
    assert not np.array_equal(sound[1].laser_mm, sound[2].laser_mm)
    assert found.validation is not None
    # The laser's .08 mm of noise is in it, and in the difference of two readings twice.
    assert 0.08 <= found.validation.plays_rmse_mm <= 0.11
    assert 0.08 * 2**0.5 <= found.validation.repeatability_mm <= 0.13


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("patient", ["adult-icu", "neonate"])
def test_bedside_machines_are_accepted_whatever_their_tube(seed: int, patient: str) -> None:
    found = calibration_run.run(CalibrationChoice(RigChoice(patient=patient, seed=seed), "preview"))
    assert found.reasons == ()
    assert np.ptp(found.first.head_mm) == pytest.approx(200.0, abs=1.0)  # the whole stroke


def test_a_tip_that_does_not_repeat_is_refused(sound: Sound) -> None:
    # A conduit that was moved between the runs: the first fits as well as ever.
    moved = sound[2]._replace(laser_mm=sound[2].laser_mm + 1.0)
    words = reason(judged(sound, sound[1], moved))
    assert "RMSE of the plays on the second run" in words
    assert "RMS difference of both runs is 1." in words


def test_a_gap_of_another_conduit_is_refused(sound: Sound) -> None:
    rig = sound[0]
    model = rig.profile.transmission
    profile = rig.profile._replace(
        transmission=model._replace(decay_per_mm=0.5 * model.decay_per_mm)
    )
    found = judged((rig._replace(profile=profile), *sound[1:]), *sound[1:])
    assert "Gap over the machine's nominal one is 0.4" in reason(found)


def test_an_encoder_of_another_scale_is_refused_though_the_fit_is_good(sound: Sound) -> None:
    first, second = (r._replace(head_mm=1.3 * r.head_mm) for r in sound[1:])
    assert "parameters.slope is 0.7" in reason(judged(sound, first, second))


def test_a_run_that_was_broken_off_is_refused(sound: Sound) -> None:
    cut = Recording(*(column[:25_000] for column in sound[1]))
    words = reason(judged(sound, cut, sound[2]))
    assert "Time of the first run is 25 s, should be at least 38 s" in words
    nothing = Recording(*(column[:0] for column in sound[1]))
    found = judged(sound, nothing, nothing)
    assert "Stroke of the first run is 0 mm" in reason(found)
    result = calibration_file.to_result(found, NOW, 1.0, None)
    page = calibration_page.page(result, *excitations(found), found.predicted)
    assert "Refused" in sheet.render(page)


def test_a_tip_against_the_head_and_a_dead_motor_are_refused(sound: Sound) -> None:
    against = sound[1]._replace(laser_mm=-sound[1].laser_mm)
    assert "does not determine the machine" in reason(judged(sound, against, sound[2]))
    dead = sound[1]._replace(insertion_v=-sound[1].insertion_v)
    assert "fall with speed" in reason(judged(sound, dead, sound[2]))


def test_the_papers_inverse_is_refused_where_it_would_jump(sound: Sound) -> None:
    assert "no continuous inverse" in reason(judged(sound, *sound[1:], "direct-inverse"))


def test_no_compensation_needs_no_calibration() -> None:
    with pytest.raises(InputError, match="none"):
        calibration_run.resolve(CHOICE._replace(compensation="none"))


def test_a_machine_is_driven_by_a_model_with_lines_where_one_is_asked_for() -> None:
    found = calibration_run.run(CHOICE._replace(compensation="model-preview"))
    found = calibration_file.confirmed(found, NOW)
    assert found.accepted
    file = calibration_file.parameter_file(found, NOW)
    assert file.about.compensator == "model-preview"
    assert file.driven is not None
    assert found.drive is not None
    assert file.driven.model == found.drive.model
    result = calibration_file.to_result(found, NOW, 1.0, None)
    # The laser's .08 mm of noise is in it, and what creep leaves.
    assert result.choice is not None
    assert result.choice.driven_rmse_mm is not None
    assert 0.08 <= result.choice.driven_rmse_mm <= 0.12
    page = sheet.render(calibration_page.page(result, *excitations(found), found.predicted))
    assert found.drive.reason.split(":")[0] in page


def test_a_laser_that_reads_no_number_is_a_refusal_on_every_page(sound: Sound) -> None:
    blind = sound[2].laser_mm.copy()
    blind[5] = np.nan
    found = judged(sound, sound[1], sound[2]._replace(laser_mm=blind))
    assert "RMSE of the plays on the second run is nan mm" in reason(found)
    result = calibration_file.to_result(found, NOW, 1.0, None)
    data = to_json(result)
    assert data["validation"]["plays_rmse_mm"] is None
    assert [check["value"] is None for check in data["checks"] if not check["ok"]] == [True] * 3
    page = sheet.render(calibration_page.page(result, *excitations(found), found.predicted))
    assert "Refused" in page
