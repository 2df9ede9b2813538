"""Every number that the paper prints, in its order: held against the twin, set, or why neither.

Left out: numbers of the introduction (patients, hours), references, and axes of figures.
"""

from typing import Final, Literal, NamedTuple

CLAIM: Final = "claim"
SETTING: Final = "set"
ASIDE: Final = "not reproduced"
"""What became of a number: held against ours, a setting of twin or protocol, or neither."""


class PaperNumber(NamedTuple):
    """A number of the paper, or several that belong together."""

    where: str
    what: str
    value: str
    """As printed, with its unit."""
    use: Literal["claim", "set", "not reproduced"]
    why: str
    """The claim's name, what is set by it, or why it is not reproduced."""


MATERIAL = "no geometry of the twin needs it"

NUMBERS: tuple[PaperNumber, ...] = (
    PaperNumber("I", "catheter, and those on the market", "2 m; .4 m", ASIDE, MATERIAL),
    PaperNumber("II-A", "insertion speed", "around 10 mm/s", SETTING, "guideline of speed"),
    PaperNumber("II-A", "tube for adults", "7.5 to 9.5 mm", SETTING, "presets of patients"),
    PaperNumber(
        "II-A", "catheter below half the tube", "8 mm: 4 mm", SETTING, "guideline of ratio"
    ),
    PaperNumber("II-A", "vacuum", "80 to 120, 80 to 100 mmHg", SETTING, "guideline of vacuum"),
    PaperNumber("II-A", "duration of suction", "10 to 15 s, 5 s", SETTING, "guideline of time"),
    PaperNumber("II-A", "depth below the tube", "5 to 10 cm", SETTING, "table of requirements"),
    PaperNumber("II-A", "reuse of a catheter", "24 h", SETTING, "age of a catheter that is used"),
    PaperNumber("II-B", "slide of the valve", "5 mm", SETTING, "valve of the twin"),
    PaperNumber("II-B", "soft tip", "400 mm", ASIDE, MATERIAL),
    PaperNumber("II-B", "catheter", "3.5, 4, 2000 mm", SETTING, "bore and clearance of the twin"),
    PaperNumber("II-B", "conduit", "6, 6.5, 1500 mm", SETTING, "clearance of the twin"),
    PaperNumber("II-B", "pump", "18 L/min, 560 mmHg", SETTING, "pump of the twin"),
    PaperNumber("II-B", "highest vacuum in use", "150 mmHg", SETTING, "relief valve of the bench"),
    PaperNumber("II-B", "least tube", "7.5 mm", SETTING, "table of requirements: it breaks II-A"),
    PaperNumber("II-B", "T-connector", "15 mm, 6.5 mm", ASIDE, MATERIAL),
    PaperNumber(
        "III-B", "Bouc-Wen A, B, m, D, three more", "1.925 ... -7.097", CLAIM, "loop width"
    ),
    PaperNumber("III-B", "beta", ".854", CLAIM, "beta"),
    PaperNumber("III-B", "alpha_0", ".077", CLAIM, "alpha_0"),
    PaperNumber("III-B", "c", ".9677", CLAIM, "c"),
    PaperNumber("III-B", "y_0", "-7.151", CLAIM, "y_0"),
    PaperNumber("III-B", "RMSE of Bouc-Wen", ".8009 mm", CLAIM, "RMSE of the Bouc-Wen model"),
    PaperNumber("III-B", "RMSE of modified Dahl", ".8301 mm", CLAIM, "RMSE of the modified Dahl"),
    PaperNumber(
        "III-B", "a slight difference of the two", ".8009, .8301", CLAIM, "RMSE of Bouc-Wen over"
    ),
    PaperNumber("III-B", "parameters of the models", "six, four", ASIDE, "the text lists seven"),
    PaperNumber("III-D", "elastomer, wires", ".1 mm, .2 mm", ASIDE, MATERIAL),
    PaperNumber("III-D", "signal of the switch", "2 V", ASIDE, "a contact is read as a bit"),
    PaperNumber("IV-A", "gains of motor A", "P = 10, D = 10", SETTING, "no units are printed"),
    PaperNumber("IV-A", "gains of motor B", "P = 7, D = 7", SETTING, "no units are printed"),
    PaperNumber("IV-A", "speed both ways", "around 1 cm/s", SETTING, "protocol paper: 9 mm/s"),
    PaperNumber("IV-A", "standing for suction", "5 to 10 s", SETTING, "protocol paper: 9 s"),
    PaperNumber("IV-A", "cam", "30 degrees at 15/s", SETTING, "valve of the bench"),
    PaperNumber("IV-B", "travel, speed, suction", "90 mm, 9 mm/s, 9 s", SETTING, "protocol paper"),
    PaperNumber("IV-B", "RMSE of the trial shown", "15.413, 2.4578 mm", CLAIM, "Table I, trial 1"),
    PaperNumber("Table I", "ten RMSE", "14.998 ... 2.2243 mm", CLAIM, "means and scatter"),
    PaperNumber("IV-C", "speed of the contact trials", "9 mm/s", SETTING, "protocol paper"),
    PaperNumber("IV-C", "distances of the carina", "65, 55, 45 mm", SETTING, "of the trials"),
    PaperNumber("IV-C", "force that closes the switch", ".08017 N", CLAIM, "force at which"),
    PaperNumber("IV-C", "trials, suctions completed", "5 each, all", CLAIM, "suctions completed"),
    PaperNumber("Table II", "15 stops", "64.782 ... 44.988 mm", CLAIM, "stop errors"),
    PaperNumber("IV-C", "mean stop errors", ".4076, .2626, .3862 mm", CLAIM, "mean stop error"),
    PaperNumber("V", "size of the catheter", "around 4 mm", SETTING, "as II-B"),
    PaperNumber(
        "V", "identification", "around 3 min", ASIDE, "another algorithm, on another processor"
    ),
)
