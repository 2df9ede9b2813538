"""Equipment of a cycle for its result: catheter and conduit, the machine's model, its settings."""

from opensuction.control.compensation import CompensationKind
from opensuction.hysteresis import modified_dahl, prandtl_ishlinskii
from opensuction.hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from opensuction.result.cycle_result import Teaching
from opensuction.result.identification_result import PlaysModel, TransmissionModel
from opensuction.result.plain import Json
from opensuction.session.cycle.cycle_run import Prepared
from opensuction.settings.calibration_section import Plays, write_section
from opensuction.twin.machine.catheter import CATHETERS, ROUTES, Catheter, Conduit, lay


def teaching(prepared: Prepared) -> Teaching | None:
    """Source of the protocol's depth, and its error."""
    if prepared.taught_mm is None:
        return None
    by_hand = prepared.resolved.choice.taught_mm is None
    return Teaching(
        source="hand" if by_hand else "given",
        error_mm=prepared.taught_mm - prepared.rig.machine.airway.carina_mm,
    )


def plays(model: PrandtlIshlinskii) -> PlaysModel:
    """The plays that `prandtl-ishlinskii` and `preview` work with, and their gap."""
    section = write_section(Plays, model)
    return PlaysModel(**section._asdict(), gap_mm=prandtl_ishlinskii.gap_mm(model))


def identification(prepared: Prepared) -> TransmissionModel | None:
    """Model of the compensator and its source; None for a compensator that needs no model."""
    found, file = prepared.identification, prepared.resolved.parameter_file
    model, feedforward = prepared.calibration.model, prepared.calibration.feedforward
    data = TransmissionModel(
        model="modified-dahl",
        **model._asdict(),
        gap_mm=float(modified_dahl.gap_mm(model)),
        rmse_mm=None,
        well_posed=bool(modified_dahl.is_monotone(model)),
        driven_model=None,
        samples=None,
        feedforward_v_s_per_mm=feedforward.velocity_v_s_per_mm,
        friction_v=feedforward.friction_v,
        file=None,
        recording=None,
        recording_sha256=None,
    )
    if found is not None:
        fitted = found.plays
        return data._replace(
            rmse_mm=found.fit.rmse_mm,
            samples=found.fit.samples,
            plays=plays(fitted.model)._replace(
                rmse_mm=fitted.rmse_mm, well_posed=fitted.well_posed
            ),
        )
    if file is None:
        return None
    by_plays = prepared.resolved.compensation == CompensationKind.MODEL_PREVIEW
    return data._replace(
        rmse_mm=file.about.rmse,
        driven_model=file.driven.model if by_plays and file.driven is not None else None,
        samples=file.about.recording.fitted_samples,
        file=prepared.resolved.choice.compensation,
        recording=file.about.recording.file,
        recording_sha256=file.about.recording.sha256,
    )


def catheter_name(catheter: Catheter) -> str:
    """Name of a catheter, or its diameters where it has none."""
    for name, known in CATHETERS.items():
        if known == catheter:
            return name
    return f"{catheter.outer_mm:g} mm, bore {catheter.bore_mm:g} mm"


def conduit_name(catheter: Catheter, conduit: Conduit) -> str:
    """Name of a conduit for a catheter, or its measures where it has none."""
    for name in ROUTES:
        if lay(name, catheter) == conduit:
            return name
    return (
        f"{conduit.length_mm:g} mm, bore {conduit.bore_mm:g} mm, bent by {conduit.bend_rad:g} rad"
    )


def sections(prepared: Prepared) -> dict[str, Json]:
    """Settings of the run for the last part of the report: title to names and values."""
    settings = prepared.loop.controller
    return {
        "Protocol": prepared.protocol._asdict(),
        "Plan": {
            "preload_s": settings.plan.preload_s,
            "dwell_s": settings.plan.dwell_s,
            "gap_lead_s": settings.plan.gap_lead_s,
            "nothing_comes_s": settings.plan.pace.nothing_comes_s,
            **settings.plan.motion._asdict(),
        },
        "Governor limits": settings.limits._asdict() | {"tip": settings.limits.tip._asdict()},
        "Insertion servo": settings.insertion_servo._asdict(),
        "Catheter": prepared.rig.kind.catheter._asdict(),
        "Conduit": prepared.rig.kind.conduit._asdict(),
        "Twin (drawn by the seed)": dict(prepared.rig.values),
    }
