"""tests/app/test_serve.py: drover serve: who is answered, what is shown, and what a page may do with a run."""
import base64
import json
import socket
import subprocess
import threading
import time
import urllib.error
import urllib.request
from contextlib import contextmanager

import numpy
import pytest
from support import DROVER, MODELS, SMALL, environment

import drover
from drover import pictures, server as page, shown

LONG = {**SMALL, "time.end": 1e6, "output.sample_every": 10.0, "output.frame_every": 0.0}

# d_t p = p - |p|^2 p of a uniform state: |p| = 1 at the end, whatever else is there.
FLOCK = {"relaxation.rate": -1.0, "relaxation.saturation": 1.0, "noise.order": 0.0, "noise.rods": 0.0,
         "current.speed": 0.0, "pressure.rods": 0.0, "initial.kind": "formula", "initial.polar_order_x": "0.1"}


def request(server, path, content=None, **headers):
    """The status and the text of an answer."""
    asked = urllib.request.Request(f"http://127.0.0.1:{server.server_port}{path}", content, headers)
    try:
        with urllib.request.urlopen(asked) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def state(server, after=-1, **wishes):
    words = "".join(f"&{name}={value}" for name, value in wishes.items())
    status, text = request(server, f"/state?token={server.token}&after={after}{words}")
    assert status == 200
    return json.loads(text)


def do(server, action, **values):
    status, text = request(server, "/do", json.dumps({"action": action, **values}).encode(),
                           **{"X-Drover-Token": server.token})
    return status, text


def until(server, holds, seconds=20.0):
    """The first state that `holds`."""
    last, ends = -1, time.monotonic() + seconds
    while time.monotonic() < ends:
        now = state(server, last)
        if holds(now):
            return now
        last = now["number"]
    raise AssertionError(f"not seen in {seconds} s; the last was {str(now)[:500]}")


@contextmanager
def served(what):
    with page.Server(what) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield server
        finally:
            server.shutdown()
            what.close()


def live(**changes):
    return shown.LiveRun(drover.Scene.from_dict({**LONG, **changes}, "long.toml"))


def numbers(text):
    return numpy.frombuffer(base64.b64decode(text), "<f4")


def test_only_the_token_and_the_own_host_are_answered():
    with served(live()) as server:
        assert request(server, f"/?token={server.token}")[0] == 200
        for path in ("/", "/?token=", "/?token=guess", f"/?token={server.token[:-1]}", "/state?after=-1"):
            assert request(server, path)[0] == 403, path
        wish = json.dumps({"action": "pause"}).encode()
        assert request(server, "/do", wish)[0] == 403
        assert request(server, "/do", wish, **{"X-Drover-Token": "guess"})[0] == 403
        # A name of another site that resolves to 127.0.0.1, as in DNS rebinding.
        assert request(server, f"/?token={server.token}", Host="example.org")[0] == 403
        assert state(server)["state"] == "running"


def test_nothing_listens_beyond_this_machine():
    with served(live()) as server:
        assert server.socket.getsockname()[0] == "127.0.0.1"
        others = {address[4][0] for address in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}
        for host in others - {"127.0.0.1"}:
            with pytest.raises(OSError):
                socket.create_connection((host, server.server_port), timeout=1.0).close()


def test_a_run_goes_on_is_paused_and_takes_another_coefficient_from_its_state():
    with served(live(**FLOCK)) as server:
        # |p|^2 = -a/b in the state that a run ends in; the run below goes on with another a.
        until(server, lambda now: now["state"] == "running" and now["time"] > 30.0)
        assert do(server, "pause")[0] == 200
        paused = until(server, lambda now: now["state"] == "paused")
        time.sleep(0.3)
        assert state(server)["time"] == paused["time"]
        before = numbers(state(server, map="|polar_order|")["values"])
        assert before == pytest.approx(1.0, abs=1e-3)
        assert do(server, "set", **{"relaxation.rate": -4.0})[0] == 200
        same = until(server, lambda now: any(row["value"] == -4.0 for row in now["coefficients"]))
        assert same["time"] == paused["time"]  # it goes on from there
        assert numbers(state(server, map="|polar_order|")["values"]) == pytest.approx(before, rel=1e-6)
        do(server, "resume")
        until(server, lambda now: now["time"] > paused["time"] + 30.0)
        assert numbers(state(server, map="|polar_order|")["values"]) == pytest.approx(2.0, abs=1e-3)


def test_a_wrong_value_is_a_sentence_and_the_run_goes_on():
    with served(live()) as server:
        until(server, lambda now: now["state"] == "running")
        do(server, "set", **{"noise.order": -1.0})
        wrong = until(server, lambda now: now["error"])
        assert "noise.order" in wrong["error"] and "expected" in wrong["error"]
        until(server, lambda now: now["state"] == "running" and now["time"] > wrong["time"])
        for content in (b"no json", b"[]", b"{}", b'{"action": "dance"}'):
            assert request(server, "/do", content, **{"X-Drover-Token": server.token})[0] == 400
        assert request(server, "/do", b"x" * 100000, **{"X-Drover-Token": server.token})[0] == 413
        assert request(server, "/do", b"{}", **{"X-Drover-Token": server.token, "Content-Length": "abc"})[0] == 413
        assert request(server, f"/state?token={server.token}&after=abc")[0] == 400


def test_a_run_that_fails_is_shown_and_can_be_mended():
    with served(live(**{**FLOCK, "relaxation.saturation": 0.0})) as server:
        failed = until(server, lambda now: now["state"] == "failed")
        assert failed["error"]
        do(server, "set", **{"relaxation.rate": 1.0})
        until(server, lambda now: now["state"] == "running" and now["time"] > 1.0)


def test_warnings_are_shown_and_those_of_a_run_that_has_ended_too(tmp_path):
    # A warm-up that does not fit is a warning of the results.
    scene = drover.Scene.from_dict({**LONG, "time.end": 20.0, "analysis.warm_up": 30.0}, "long.toml")
    with served(shown.LiveRun(scene)) as server:
        ended = until(server, lambda now: now["state"] == "ended" and now["warnings"])
        assert any("analysis.warm_up = 30" in words for words in ended["warnings"])
        assert ended["warnings"] == shown_warnings(scene)
    scene.run(tmp_path / "warned.h5").close()
    with served(shown.ShownArchive(tmp_path / "warned.h5")) as server:
        assert any("analysis.warm_up = 30" in words for words in state(server)["warnings"])


def shown_warnings(scene):
    run = scene.start()
    run.advance()
    return run.warnings


def test_labels_have_the_units_of_the_scene():
    with served(live(**{"units.length": "none", "units.time": "h"})) as server:
        assert until(server, lambda now: now["state"] == "running")["units"] == {
            "length": "", "wavenumber": "", "time": "h"}


def test_particles_take_other_numbers_from_their_state():
    scene = drover.Scene.load(MODELS / "bead-flock.toml").set(
        {"cell.lx": 20.0, "cell.ly": 20.0, "time.end": 1e3, "output.sample_every": 0.05, "beads.area_fraction": 0.3})
    with served(shown.LiveRun(scene)) as server:
        first = until(server, lambda now: now["state"] == "running" and now["time"] > 0.05)
        keys = {row["key"] for row in first["coefficients"]}
        assert {"kick.strength", "plates.amplitude", "restitution.rod_bead"} <= keys
        assert not [key for key in keys if key.startswith(("beads", "rods", "cell", "contacts", "time"))]
        do(server, "pause")
        paused = until(server, lambda now: now["state"] == "paused")
        do(server, "set", **{"plates.amplitude": 0.05})
        taken = until(server, lambda now: any(row["key"] == "plates.amplitude" and row["value"] == 0.05
                                              for row in now["coefficients"]))
        assert not taken["error"]
        # To the end of the period of the plates, 5 ms, in which a body moves by less than its speed of some 100 mm/s.
        assert 0.0 <= taken["time"] - paused["time"] <= 5.01e-3
        now = state(server)
        moved = numpy.abs(numbers(now["bodies"]["rods"]) - numbers(paused["bodies"]["rods"])).reshape(-1, 4)[:, 2:]
        assert moved.max() < 1.0
        do(server, "resume")
        until(server, lambda now: now["time"] > taken["time"] + 0.05)
        do(server, "set", **{"plates.gap": 0.5})
        assert "plates.gap" in until(server, lambda now: now["error"])["error"]


def test_an_archive_is_shown_frame_by_frame(tmp_path):
    path = tmp_path / "small.h5"
    scene = drover.Scene.from_dict(SMALL, "small.toml")
    scene.run(path).close()
    with served(shown.ShownArchive(path)) as server, drover.open_run(path) as run:
        last = state(server, map="rod_density")
        assert (last["state"], last["time"], last["frames"]) == ("ended", 40.0, 9)
        kept = run.frames.rod_density.values
        assert numbers(last["values"]).reshape(last["shape"]) == pytest.approx(kept[-1], rel=1e-6)
        do(server, "frame", number=3)
        third = until(server, lambda now: now["frame"] == 3)
        assert third["time"] == 15.0
        assert numbers(third["values"]).reshape(third["shape"]) == pytest.approx(kept[3], rel=1e-6)
        assert not last["can_steer"] and do(server, "pause")[0] == 400
        drover.restart(path, end=60.0).close()
        do(server, "frame", number=1000)
        until(server, lambda now: now["frames"] == 13 and now["time"] == 60.0)


def test_an_archive_that_is_lost_is_a_sentence_and_one_that_is_none_an_error(tmp_path):
    path = tmp_path / "small.h5"
    drover.Scene.from_dict({**SMALL, "time.end": 5.0}, "small.toml").run(path).close()
    with served(shown.ShownArchive(path)) as server:
        assert not state(server)["error"]
        path.rename(tmp_path / "moved.h5")
        assert "small.h5" in until(server, lambda now: now["error"])["error"]
        (tmp_path / "moved.h5").rename(path)
        until(server, lambda now: not now["error"] and now["time"] == 5.0)
    with pytest.raises(drover.Error, match="none.h5"):
        shown.ShownArchive(tmp_path / "none.h5")


def test_bodies_lie_in_their_cell():
    scene = drover.Scene.load(MODELS / "paper-rod-in-beads.toml").set("time.end", 0.5)
    with served(shown.LiveRun(scene)) as server:
        now = until(server, lambda now: now["state"] == "ended")
        beads, rods = (numbers(now["bodies"][name]) for name in ("beads", "rods"))
        places = numpy.concatenate([beads.reshape(-1, 3)[:, :2], rods.reshape(-1, 4)[:, :2]])
        assert places.min() >= 0.0 and (places <= now["side"]).all() and len(rods) == 4
        assert numpy.hypot(*rods[2:]) <= scene["rods.length"] / 2


def test_pictures_of_large_grids_are_means_and_arrows_keep_the_mean():
    y, x = numpy.mgrid[0:512, 0:256]
    field = 2.0 + numpy.cos(2 * numpy.pi * x / 256)
    picture = pictures.picture_of_fields(0.0, {"a": field, "p_x": field, "p_y": 0.0 * field}, (1.0, 2.0), {})
    assert picture.fields["a"].shape == (128, 128) and picture.step == (4, 2) and picture.is_mean
    assert picture.fields["a"].mean() == pytest.approx(2.0, rel=1e-12)
    assert pictures.maps_of(picture.fields) == ["a", "|p|"]
    arrows = pictures.arrows_of(picture, "p")
    assert len(arrows) <= pictures.MAX_ARROWS ** 2 + 1
    assert arrows[:, :2].min() > 0.0 and arrows[:, :2].max() < 1.0
    # Of a nematic of angle 2 theta = pi / 2, lines along theta = pi / 4.
    picture = pictures.picture_of_fields(0.0, {"q_xx": 0.0 * field, "q_xy": 1.0 + 0.0 * field}, (1.0, 2.0), {})
    assert pictures.arrows_of(picture, "q")[:, 2:] == pytest.approx(numpy.sqrt(0.5), rel=1e-12)


def test_a_page_without_visitors_costs_a_run_nothing():
    what = live()
    with served(what) as server:
        until(server, lambda now: now["state"] == "running")
        what.asked = -1e9
        time.sleep(0.1)
        before = what.number
        began = what.run.step
        while what.run.step < began + 2000:
            time.sleep(0.01)
        assert what.number <= before + 1  # one that was on its way


def test_the_command_prints_its_address_and_ends_on_a_signal(tmp_path):
    scene = tmp_path / "long.toml"
    scene.write_text(drover.Scene.from_dict(LONG).to_toml())
    started = subprocess.Popen([DROVER, "serve", scene, "--set", "noise.order=0.1"], stdout=subprocess.PIPE, text=True,
                               env=environment())
    address = started.stdout.readline().strip()
    with urllib.request.urlopen(address) as answer:
        assert answer.status == 200 and b"<title>drover</title>" in answer.read()
    started.terminate()
    assert started.wait(timeout=30) == 0
    wrong = subprocess.run([DROVER, "serve", tmp_path / "none.h5"], capture_output=True, text=True, check=False,
                           env=environment())
    assert wrong.returncode == 2 and "none.h5" in wrong.stderr and len(wrong.stderr.splitlines()) == 1
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        ended = subprocess.run([DROVER, "serve", scene, "--port", port], capture_output=True, text=True, check=False,
                               env=environment())
    assert ended.returncode == 2 and f"port {port}" in ended.stderr and "--port" in ended.stderr


def test_in_a_browser_a_coefficient_turns_the_flock_and_the_run_stops():
    selenium = pytest.importorskip("selenium.webdriver", reason="needs python3-selenium and chromium-driver")
    options = selenium.ChromeOptions()
    for word in ("--headless=new", "--no-sandbox", "--window-size=1200,900"):
        options.add_argument(word)
    try:
        browser = selenium.Chrome(options=options)
    except Exception as error:
        pytest.skip(f"no chromium with its driver: {error}")
    try:
        with served(live(**FLOCK)) as server:
            browser.get(f"http://127.0.0.1:{server.server_port}/?token={server.token}")
            until(server, lambda now: now["state"] == "running" and now["time"] > 30.0)
            entry = browser.find_element("css selector", 'input[data-key="orienting_field.y"]')
            entry.clear()
            entry.send_keys("0.5\t")
            until(server, lambda now: any(row["key"] == "orienting_field.y" and row["value"] == 0.5
                                          for row in now["coefficients"]))
            now = state(server)
            until(server, lambda later: later["time"] > now["time"] + 60.0)
            arrows = numbers(state(server)["arrows"]).reshape(-1, 4)
            assert (arrows[:, 3] > 1.0).all() and abs(arrows[:, 2]).max() < 0.1  # along y
            browser.find_element("id", "pause").click()
            until(server, lambda later: later["state"] == "paused")
            ends = time.monotonic() + 10.0
            while browser.find_element("id", "state").text != "paused" and time.monotonic() < ends:
                time.sleep(0.1)
            assert browser.find_element("id", "state").text == "paused"
            assert not [line for line in browser.get_log("browser") if line["level"] == "SEVERE"]
    finally:
        browser.quit()
