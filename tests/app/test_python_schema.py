"""tests/app/test_python_schema.py: every key of the schema takes its default and refuses what is beyond its range."""
import itertools
import json
import math
import re

import pytest
from drover import Error, Scene
from support import drover, drover_json


def test_every_key_of_the_schema_is_accepted_and_its_range_is_enforced(tmp_path):
    (tmp_path / "empty.toml").write_text("")
    (tmp_path / "own.toml").write_text(
        '[[field]]\nsymbol = "u"\n[[white_noise]]\nsymbol = "xi"\n[equations]\nu = "-u"\n'
        '[[tabulated]]\nsymbol = "a"\nof = ["u"]\nfirst = [0, 1]\nvalues = [1, 2]\n')
    schema = {(section["name"], row["name"]): (row, section.get("kinds") == ["model"])
              for section in drover_json(tmp_path, "schema") for row in section["rows"]}
    without_default = ("[field].symbol", "[white_noise].symbol",
                       *(f"[tabulated].{key}" for key in ("symbol", "of", "first", "values")))
    rows = [("own.toml", re.sub(r"^\[(\w+)\]", r"\1[1]", key), row) if is_own else ("empty.toml", key, row)
            for key, row, is_own in ((".".join(names), *found) for names, found in schema.items())
            if key not in without_default]
    for _, table in itertools.groupby(rows, key=lambda row: (row[0], row[1].partition(".")[0])):
        settings = [(scene, f"{key}={json.dumps(row['default'])}") for scene, key, row in table]
        drover(tmp_path, "check", settings[0][0], *(word for _, setting in settings for word in ("--set", setting)))
    bases = {name: Scene.load(tmp_path / name) for name in ("empty.toml", "own.toml")}
    for scene, key, row in rows:
        beyond = [row["min"] - 1] if "min" in row else [row["more_than"]] if "more_than" in row else []
        beyond += [row["max"] * 2 + 1] if "max" in row else []
        beyond += [math.nan, math.inf] if row["type"] == "a number" else []
        beyond += ["a word like no other"] if "choices" in row else []
        for value in beyond:
            value = int(value) if row["type"] == "an integer" else value
            with pytest.raises(Error) as refused:
                bases[scene].set({key: value})
            assert f"{key} = " in str(refused.value) and "expected" in str(refused.value), refused.value
