"""Options of the command line: each defined once, under the name of the field that it fills."""

from typing import Any

import typer

from opensuction.cli import completion
from opensuction.cli.recording_option import RECORDING_OPTIONS, join, take_name

NAME_OR_FILE = "NAME|FILE"


OPTIONS: dict[str, Any] = RECORDING_OPTIONS | {
    "machine": take_name(
        f"Machine: {join(completion.MACHINES)}, or a TOML file. Default: clinical, but bench for "
        "the protocol paper.",
        completion.MACHINES,
        NAME_OR_FILE,
    ),
    "patient": take_name(
        f"Patient for whom a clinical machine is set up: {join(completion.PATIENTS)}, or a TOML "
        "file. Default: adult-icu.",
        completion.PATIENTS,
        NAME_OR_FILE,
    ),
    "protocol": take_name(
        "Protocol: adult, paediatric, paper (bench only), or a TOML file. Default: by the "
        "patient's age; paper on the bench.",
        completion.PROTOCOLS,
        NAME_OR_FILE,
    ),
    "catheter": take_name(
        f"Catheter: {join(completion.CATHETERS)}. Default: 12fr for adults and the bench, 6fr for "
        "children and neonates.",
        completion.CATHETERS,
    ),
    "conduit": take_name(
        f"How the conduit is laid: {join(completion.CONDUITS)}. Default: standard.",
        completion.CONDUITS,
    ),
    "approach": take_name(
        "How the stopping point is found: travel (a taught length) or contact (the switch at the "
        "tip closes on the carina). Default: travel.",
        completion.APPROACHES,
    ),
    "compensation": take_name(
        "Compensation of the backlash: none, direct-inverse (the paper's, as printed), "
        "exact-inverse, gap-width, lookup-table, prandtl-ishlinskii, preview or model-preview (any "
        "model of plays), identified on the twin before use; or, for a cycle, a parameter file "
        "(TOML) that opensuction identify or calibrate wrote; or, to calibrate, best: the one "
        "whose model predicts best. Default: preview, to calibrate best.",
        completion.COMPENSATIONS,
        NAME_OR_FILE,
    ),
    "taught_mm": typer.Option(
        "--taught",
        help="Way from the tube's lower end to the carina that a person measured, in mm; the "
        "protocol is fitted to it, or its depths are held against it. "
        "Default: taught by hand on the twin, with a hand's error.",
        metavar="MM",
    ),
    "faults": typer.Option(
        "--fault",
        help="What goes wrong, up to twice: from the start on, or at an instant (@S or @PHASE+S), "
        "with a strength or its default. See below for names.",
        metavar="NAME[@S][=STRENGTH]",
        autocompletion=completion.complete_from(completion.FAULTS),
    ),
    "preoxygenation": take_name(
        "What a person answers before each cycle when the machine asks for pre-oxygenation (adults "
        "and children): confirmed (the twin's ventilator gives 100 % oxygen for 60 s, and goes on) "
        "or skipped. Default: confirmed.",
        completion.PREOXYGENATION,
    ),
    "repeat": typer.Option(
        help="Cycles of one simulated day: the first on request, the others by the controller's "
        "clock; secretions gather between them, and a person looks at the patient after every "
        "third. Default: 1.",
        min=1,
        metavar="N",
        show_default=False,
    ),
    "every_min": typer.Option(
        "--every",
        help="Minutes from the start of one cycle to the next, with --repeat; 15 to 1440.",
        metavar="MIN",
    ),
    "self_calibrates": typer.Option(
        "--self-calibrate",
        help="Measure gap and offset of the tip in each cycle, where the tip passes the light "
        "barrier and by --approach contact at the carina, and compensate them in the next one; "
        "with --repeat and any compensation but none.",
    ),
    "gap_scale": typer.Option(
        help="Twin: every gap width is multiplied by this behind the controller's back, after "
        "identification and teaching, as if the conduit were laid otherwise; 0.5 to 1.5. "
        "Default: 1.",
        metavar="X",
        show_default=False,
    ),
    "tip_shift_mm": typer.Option(
        "--tip-shift",
        help="Twin: the tip lies this much deeper (below 0: shallower) behind the controller's "
        "back, after identification and teaching, as if the catheter were clamped anew; -10 to "
        "10. Default: 0.",
        metavar="MM",
        show_default=False,
    ),
    "seed": typer.Option(
        help="Draws the machine, the patient and the measurement noise. Default: 1.",
        min=0,
        max=2**32 - 1,
        metavar="N",
        show_default=False,
    ),
    "spread": typer.Option(
        help="How many times as far from the nominal ones as usual machine and patient are drawn, "
        "up to 3 standard deviations; 0 to 3. Default: 1.",
        min=0.0,
        max=3.0,
        metavar="X",
        show_default=False,
    ),
    "seeds": typer.Option(
        help="How many machines and patients are drawn, 1 to 100; each is a seed of its own.",
        min=1,
        max=100,
        metavar="N",
    ),
    "days": typer.Option(
        help="Days of 30 cycles without a fault, of each patient by each approach, searched for "
        "harm: 2, and none with --hazard or --table.",
        min=0,
        max=10_000,
        metavar="N",
    ),
    "search": typer.Option(
        help="Runs of a search for harm in each hazard: instants about the edges of phases, "
        "strengths, machines and patients, towards whatever was worst. 0: no search.",
        min=0,
        max=100_000,
        metavar="N",
    ),
    "hazard": typer.Option(
        help="One hazard of the table alone, by its identifier. Default: all of them.",
        metavar="ID",
        show_default=False,
    ),
    "cycles": typer.Option(
        help="How many cycles. The first ones of a longer trial are those of a shorter one.",
        min=1,
        max=10_000_000,
        metavar="N",
        show_default=False,
    ),
    "fault_count": typer.Option(
        "--faults",
        help="What comes to each cycle: none, single (a fault) or double (two). Default: single.",
        metavar="none|single|double",
        autocompletion=completion.complete_from(completion.FAULT_COUNTS),
        show_default=False,
    ),
    "cohort": take_name(
        f"Whose patients: {join(completion.COHORTS)}. Default: presets, all of them in turn.",
        completion.COHORTS,
    ),
    "workers": typer.Option(
        help="Processes that share the work. Default: one for each core.",
        min=1,
        max=1024,
        metavar="N",
        show_default=False,
    ),
    "lives": typer.Option(
        help="How many lives, each of a seed of its own. Default: 100.",
        min=1,
        max=10_000_000,
        metavar="N",
        show_default=False,
    ),
    "life_seed": typer.Option(
        "--seed",
        help="Seed of the first life. Default: 1.",
        min=0,
        metavar="N",
        show_default=False,
    ),
    "life_faults": typer.Option(
        "--faults",
        help="Kinds of faults that are drawn, with commas between them, or given several times. "
        "Default: all of them.",
        metavar="KINDS",
        autocompletion=completion.complete_from(completion.LIFE_FAULTS),
        show_default=False,
    ),
    "life_cycles": typer.Option(
        "--cycles",
        help="Cycles of each life, one after the other, each as soon as the patient has rested, "
        "with faults of its own. Default: 1.",
        min=1,
        max=30,
        metavar="N",
        show_default=False,
    ),
    "play_life": typer.Option(
        "--play",
        help="Play the life of this seed alone, show its course, and write its timeline and its "
        "recordings; with the --faults and --cycles of its campaign.",
        metavar="SEED[@VERSION]",
        show_default=False,
    ),
    "resume": typer.Option(
        "--resume",
        help="Go on with the trial in the folder --out where it was; it knows its own options.",
    ),
    "play": typer.Option(
        help="Play the cycle of this number again, alone, and write its report; with the options "
        "of its trial.",
        min=1,
        metavar="NUMBER",
        show_default=False,
    ),
    "pace": typer.Option(
        help="Simulated seconds shown in one second; 0 is as fast as it goes. Default: 10 on "
        "a terminal, else 0.",
        metavar="X",
    ),
    "table": typer.Option(help="Hazard table (TOML). Default: the project's own.", metavar="FILE"),
    "folder": typer.Argument(
        metavar="NAME|DIR",
        help="The machine, by its name or the folder that its processes share.",
        show_default=False,
    ),
    "node_faults": typer.Option(
        "--node-fault",
        help="Fault of one node of emulated drives, or of all of them. See below for names.",
        metavar="NAME[@NODE][=STRENGTH]",
    ),
    "mend": typer.Option(
        "--mend", help="First mend all that is broken, and forget what was to come; the bus stays."
    ),
    "latency_ms": typer.Option(
        help="What a message takes in the mean, 0 to 500 ms.", metavar="MS", show_default=False
    ),
    "jitter_ms": typer.Option(
        help="It takes up to this more, or less.", metavar="MS", show_default=False
    ),
    "lost_percent": typer.Option(
        help="Messages that never come.", metavar="PERCENT", show_default=False
    ),
    "clear": typer.Option("--clear", help="Remove what is kept; it is compiled anew when needed."),
    "wanted": typer.Option(
        "--cycles",
        help="How many cycles; 0: none is started. Default: 1.",
        min=0,
        max=10_000,
        metavar="N",
        show_default=False,
    ),
    "apart_min": typer.Option(
        "--every",
        help="Minutes from the start of one cycle to the next, 1 to 1440; the patient's rest after "
        "a pass may make it longer. Default: 30.",
        min=1.0,
        max=1440.0,
        metavar="MIN",
        show_default=False,
    ),
    "name": typer.Option(
        help="Name of the machine: several may run side by side. Default: twin.",
        metavar="NAME",
        show_default=False,
    ),
    "drives_name": typer.Option(
        "--name",
        help="Name of the drives: several may play side by side. Default: drives.",
        metavar="NAME",
        show_default=False,
    ),
    "device": typer.Option(
        help="Device file (TOML): bus, nodes, units and limits. Default: that of the emulated "
        "drives.",
        metavar="FILE",
    ),
    "bus_device": typer.Option(
        "--device",
        help="Machine on a CANopen bus, by its device file (TOML), instead of the twin in a "
        "process of its own: emulated drives, started with the same machine, patient and seed, or "
        "with serve real ones.",
        metavar="FILE",
    ),
    "device_act": typer.Argument(help="Act: check, home.", metavar="ACT", show_default=False),
    "device_path": typer.Argument(
        help="Device file (TOML): bus, nodes, units and limits.",
        metavar="FILE",
        show_default=False,
    ),
    "moves": typer.Option(
        "--move", help="Move each axis a small way, too, and draw a vacuum; asks first."
    ),
    "anew": typer.Option(
        "--anew", help="End what an earlier run of this name has left, its patient included."
    ),
    "request": typer.Argument(
        help="The button. See below for names.",
        metavar="REQUEST",
        autocompletion=completion.complete_from(completion.REQUESTS),
        show_default=False,
    ),
    "who": typer.Option(
        help="Who asks, for the record. Default: the user's name.",
        metavar="NAME",
        show_default=False,
    ),
    "host": typer.Option(
        help="Address where the console listens. Default: 127.0.0.1, this computer alone; any "
        "other needs --certificate and --key.",
        metavar="ADDRESS",
        show_default=False,
    ),
    "port": typer.Option(
        help="Port where the console listens, 1 to 65535. Default: 8080.",
        metavar="PORT",
        show_default=False,
    ),
    "certificate": typer.Option(
        help="Certificate of the console in PEM, with those above it; with --key. Then it speaks "
        "HTTPS.",
        metavar="FILE",
    ),
    "key": typer.Option(
        help="Private key of the certificate in PEM, without a password.", metavar="FILE"
    ),
    "out": typer.Option(
        help="Folder of the results. Default: one of its own under runs/.", metavar="DIR"
    ),
    "force": typer.Option(
        "--force", help="Write into a folder that is not empty, over a file that is there."
    ),
    "as_json": typer.Option("--json", help="One JSON object on stdout and nothing else."),
}
"""By the name of the field that an option fills; the same one for every command that has it."""
OF_A_FILE = (
    "input",
    "output",
    "driven",
    "measured",
    "time",
    "input_unit",
    "output_unit",
    "sheet",
    "columns",
)
"""Fields whose words stand in a file, not in the names of files."""
