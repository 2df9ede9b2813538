"""Names of catheter and conduit in the summary of a cycle."""

from opensuction.session.cycle import summary_section
from opensuction.twin.machine.catheter import CATHETERS, ROUTES, Catheter, lay


def test_catheter_and_conduit_are_named_or_measured() -> None:
    for name, catheter in CATHETERS.items():
        assert summary_section.catheter_name(catheter) == name
        for route in ROUTES:
            assert summary_section.conduit_name(catheter, lay(route, catheter)) == route
    own = Catheter(3.0, 2.5)
    assert summary_section.catheter_name(own) == "3 mm, bore 2.5 mm"
    longer = lay("short", own)._replace(length_mm=1200.0, bend_rad=8.0)
    assert summary_section.conduit_name(own, longer) == "1200 mm, bore 5 mm, bent by 8 rad"
