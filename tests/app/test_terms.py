"""tests/app/test_terms.py: terms as text in the program: stability, runs, settings, errors; documentation."""
import json
import re
import subprocess
from pathlib import Path

import h5py
import numpy
import pytest
from rejection import rejected
from support import DROVER, drover, settings

from drover import Error, Scene

ANCHORING = """
[fields]
rod_density = false

[relaxation]
rate = 0.0

[[terms]]
of = "order"
value = ["0", "-W order_y"]
parameters = { W = 0.7 }

[grid]
nx = 16
ny = 16
lx = 16.0
ly = 16.0

[time]
dt = 0.05
end = 2.0

[initial]
kind = "formula"

[output]
frame_every = 2.0
sample_every = 0.0
"""
HOSTILE = Path(__file__).resolve().parents[1] / "base" / "hostile_expressions.txt"


def write(folder, text, name="anchoring.toml"):
    (folder / name).write_text(text)
    return name


@pytest.mark.parametrize("wave", ["cos(pi x / 4)", "cos(pi y / 4)", "cos(pi (x + y) / 4)"])
def test_an_anisotropic_term_decays_at_its_rate_along_x_along_y_and_between_them(tmp_path, wave):
    scene = write(tmp_path, ANCHORING.replace('kind = "formula"', f'kind = "formula"\npolar_order_y = "0.01 {wave}"'))
    drover(tmp_path, "run", scene, "--quiet")
    with h5py.File(tmp_path / "anchoring.h5") as file:
        start, end = file["polar_order_y"][0], file["polar_order_y"][-1]
        time_ = file["time"][-1] - file["time"][0]
    # ETDRK2 with half of the rate outside the propagator: (0.35 * 0.05)^2/6 of the rate.
    assert numpy.log((end * start).sum() / (start * start).sum()) / time_ == pytest.approx(-0.7, rel=1e-4)


def test_stability_and_boundary_take_the_term_and_its_parameter(tmp_path):
    scene = write(tmp_path, ANCHORING.replace("rate = 0.0", "rate = 0.1"))
    plain = drover(tmp_path, "stability", scene, "--json").stdout
    assert json.loads(plain)
    drover(tmp_path, "run", scene, "--quiet", *settings(["terms.W=1.5"]), "-o", "other.h5")
    with h5py.File(tmp_path / "other.h5") as file:
        text = file.attrs["scene"]
    assert "parameters = { W = 1.5 }" in (text.decode() if isinstance(text, bytes) else text)


def test_a_parameter_can_be_swept(tmp_path):
    scene = write(tmp_path, ANCHORING)
    drover(tmp_path, "sweep", scene, "--vary", "terms.W = 0.5, 1", "--quiet")


def test_bad_terms_are_rejected_at_their_column_with_a_remedy(tmp_path):
    for text, says in [('value = ["0", "-W order_z"]', ["anchoring.toml:10:19", "order_z", "did you mean"]),
                       ('value = ["0", "-W order_y"', ["anchoring.toml:"]),
                       ('value = ["-W order_y"]', ["anchoring.toml:", "two, the x and y components"]),
                       ('value = 3', ["anchoring.toml:10", "expression in quotes"])]:
        scene = write(tmp_path, ANCHORING.replace('value = ["0", "-W order_y"]', text))
        rejected(tmp_path, ["run", scene], says)
    rejected(tmp_path, ["run", write(tmp_path, ANCHORING), *settings(["terms.V=1"])], ["terms.V", "expected"])
    for text, says in [('{ W = "x" }', ["terms.W", "a number"]),
                       ("3", ["anchoring.toml:11", "terms.parameters is not a table", "such as { W = 0.7 }"]),
                       ("{ W = 0.7 }\nparameter_names = 3", ["anchoring.toml:12", "unknown key terms[1]"])]:
        rejected(tmp_path, ["run", write(tmp_path, ANCHORING.replace("{ W = 0.7 }", text))], says)
    rejected(tmp_path, ["run", write(tmp_path, ANCHORING), *settings(["terms[1].parameter_names=3"])],
             ["unknown key terms[1].parameter_names"])


def test_hostile_expressions_are_rejected_in_a_sentence():
    texts = [line for line in HOSTILE.read_text(errors="replace").splitlines() if line and not line.startswith("#")]
    texts += ["(" * 100000, "x^" * 5000 + "x", "order_x " * 200000, "exp(" * 150 + "order_x" + ")" * 150 + "^9.5.1", ""]
    assert len(texts) >= 200
    for text in texts:
        quoted = text.replace("\\", "\\\\").replace('"', '\\"')
        with pytest.raises(Error) as rejection:
            Scene.parse(ANCHORING.replace("-W order_y", quoted)).explain()
        assert rejection.value.fault == "input", text[:80]
        assert len(str(rejection.value)) < 2000, text[:80]


def test_the_table_of_coefficients_has_keys_of_the_schema():
    table = subprocess.run([DROVER, "schema", "--coefficients"], capture_output=True, text=True, check=True).stdout
    sections = json.loads(subprocess.run([DROVER, "schema", "--json"], capture_output=True, text=True,
                                         check=True).stdout)
    keys = {f"{section['name']}.{row['name']}" for section in sections for row in section["rows"]}
    assert {key for key in re.findall(r"`([a-z_]+\.[a-z_]+)`", table)} <= keys
