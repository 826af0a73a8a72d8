"""tests/app/test_unusual_runs.py: means, starts and edits of runs that are not as most are: steps whose decimals are
rounded, units of another name, ends between two samples, files that are gone, fields that are changed."""
import h5py
import numpy as np
import pytest
from rejection import rejected
from support import drover as program, drover_json, write_scene

import drover
from drover.tradeoffs import with_accuracy

OWN = """
[[field]]
symbol = "phi"
noise = 0.1
{more}
[equations]
phi = "-phi + lap phi"
{equations}
[grid]
nx = 8
ny = 8
lx = 8.0
ly = 8.0
[time]
dt = {dt}
end = {end}
[output]
frame_every = {frames}
sample_every = {samples}
"""


def own(folder, dt=0.1, end=20.0, frames=10.0, samples=0.5, more="", equations="", name="own.toml"):
    (folder / name).write_text(OWN.format(dt=dt, end=end, frames=frames, samples=samples, more=more,
                                          equations=equations))
    return name


def test_means_have_all_samples_where_the_decimals_of_the_step_are_rounded(tmp_path):
    scene = own(tmp_path, dt=0.033333333, end=333.33333, frames=0.0, samples=0.1)
    result = drover_json(tmp_path, "run", scene, "-o", "run.h5")
    assert result["samples"] == 3334 and result["results"]["mean_phi"]["samples"] > 3000
    run = drover.Scene.load(tmp_path / scene).start()
    run.observe(lambda frame: frame.phi.max(), "peak")  # three steps of .0333 are the .1 of the scene
    run.advance(steps=30)
    assert run.observables.peak.sizes["time"] == 11


def test_a_run_with_other_names_of_units_is_a_start_a_record_and_a_ramp(tmp_path):
    write_scene(tmp_path, {"units.length": "cm", "units.time": "none", "relaxation.rate": 0.5, "noise.order": 0.1,
                           "time.dt": 0.1, "time.end": 80.0, "output.frame_every": 1.0}, "unit.toml")
    program(tmp_path, "run", "unit.toml", "-o", "first.h5")
    assert "tau [s]" not in program(tmp_path, "info", "first.h5").stdout
    program(tmp_path, "run", "unit.toml", "-o", "second.h5", "--set", "initial.kind=file", "--set",
            "initial.file=first.h5")
    with h5py.File(tmp_path / "first.h5") as first, h5py.File(tmp_path / "second.h5") as second:
        assert first["rod_density"].attrs["units"] == b"cm-2"
        assert np.allclose(first["rod_density"][-1], second["rod_density"][0], rtol=1e-12)
    program(tmp_path, "fit", "first.h5", "relaxation.rate")
    program(tmp_path, "sweep", "unit.toml", "--vary", "relaxation.rate = 0.5, 0.6", "--ramp", "up", "--quiet")
    program(tmp_path, "run", "unit.toml", "-o", "mm.h5", "--set", "units.length=mm")
    rejected(tmp_path, ["run", "unit.toml", "-o", "third.h5", "--set", "initial.kind=file", "--set",
                        "initial.file=mm.h5"], ["rod_density in mm-2; expected cm-2"])


def test_a_session_beyond_an_end_between_two_samples_has_the_means_of_one_that_was_to_go_on(tmp_path):
    own(tmp_path, end=10.25, dt=0.05, frames=0.0)
    own(tmp_path, end=40.0, dt=0.05, frames=0.0, name="long.toml")
    runs = [drover.Scene.load(tmp_path / name).start() for name in ("own.toml", "long.toml")]
    runs[0].advance()
    assert float(runs[0].observables.time[-1]) == 10.25
    for run in runs:
        run.advance(steps=800 - run.step)
    assert np.array_equal(runs[0].observables.time, runs[1].observables.time)
    assert float(runs[0].summary.mean_phi) == float(runs[1].summary.mean_phi)


@pytest.mark.parametrize("more, equations, called", [
    ('[[field]]\nsymbol = "b"\nname = "phi_error"', 'b = "-b"', "correlation_phi_error"),
    ('[[field]]\nsymbol = "b"\n[[field]]\nsymbol = "c"\nname = "phi_b"', 'b = "-b"\nc = "-c"',
     "structure_factor_phi_b"),
])
def test_fields_whose_results_would_have_one_name_are_rejected(tmp_path, more, equations, called):
    scene = own(tmp_path, more=more, equations=equations)
    for command in ("check", "run"):
        rejected(tmp_path, [command, scene], [called, "phi", "rename one of the fields"])
    with pytest.raises(drover.Error, match=called):
        drover.Scene.load(tmp_path / scene).start()


def test_fields_that_are_being_edited_are_not_looked_at(tmp_path):
    run = drover.Scene.load(tmp_path / own(tmp_path)).start()
    run.advance(steps=5)
    for look in (lambda: run.frame, lambda: run.advance(steps=1), lambda: run.observe(len, "size")):
        with pytest.raises(drover.Error, match="being edited"), run.edit() as fields:
            fields.phi[...] = 5.0
            look()
        assert abs(run.frame.phi.mean()) < 1.0  # as before
    with run.edit() as fields:
        fields.phi[...] = 5.0
    assert run.frame.phi.mean() == 5.0
    with pytest.raises(drover.Error, match="expected a number"):
        run.advance(float("nan"))


def test_an_observable_with_the_name_of_a_result_is_rejected(tmp_path):
    run = drover.Scene.load(tmp_path / write_scene(tmp_path, {"time.end": 1.0})).start()
    run.advance(steps=20)
    with pytest.raises(drover.Error, match="measures"):
        run.observe(lambda frame: 42.0, "polar_order_susceptibility")


def test_the_number_of_rods_is_that_of_all_samples(tmp_path):
    run = drover.Scene.load(tmp_path / write_scene(tmp_path, {"time.end": 2.0, "analysis.warm_up": 1.0})).start()
    run.advance(1.0)
    before = run.summary.rod_number.values
    with run.edit() as fields:
        fields.rod_density[...] *= 2.0
    run.advance(1.0)
    assert (run.summary.rod_number.values >= 1.5 * before).all()


def test_a_run_from_a_file_resumes_without_the_file(tmp_path):
    own(tmp_path)
    program(tmp_path, "run", "own.toml", "-o", "start.h5")
    from_file = ["--set", "initial.kind=file", "--set", "initial.file=start.h5"]
    program(tmp_path, "run", "own.toml", "-o", "whole.h5", "--set", "time.end=40", *from_file)
    program(tmp_path, "run", "own.toml", "-o", "part.h5", *from_file)
    (tmp_path / "start.h5").rename(tmp_path / "elsewhere.h5")
    program(tmp_path, "restart", "part.h5", "--set", "time.end=40")
    with h5py.File(tmp_path / "whole.h5") as whole, h5py.File(tmp_path / "part.h5") as part:
        assert np.array_equal(whole["phi"][-1], part["phi"][-1])


def test_a_table_of_a_formula_says_where_its_values_were_held():
    model = drover.Model([drover.Field("n", "div(D grad n)", conserved=True, reference=1.0)],
                         tables=[drover.Table("D", of="2 n", first=[1.0, 3.0], values=[0.4, 0.2], outside="hold")])
    run = model.scene(points=16, side=16.0, dt=0.05, end=2.0, initial={"n": "1 + 0.9 cos(2 pi x/lx)"}).start()
    run.advance()
    assert any("2 n left the table of coefficients in" in one for one in run.warnings)


def test_a_table_of_two_fields_says_that_this_is_not_known():
    model = drover.Model([drover.Field("n", "div(D grad n)", conserved=True, reference=1.0), drover.Field("m", "-m")],
                         tables=[drover.Table("D", of="n + m", first=[0.5, 1.5], values=[0.4, 0.2], outside="hold")])
    run = model.scene(points=16, side=16.0, dt=0.05, end=1.0).start()
    run.advance()
    assert any("whether n + m left the table" in one for one in run.warnings)


def test_the_recommended_run_has_the_name_of_its_scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = drover.Scene.load(tmp_path / write_scene(tmp_path, {
        "relaxation.rate": 0.5, "noise.order": 0.1, "time.dt": 0.5, "time.end": 200.0, "output.sample_every": 1.0},
        "mine.toml"))
    assert with_accuracy(scene, "polar_order=50%").name == scene.name
