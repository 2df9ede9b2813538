"""Help text of ``opensuction cycle``: examples, files, faults."""

import textwrap

from opensuction.cli import completion

_FAULTS = textwrap.fill(
    ", ".join(completion.FAULTS),
    width=77,
    initial_indent="  ",
    subsequent_indent="  ",
    break_on_hyphens=False,
)

EXAMPLES = f"""\b
Examples:
  opensuction cycle                                an adult on a ventilator
  opensuction cycle --patient child-10kg           a child
  opensuction cycle --machine bench                the paper's bench
  opensuction cycle --machine bench --compensation none --seed 7
  opensuction cycle --approach contact             stop where the tip touches
  opensuction cycle --protocol my.toml --out run1  a protocol of your own
  opensuction cycle --machine my-machine.toml --patient my-patient.toml
  opensuction cycle --machine bench --compensation bench/identification.toml
  opensuction cycle --repeat 6 --every 240         a cycle every four hours
  opensuction cycle --fault valve-jammed@suctioning+2
  opensuction cycle --fault line-leak=0.5 --fault power-lost@12
  opensuction cycle --repeat 6 --every 60 \\
      --self-calibrate --gap-scale 1.2    the gap changed; each cycle learns
  opensuction cycle --json | jq .tip               figures for a script
  opensuction cycle --trace ticks.parquet          every tick as a table

\b
A protocol file holds the keys of the preset, for example:
  travel_mm = 85.0
  cap_mm = 90.0
  contact_from_mm = 30.0
  backoff_mm = 0.0
  insertion_mm_per_s = 9.0
  withdrawal_mm_per_s = 9.0
  dwell_s = 9.0
  nothing_comes_s = 0.0           # 0: the dwell lasts its whole time
  vacuum_mmhg = 100.0
  negative_pressure_budget_s = 24.0
  in_airway_budget_s = 35.0
  bench_only = true

\b
A machine file says what it starts from and what it changes:
  preset = "clinical"
  catheter = "12fr"
  conduit = "looped"
  [twin]                          # what the machine does
  pump_free_l_per_min = 15.0
  [controller]                    # what its controller goes by
  cam_rad_per_s = 0.8

\b
A patient file likewise; a value with a spread is drawn by the seed:
  preset = "adult-icu"
  weight_kg = 82.0
  carina_mm = {{ value = 60.0, spread = 4.0 }}

docs/reference/parameters.md lists every parameter with unit, range and source.

A fault comes S seconds after the start (@S), S seconds into a phase (@PHASE+S: checking,
preloading, inserting, backing_off, opening, suctioning, withdrawing, closing, aborting, halted), or
is there from the start. With --repeat, S counts from the start of the day. Its strength has a unit
of its own. docs/reference/faults.md says what each does:

\b
{_FAULTS}"""
