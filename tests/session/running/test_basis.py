"""Basis of settings, written and read back."""

import json
from pathlib import Path

import pytest

from opensuction.control.compensation import CompensationKind
from opensuction.controller import configuration, setup
from opensuction.controller.configuration import Configuration
from opensuction.kernel.errors import InputError
from opensuction.procedure.planning import clinical
from opensuction.session.choice import RigChoice
from opensuction.session.running import basis
from opensuction.session.running.basis import Basis, Person
from opensuction.simulation import rig as rigs

KIND = CompensationKind.LOOKUP_TABLE


def at_bed(patient: str = "adult-icu", kind: CompensationKind = KIND) -> Basis:
    rig = rigs.rig("clinical", 1, nominal=True, patient=patient)
    calibration = rigs.uncalibrated(rig.profile)
    able = setup.abilities(rig.profile, kind, calibration, rig.site)
    name = "adult" if patient.startswith("adult") else "paediatric"
    return Basis(
        version=1,
        profile=rig.profile,
        site=rig.site,
        compensation=kind,
        calibration=calibration,
        calibrated_by="nominal",
        by_contact=False,
        template=name,
        protocol_name=name,
        protocol=clinical.fitted(clinical.TEMPLATES[name], able, rig.site, by_contact=False),
        is_teaching=False,
        taught_by="nominal",
        rig=RigChoice("clinical", patient),
        person=Person(rig.machine.patient.weight_kg, rig.machine.patient.tube_length_mm),
    )


def settings_of(given: Basis) -> str:
    made = setup.settings(
        given.profile, given.protocol, given.compensation, given.calibration, False, given.site
    )
    return configuration.to_json(
        Configuration(made, setup.branches(given.compensation, given.calibration))
    )


def test_settings_made_of_what_was_read_are_the_same_bit_for_bit(tmp_path: Path) -> None:
    given = at_bed()
    basis.write(tmp_path, given)
    found = basis.read(tmp_path)
    assert settings_of(found) == settings_of(given)
    assert found._replace(calibration=given.calibration) == given
    assert basis.to_json(found) == basis.to_json(given)


def test_what_is_not_there_or_torn_or_out_of_range_is_refused_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not say what its settings are made from"):
        basis.read(tmp_path)
    text = basis.to_json(at_bed())
    wrong = json.loads(text)
    wrong["protocol"]["vacuum_mmhg"] = 500.0
    for torn in (text[:-9], "[]", "{}", json.dumps(wrong)):
        with pytest.raises(InputError) as caught:
            basis.from_json(torn)
        assert "\n" not in str(caught.value)
