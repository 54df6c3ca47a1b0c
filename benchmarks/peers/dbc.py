"""Decode and encode PGN 127250 with cantools; prints ns of each. `dbc.py PAYLOAD(hex)`."""

import json
import sys
from pathlib import Path
from timeit import Timer

import cantools

payload = bytes.fromhex(sys.argv[1])
database = cantools.database.load_file(Path(__file__).with_name("vessel_heading.dbc"))
identifier = database.messages[0].frame_id
values = database.decode_message(identifier, payload)
assert database.encode_message(identifier, values, padding=True)[:7] == payload[:7]

NUMBER, REPEAT = 200, 1000
what = {
    "decode": lambda: database.decode_message(identifier, payload),
    "encode": lambda: database.encode_message(identifier, values, padding=True),
}
print(json.dumps({name: min(Timer(run).repeat(REPEAT, NUMBER)) / NUMBER * 1e9 for name, run in what.items()}))
