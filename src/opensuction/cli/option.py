"""What a person may say on the command line, once for every command that takes it."""

from pathlib import Path
from typing import Annotated

import typer

Machine = Annotated[
    str | None,
    typer.Option(
        help="Machine: bench, clinical, or a TOML file. Default: clinical, but bench for the "
        "protocol paper.",
        metavar="NAME|FILE",
        show_default=False,
    ),
]
Patient = Annotated[
    str | None,
    typer.Option(
        help="Patient at a clinical machine: adult-icu, adult-ards, child-10kg, neonate, or a TOML "
        "file. Default: adult-icu.",
        metavar="NAME|FILE",
        show_default=False,
    ),
]
Protocol = Annotated[
    str,
    typer.Option(
        help="Protocol: adult, paediatric, paper (bench only), or a TOML file.",
        metavar="NAME|FILE",
    ),
]
Catheter = Annotated[
    str | None,
    typer.Option(
        help="Catheter: 6fr, 8fr, 10fr, 12fr or 14fr. Default: 12fr for adults and the bench, 6fr "
        "for children and neonates.",
        show_default=False,
    ),
]
Conduit = Annotated[
    str | None,
    typer.Option(
        help="How the conduit is laid: standard, short or looped. Default: standard.",
        show_default=False,
    ),
]
Approach = Annotated[
    str,
    typer.Option(
        help="How the stopping point is found: travel (a taught length) or contact (the "
        "switch at the tip closes on the carina)."
    ),
]
Compensation = Annotated[
    str,
    typer.Option(
        help="Compensation of the backlash: none, direct-inverse (the paper's, as printed), "
        "exact-inverse, gap-width, lookup-table, prandtl-ishlinskii or preview, identified on the "
        "twin before use; or a parameter file (TOML) "
        "that opensuction identify wrote.",
        metavar="NAME|FILE",
    ),
]
TaughtLength = Annotated[
    float | None,
    typer.Option(
        help="Way from the tube's lower end to the carina that a person measured, in mm. "
        "Default: taught by hand on the twin, with a hand's error.",
        metavar="MM",
        show_default=False,
    ),
]
Faults = Annotated[
    list[str] | None,
    typer.Option(
        help="What goes wrong, up to twice: from the start on, or at an instant (@S or @PHASE+S), "
        "with a strength or its default. See below for names.",
        metavar="NAME[@S][=STRENGTH]",
        show_default=False,
    ),
]
Repeat = Annotated[
    int,
    typer.Option(
        help="Cycles of one simulated day: the first on request, the others by the controller's "
        "clock; secretions gather between them.",
        min=1,
        metavar="N",
    ),
]
Every = Annotated[
    float | None,
    typer.Option(
        help="Minutes from the start of one cycle to the next, with --repeat; at least 15.",
        metavar="MIN",
        show_default=False,
    ),
]
SelfCalibrate = Annotated[
    bool,
    typer.Option(
        "--self-calibrate",
        help="Measure the gap at each contact and compensate it in the next cycle; with --approach "
        "contact, --repeat and a compensation on plays (preview, prandtl-ishlinskii).",
    ),
]
GapScale = Annotated[
    float,
    typer.Option(
        help="Twin: every gap width is multiplied by this behind the controller's back, after "
        "identification and teaching, as if the conduit were laid otherwise; 0.5 to 1.5.",
        metavar="X",
    ),
]
Seed = Annotated[
    int,
    typer.Option(
        help="Draws the machine, the patient and the measurement noise.", min=0, max=2**32 - 1
    ),
]
Seeds = Annotated[
    int,
    typer.Option(
        help="How many machines are drawn for each plant, seeds 101 on.",
        min=1,
        max=100,
        metavar="N",
    ),
]
Pace = Annotated[
    float | None,
    typer.Option(
        help="Simulated seconds shown in one second; 0 is as fast as it goes. Default: 10 on "
        "a terminal, else 0.",
        show_default=False,
    ),
]
Out = Annotated[
    Path | None,
    typer.Option(help="Folder of this run. Default: runs/<time>-<seed>.", show_default=False),
]
Force = Annotated[bool, typer.Option("--force", help="Write into a folder that is not empty.")]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object on stdout and nothing else.")]
StudyOut = Annotated[
    Path | None,
    typer.Option(help="Folder. Default: runs/<time>-<command>.", show_default=False),
]
