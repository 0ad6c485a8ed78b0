"""Puts derivatives by hand beside the reference of a worksheet: python3 worksheet.py in.json out.json."""

import json
import sys

from distance import phi_q

with open(sys.argv[1]) as file:
    sheet = json.load(file)
for block in sheet["blocks"]:
    for point in block["points"]:
        at = point["at"]
        point["value"] = phi_q(at["q"], at["b"])
with open(sys.argv[2], "w") as file:
    json.dump(sheet, file)
