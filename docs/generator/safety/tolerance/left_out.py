"""Constants of the governor and the pre-use test that need no row, each with the reason."""

LEFT_OUT: dict[str, dict[str, tuple[str, ...]]] = {
    "time constants and windows: what they leave of noise is in the rows": {
        "safety.watch.vacuum_signature": ("RATE_S", "RISING_MMHG"),
        "safety.watch.line_filter": ("FILTER_S", "ZERO_S"),
        "safety.watch.head_watch": ("SPEED_WINDOW_S",),
        "safety.watch.watch": ("LATE_S",),
        "safety.head.drive_force": ("SETTLING_S", "OFFSET_S"),
        "safety.head.head_vote": ("FORGET_S", "DRAW_SHARE"),
        "safety.head.home_zero": ("LEARN_S", "STILL_TICKS"),
        "procedure.cycle.check": ("VACUUM_SETTLE_S", "LEAK_AVERAGE_S"),
    },
    "parts of a threshold that has a row": {
        "safety.watch.vacuum_signature": ("REST_SETTLE_S", "REST_SHARE_PER_S", "FLOW_FADE"),
        "safety.watch.valve_axis": ("OVERDUE_SHARE", "SETTLE_S"),
        "safety.watch.head_watch": ("MODEL_LAG_S", "RUNAWAY_MM"),
        "safety.head.head_vote": ("BAD_TICKS", "SURPRISED_TICKS"),
        "safety.head.drive_force": ("BORNE_SHARE", "INERTIA_SHARE", "MOST_RATIO", "MM_PER_M"),
        "safety.patient_limit": (
            "LOST_CMH2O",
            "LOSING_CMH2O",
            "TRANSDUCER_CMH2O",
            "SINKING_SHARE",
            "SINKING_S",
        ),
        "safety.watch.patient_watch": (
            "LOSING_MORE_S",
            "SPO2_S",
            "LOW_FADE",
            "DEEP_CMH2O",
            "SINKING_LAG_S",
            "SINKING_CMH2O",
        ),
        "safety.watch.bus_watch": ("RESTLESS_SHARE", "RESTLESS_S"),
    },
    "decide only what a trip is named, or what follows from one": {
        "safety.watch.vacuum_signature": (
            "SLOW_SHARE_PER_S",
            "STEEP_RATIO",
            "SMALL_RATIO",
            "DECAY_SHARE_PER_S",
        ),
        "safety.head.head_vote": ("LEAD_MM", "DECIDED_RATIO"),
        "safety.head.drive_force": ("AGAINST_N",),
        "safety.watch.head_watch": ("PARTING_MM",),
    },
    "decide when something is judged or learnt, by far from what noise does": {
        "safety.watch.vacuum_signature": ("READY_SHARE", "BUILD_S"),
        "safety.watch.watch": ("VENTED_MMHG", "PARKED_MM"),
        "safety.governor.judgement": ("AWAY_MM", "OVERSHOOT_MM"),
        "safety.head.drive_force": ("STILL_MM_PER_S",),
        "safety.head.home_zero": ("HOME_MM",),
        "safety.head.motor_speed": ("SATURATED_SHARE",),
        "safety.patient_limit": ("LEAST_PEEP_CMH2O",),
        "safety.watch.contact_window": ("RELEASE_MM", "NOWHERE_MM"),
    },
    "count flags or the host's ticks, which no noise moves": {
        "safety.invalid_ticks": ("INVALID_TICKS", "NEVER_TICKS"),
        "safety.governor.judgement": ("LATE_TICKS", "LATE_SHARE"),
        "safety.watch.patient_watch": ("LINK_S",),
    },
    "of readings that have no noise in the twin: nothing can be shown": {
        "safety.watch.watch": ("BARRIER_MM",),
        "safety.governor.judgement": ("ABSENT_S", "REMAINING_S"),
        "safety.watch.patient_watch": ("HEART_RATE_S", "ROOM_CMH2O"),
        "safety.patient_limit": ("BREATH_CMH2O", "OPEN_S"),
    },
}
"""Names by module, below the reason."""
