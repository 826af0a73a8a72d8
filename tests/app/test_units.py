"""tests/app/test_units.py: the names of units that a scene gives its results, none of them for a dimensionless one."""
import re

import h5py
import matplotlib
import pytest
from support import MODELS, SMALL, drover as program, write_scene

import drover
from drover import figure

NONE = {"units.length": "none", "units.time": "none", "units.mass": "none"}
DIMENSIONAL = re.compile(r"(?<![A-Za-z])(mm|mg|s)(?![A-Za-z])")
OWN = MODELS / "toner-tu.toml"
SHORT = {"grid.nx": 16, "grid.ny": 16, "time.end": 4.0, "output.sample_every": 0.4, "output.frame_every": 1.0}


def units_of(path):
    """{dataset: unit} of an archive."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item.attrs["units"].decode()})
                        if "units" in item.attrs else None)
    return found


def words_of(drawn):
    """All texts of a figure but its caption, whose prose is not made of labels."""
    return [text.get_text() for text in drawn.findobj(matplotlib.text.Text)]


@pytest.mark.parametrize("scene", [drover.Scene.from_dict({**SMALL, "time.end": 4.0}),
                                   drover.Scene.load(OWN).set(SHORT)])
def test_a_scene_without_units_has_none_in_its_archive_and_figure(scene, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with scene.set(NONE).run("plain.h5") as run, scene.run("named.h5") as same:
        found = units_of("plain.h5")
        assert len(found) > 40 and not [name for name, unit in found.items() if DIMENSIONAL.search(unit)]
        assert any(DIMENSIONAL.search(unit) for unit in units_of("named.h5").values())
        assert float(run.observables.to_array().sum()) == float(same.observables.to_array().sum())  # names alone
        drawn = words_of(figure.draw(run))
        assert not [text for text in drawn if re.search(r"\bmm\b|\[s\]| s\b(?! )", text)], drawn
        assert any("time $t$" == text for text in drawn) and any("[mm]" in text for text in words_of(figure.draw(same)))
    theory = scene.set(NONE).stability()
    assert not [name for group in theory.groups.values() for name, array in group.variables.items()
                if DIMENSIONAL.search(array.attrs.get("units", "1"))]
    run = scene.set(NONE).start()
    run.advance(1.0)
    assert run.frame.to_xarray().time.units == "1" and run.observables.time.units == "1"
    assert not [name for name, array in run.summary.variables.items()
                if DIMENSIONAL.search(array.attrs.get("units", "1"))]


def test_units_are_called_as_the_scene_says(tmp_path):
    scene = write_scene(tmp_path, {"units.length": "cm", "units.time": "h", "time.end": 4.0})
    table = program(tmp_path, "run", scene, "-o", "cm.h5").stdout
    assert not re.search(r"\[[^]]*mm", table) and "|q| [1/cm]" in table and "side [cm]" in table
    assert table.startswith("t = 0 to 4 h, ") and "tau [h]" in table and "[s]" not in table
    found = units_of(tmp_path / "cm.h5")
    assert (found["x"], found["time"], found["rod_density"], found["observables/wavenumber"]) == \
        ("cm", "h", "cm-2", "cm-1")
    theory = program(tmp_path, "stability", scene).stdout
    assert re.search(r"all waves from .* to [0-9.]+ /cm", theory) and not re.search(r"\bmm", theory)
    drawn = words_of(figure.draw_file(tmp_path / "cm.h5"))
    assert "$x$ [cm]" in drawn and "time $t$ [h]" in drawn


def test_a_last_sample_off_the_schedule_is_named_in_the_units_of_the_scene(tmp_path):
    scene = write_scene(tmp_path, {"units.time": "h", "time.end": 1.2, "output.sample_every": 0.5})
    table = program(tmp_path, "run", scene).stdout
    assert "the last sample, at t = 1.2 h, comes sooner after the one before" in table
    assert "the start alone" not in table
    assert "at least 40 are needed: run for 20 h" in table
    alone = program(tmp_path, "run", scene, "-o", "one.h5", "--set", "output.sample_every=2.0").stdout
    assert "which are of the start alone: choose output.sample_every of at most time.end" in alone


@pytest.mark.parametrize("name", ["", "mm 2", "1", "m/s"])
def test_the_name_of_a_unit_is_one_word(name, tmp_path):
    scene = write_scene(tmp_path, {"units.length": name})
    wrong = program(tmp_path, "check", scene, status=2).stderr
    assert "units.length" in wrong and '"none"' in wrong


def test_particles_have_their_units():
    with pytest.raises(drover.Error, match="units"):
        drover.Scene.load(MODELS / "bead-gas.toml").set("units.length", "cm")


def test_units_of_sweeps_fits_and_spectra_are_called_as_the_scene_says(tmp_path):
    scene = drover.Scene.from_dict({**SMALL, **NONE, "output.frame_every": 0.5, "run.threads": 1})
    with scene.run(tmp_path / "none.h5") as run:
        words = drover.dynamic_structure_factor(run, "rod_density").dynamic_structure_factor_rod_density_linear.comment
        assert "of frames 0.5 apart in windows of" in words and " s" not in words.split("of frames")[1]
    fitted = drover.fit(tmp_path / "none.h5", ["relaxation.rate", "noise.order"])["coefficients"]
    assert [row["unit"] for row in fitted] == ["1", "1"]
    for names, of_rate, of_noise in ((NONE, "", ""), ({"units.time": "h"}, " [h$^{-1}$]", None)):
        table = drover.sweep(scene.set({**SMALL, "time.end": 2.0, "units.length": "mm", "units.time": "s",
                                        "units.mass": "mg", **names}),
                             {"relaxation.rate": [0.5, 1.0], "noise.order": [0.05, 0.1]}, workers=1)
        axes = table.plot("polar_order")
        assert axes.get_ylabel() == "relaxation.rate" + of_rate
        if of_noise is not None:
            assert axes.get_xlabel() == "noise.order" + of_noise
            assert [table.data[key].units for key in table.keys] == ["1", "1"]
