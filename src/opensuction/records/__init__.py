"""Records of machines, catheters, patients, cycles, alarms and people: kept in a database.

Nothing in it is ever changed or removed: what happens later is a row of its own, and every row has
its entry in a trail whose entries are chained by hashes (`trail/chain.py`). Who moves the catheter
does not wait for it: the runtime's recorder writes here, the control process never does.
"""
