"""Sensors from their parameters."""

from opensuction.twin.sensor import sensor
from opensuction.twin.sensor.sensor import Analogue, Sensors


def sensors(values: dict[str, float]) -> Sensors:
    """Sensors from their parameters."""
    return Sensors(
        carriage=sensor.exact(values["carriage_sensor_mm"])._replace(
            noise=values["carriage_noise_mm"], offset=values["carriage_zero_mm"]
        ),
        cam=sensor.exact(values["cam_encoder_rad"])._replace(
            noise=values["cam_noise_rad"], offset=values["cam_zero_rad"]
        ),
        vacuum=Analogue(
            noise=values["vacuum_noise_mmhg"],
            offset=values["vacuum_offset_mmhg"],
            drift=values["vacuum_drift_mmhg"],
            gain=values["vacuum_gain"],
            step=values["vacuum_step_mmhg"],
            lag_s=values["vacuum_lag_s"],
        ),
        current=Analogue(
            noise=values["current_noise_a"],
            offset=values["current_offset_a"],
            drift=values["current_drift_a"],
            gain=values["current_gain"],
            step=values["current_step_a"],
            lag_s=values["current_lag_s"],
        ),
        late_share=values["late_share"],
    )


def exact(sensors: Sensors) -> Sensors:
    """The same sensors, but they err by nothing but their resolution."""
    return Sensors(
        carriage=sensor.exact(sensors.carriage.step),
        cam=sensor.exact(sensors.cam.step),
        vacuum=sensor.exact(0.0),
        current=sensor.exact(0.0),
        late_share=0.0,
    )
