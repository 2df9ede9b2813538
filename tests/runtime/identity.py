"""Identity of the machines of these tests."""

from opensuction.records.entry import Catheter, Machine, SettingsFile
from opensuction.runtime import machine_folder

ABOUT = machine_folder.About(
    machine=Machine("twin-1", "clinical", is_twin=True),
    catheter=Catheter("c-1", 6, 86_400),
    protocol=SettingsFile("neonate", "{}"),
    approach="travel",
    patient="P-1",
    parameter_file=None,
    database=None,
    heading={"patient": "neonate"},
)
