"""A calibration as it is handed on: recording, parameter file, result."""

import hashlib
import io
from datetime import datetime

import numpy as np

from opensuction import __version__
from opensuction.hysteresis import modified_dahl
from opensuction.kernel.errors import InputError
from opensuction.result.calibration_result import (
    CalibrationResult,
    CheckedBound,
    FeedforwardEstimate,
    IdentifiedModels,
    ModelChoice,
    NoModels,
    ValidationErrors,
)
from opensuction.result.identification_result import FittedParameter
from opensuction.session.calibration import calibration_run
from opensuction.session.calibration.calibration_run import Calibrated
from opensuction.session.cycle import summary_section
from opensuction.session.cycle.equipment import EVERY
from opensuction.settings import calibration_section, identification_file
from opensuction.settings.calibration_section import (
    Branches,
    CalibratedMachine,
    Lines,
    Measured,
    Plays,
    Validation,
)
from opensuction.settings.identification_file import (
    FORMAT_VERSION,
    MODIFIED_DAHL,
    IdentificationFile,
    Identified,
    IdentifiedParameter,
    Quantity,
    Source,
)
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.rig import Recording

PARAMETER_FILE = "calibration.toml"
RECORDING_FILE = "recording.csv"
RECORDING_HEAD = (
    "# In-silico: excitation of a simulated machine, every tenth sample of what was fitted"
)


def recording_text(recorded: Recording) -> str:
    """A recording as CSV, which ``opensuction identify`` reads."""
    time_s = DT_S * np.arange(recorded.head_mm.size)
    columns = (time_s, recorded.head_mm, recorded.laser_mm, recorded.insertion_v)
    text = io.StringIO()
    text.write(f"{RECORDING_HEAD}\ntime_s,head_mm,tip_mm,motor_v\n")
    np.savetxt(text, np.column_stack(columns)[::EVERY], "%.4f", ",")
    return text.getvalue()


def parameter_file(calibrated: Calibrated, now: datetime) -> Identified:
    """Parameter file of a calibration, for `opensuction cycle --compensation`. now: in UTC.

    Raises ValueError where nothing was found.
    """
    found, validation = calibrated.found, calibrated.validation
    if found is None or validation is None:
        raise ValueError("nothing was found that could be written")
    content = recording_text(calibrated.whole).encode()
    rig, tip = calibrated.rig, found.laser_mm
    model = found.fit.model._asdict()
    return Identified(
        about=IdentificationFile(
            format_version=FORMAT_VERSION,
            software_version=__version__,
            date_utc=now.replace(microsecond=0),
            model="modified-dahl",
            method="variable-projection",
            compensator=calibrated.compensation,
            well_posed=found.fit.well_posed,
            rmse=found.fit.rmse_mm,
            rmse_unit="mm",
            rmse_percent_of_range=100.0 * found.fit.rmse_mm / float(np.ptp(tip)),
            recording=Source(
                file=RECORDING_FILE,
                sha256=hashlib.sha256(content).hexdigest(),
                samples=found.fit.samples,
                fitted_samples=found.fit.samples,
                input=_quantity("head_mm", found.head_mm),
                output=_quantity("tip_mm", tip),
            ),
        ),
        parameters={
            name: IdentifiedParameter(model[field], unit, [])
            for name, (field, unit) in MODIFIED_DAHL.items()
        }
        | {"initial_lag": IdentifiedParameter(found.fit.lag_mm, "mm", [])},
        servo=found.calibration.feedforward,
        driven=_driven(calibrated),
        measured=Measured(
            machine=CalibratedMachine(
                name=calibrated.equipment.machine_name,
                preset=rig.kind.preset,
                catheter_mm=rig.kind.catheter.outer_mm,
                seed=rig.seed,
            ),
            validation=validation,
            plays=calibration_section.write_section(Plays, found.plays.model),
            gap_width=calibration_section.write_section(Branches, found.calibration.width),
            lookup_table=calibration_section.write_section(Branches, found.calibration.table),
        ),
    )


def _driven(calibrated: Calibrated) -> Lines | None:
    drive = calibrated.drive
    if drive is None or drive.lines is None or drive.lines_model is None:
        return None
    return calibration_section.write(drive.lines, drive.lines_model)


def _quantity(column: str, values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Quantity:
    return Quantity(column, "mm", False, float(values.min()), float(values.max()))


def confirmed(calibrated: Calibrated, now: datetime) -> Calibrated:
    """The same, refused where ``opensuction cycle`` would not take its file."""
    if not calibrated.accepted:
        return calibrated
    nominal = calibrated.rig.profile.transmission
    try:
        file = parameter_file(calibrated, now)
        calibration_section.check(
            identification_file.to_calibration(file, PARAMETER_FILE), nominal, PARAMETER_FILE
        )
    except InputError as refused:
        return calibrated._replace(reasons=(f"A cycle would not take it: {refused}.",))
    return calibrated


def to_result(
    calibrated: Calibrated, now: datetime, seconds: float, path: str | None
) -> CalibrationResult:
    """The result of the command. path: of the parameter file; None where none is written."""
    equipment, rig = calibrated.equipment, calibrated.rig
    return CalibrationResult(
        accepted=calibrated.accepted,
        reasons=calibrated.reasons,
        machine=equipment.machine_name,
        patient=equipment.patient_name,
        catheter_mm=rig.kind.catheter.outer_mm,
        conduit_bend_rad=rig.kind.conduit.bend_rad,
        seed=equipment.seed,
        compensation=calibrated.compensation,
        choice=_choice(calibrated),
        in_silico=True,
        models=_models(calibrated),
        checks=tuple(
            CheckedBound(*entry, ok=entry.ok, bound=calibration_run.bound(entry))
            for entry in calibrated.checks
        ),
        samples=int(calibrated.whole.head_mm.size),
        recording_sha256=hashlib.sha256(recording_text(calibrated.whole).encode()).hexdigest(),
        parameter_file=path,
        version=__version__,
        date_utc=now.isoformat(timespec="seconds"),
        seconds=seconds,
    )


def _choice(calibrated: Calibrated) -> ModelChoice | None:
    """Comparison of the models; None where nothing was to choose."""
    drive = calibrated.drive
    if drive is None:
        return None
    return ModelChoice(
        model=drive.model,
        reason=drive.reason,
        errors_mm=drive.errors_mm,
        refused=drive.refused,
        driven_model=drive.lines_model,
        driven_rmse_mm=calibrated.driven_rmse_mm,
    )


def _models(calibrated: Calibrated) -> IdentifiedModels | NoModels:
    found, validation = calibrated.found, calibrated.validation
    if found is None or validation is None:
        return NoModels()
    model = found.fit.model
    values, gap_mm = model._asdict(), float(modified_dahl.gap_mm(model))
    return IdentifiedModels(
        model="modified-dahl",
        parameters={
            name: FittedParameter(values[field], unit, None)
            for name, (field, unit) in MODIFIED_DAHL.items()
        },
        plays=summary_section.plays(found.plays.model),
        servo=FeedforwardEstimate(*found.servo),
        gap_mm=gap_mm,
        gap_ratio=gap_mm / float(modified_dahl.gap_mm(calibrated.rig.profile.transmission)),
        rmse_mm=found.fit.rmse_mm,
        plays_rmse_mm=found.plays.rmse_mm,
        validation_rmse_mm=validation.model_rmse_mm,
        validation=_validation(validation, float(np.ptp(calibrated.second.laser_mm))),
    )


def _validation(validation: Validation, range_mm: float) -> ValidationErrors:
    """range_mm: of the tip in the second run."""
    return ValidationErrors(
        model_rmse_mm=validation.model_rmse_mm,
        model_percent_of_range=100.0 * validation.model_rmse_mm / range_mm,
        plays_rmse_mm=validation.plays_rmse_mm,
        plays_percent_of_range=100.0 * validation.plays_rmse_mm / range_mm,
        repeatability_mm=validation.repeatability_mm,
        servo_rmse_v=validation.servo_rmse_v,
        range_mm=range_mm,
    )
