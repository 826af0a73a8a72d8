"""tests/app/test_python_slurm.py: work submitted to Slurm from Python: its status, and its results."""
import drover
import numpy as np
import pytest
from calibration import TINY, UNITS
from support import MODELS, SMALL, slurm_at_once

BRIEF = {**SMALL, "time.end": 10.0, "output.frame_every": 5.0, "output.sample_every": 0.5}


@pytest.fixture(name="folder")
def fixture_folder(tmp_path, monkeypatch):
    for name, value in slurm_at_once(tmp_path).items():
        monkeypatch.setenv(name, value)
    return tmp_path


def scene_of(keys):
    return drover.Scene.from_dict({}).set(keys)


def test_a_sweep(folder):
    vary = {"relaxation.rate": [0.5, 1.0, 2.0]}
    submitted = drover.sweep(scene_of(BRIEF), vary, keep="table", folder=folder / "swept", slurm=2)
    assert submitted.status().startswith("3 of 3 done, 0 failed, 0 running")
    found = submitted.collect()
    assert found.data.identical(drover.sweep(scene_of(BRIEF), vary, keep="table", folder=folder / "here").data)


def test_a_boundary(folder):
    scene = drover.Scene.load(MODELS / "brusselator.toml").set({"boundary.cells": 8, "boundary.map": 0})
    plane = ("coefficients.a = 2.5:4", "coefficients.b = 5:13")
    submitted = scene.boundary(*plane, output=folder / "plane.h5", slurm=2)
    assert " 0 failed, 0 running" in submitted.status()
    here = scene.boundary(*plane)
    for found in (submitted.collect(), drover.open_theory(folder / "plane.h5")):
        assert np.array_equal(found.x, here.x) and np.array_equal(found.y, here.y)


def test_a_tradeoff(folder):
    scene = scene_of({"relaxation.rate": -0.5, "relaxation.saturation": 1.0, "noise.order": 0.05, "grid.nx": 8,
                      "grid.ny": 8, "time.dt": 0.5, "time.end": 100.0, "initial.kind": "formula",
                      "initial.polar_order_x": "0.7", "output.sample_every": 1.0})
    submitted = drover.tradeoff(scene, "polar_order=20%", "5s", folder=folder / "traded", slurm=2)
    assert "0 running in 0 processes" in submitted.status()
    assert submitted.collect().recommended["time.end"] >= 100.0


def test_a_calibration(folder):
    scene = scene_of(TINY)
    submitted = drover.calibrate(scene, folder / "calibrated", slurm=2)
    assert submitted.status().startswith(f"{UNITS} of {UNITS} measurements done")
    assert submitted.collect().text == drover.calibrate(scene, folder / "here").text


def test_files_of_the_user_stay_and_files_beside_the_scene_are_found(folder):
    scene_of(BRIEF).set("time.end", 1.0).run(folder / "start.h5", quiet=True).close()
    text = "# mine\n" + scene_of(BRIEF).set({"initial.kind": "file", "initial.file": "start.h5"}).to_toml()
    (folder / "noise.toml").write_text(text)
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    scene, vary = drover.Scene.load(folder / "noise.toml"), {"relaxation.rate": [0.5, 1.0]}
    for place in (folder / "noise", elsewhere / "noise"):
        found = drover.sweep(scene, vary, keep="table", folder=place, slurm=2).collect()
    assert found.data.identical(drover.sweep(scene, vary, keep="table", folder=folder / "here").data)
    assert (folder / "noise.toml").read_text() == text and not (folder / "noise.sh").exists()
    with pytest.raises(drover.Error, match="slurm.toml exists with another content; remove it"):
        drover.sweep(scene, vary, seeds=2, keep="table", folder=folder / "noise", slurm=2)
