"""Holds JSON values against a JSON Schema: one value a line in, one line of complaint out."""
import json
import sys

import jsonschema

with open(sys.argv[1], encoding="utf-8") as file:
    validator = jsonschema.Draft7Validator(json.load(file))
for line in sys.stdin:
    errors = ["/" + "/".join(map(str, error.absolute_path)) + ": " + error.message
              for error in validator.iter_errors(json.loads(line))]
    print("; ".join(errors).replace("\n", " "), flush=True)
