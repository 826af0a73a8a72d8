"""drover/server.py: a page in a browser that shows a run, and steers one that is computed here.

    python3 -P -m drover.server SCENE|ARCHIVE [--port N] [--set SECTION.KEY=VALUE ...]

The server listens at 127.0.0.1 alone, and answers only to the token in the address that it prints.
"""
import argparse
import base64
import hmac
import json
import secrets
import signal
import sys
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import numpy

from drover import pictures
from drover.error import Error, status_of
from drover.fields import shipped_fields
from drover.shown import LiveRun, ShownArchive
from drover.text import printable

HOST = "127.0.0.1"
LONGEST_REQUEST = 1 << 16  # bytes
WAIT = 1.0                 # s that an answer waits for something new
SHADES = 256


class Server(ThreadingHTTPServer):
    """Shows one run.  Raises Error where the port is taken."""

    daemon_threads = True

    def __init__(self, shown, port=0):
        self.shown, self.token = shown, secrets.token_urlsafe(16)
        try:
            super().__init__((HOST, port), Handler)
        except OSError as error:
            raise Error(f"port {port} cannot be used ({error.strerror}); choose another one with --port, or leave it "
                        "out for a free one") from error

    @property
    def address(self):
        return f"http://{HOST}:{self.server_port}/?token={self.token}"

    def handle_error(self, request, client_address):
        """A browser that has closed its page is no error."""
        if not isinstance(sys.exc_info()[1], ConnectionError):
            super().handle_error(request, client_address)


class Handler(BaseHTTPRequestHandler):
    """GET / the page, GET /state what it shows, POST /do what it asks for."""

    protocol_version = "HTTP/1.1"

    def do_GET(self):
        address = urlsplit(self.path)
        query = {name: values[-1] for name, values in parse_qs(address.query).items()}
        if not self.is_allowed(query.get("token", "")):
            return
        if address.path == "/":
            self.answer(200, "text/html; charset=utf-8", page())
        elif address.path == "/state":
            try:
                seen = int(query.get("after", "-1"))
            except ValueError:
                self.answer(400, "text/plain", b"after is no number; expected that of the state seen last\n")
                return
            self.answer(200, "application/json", json.dumps(state_of(self.server.shown, seen, query)).encode())
        else:
            self.answer(404, "text/plain", b"there is no such page\n")

    def do_POST(self):
        given = self.headers.get("Content-Length") or "0"
        length = int(given) if given.isascii() and given.isdigit() and len(given) < 10 else -1
        if not 0 < length <= LONGEST_REQUEST:
            self.close_connection = True
            self.answer(413, "text/plain", f"expected 1 to {LONGEST_REQUEST} bytes\n".encode())
            return
        content = self.rfile.read(length)
        if not self.is_allowed(self.headers.get("X-Drover-Token", "")):
            return
        try:
            command = json.loads(content)
            self.server.shown.request(command.pop("action"), **command)
        except (ValueError, KeyError, TypeError, AttributeError, OverflowError) as error:
            self.answer(400, "text/plain", printable(f"this is no action: {error}\n").encode())
            return
        self.answer(200, "application/json", b"{}")

    def is_allowed(self, token):
        """Another page in the browser knows neither the token nor, by a name of its own for 127.0.0.1, the host."""
        hosts = {f"{name}:{self.server.server_port}" for name in (HOST, "localhost")}
        if self.headers.get("Host") in hosts and hmac.compare_digest(token.encode(), self.server.token.encode()):
            return True
        self.answer(403, "text/plain", b"wrong token; open the address that drover serve printed\n")
        return False

    def answer(self, status, kind, content):
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_):
        """Says nothing."""


def page():
    from matplotlib import colormaps
    colours = {name: (255 * colormaps[shade](numpy.linspace(0, 1, SHADES))[:, :3]).round().astype(int).tolist()
               for name, shade in (("size", "viridis"), ("signed", "RdBu_r"))}
    text = (Path(__file__).with_name("server.html")).read_text(encoding="utf-8")
    return text.replace("/*COLOURS*/null", json.dumps(colours)).encode()


def packed(array):
    """Numbers of single precision, as a page reads them."""
    return base64.b64encode(numpy.ascontiguousarray(array, "<f4").tobytes()).decode()


def state_of(shown, seen, query):
    """What a page shows after the state `seen`: the map, arrows, series and spectrum that its query names, or the first
    of each."""
    number = shown.wait_for(seen, WAIT)
    state = {"number": number, "name": printable(Path(shown.name).name), "state": shown.state,
             "error": printable(shown.error), "warnings": [printable(words) for words in shown.warnings],
             "units": shown.units, "progress": shown.progress, "speed": shown.speed,
             "coefficients": shown.coefficients, "can_steer": isinstance(shown, LiveRun),
             "frames": getattr(shown, "frames", 0), "frame": getattr(shown, "shown", 0)}
    picture, observables = shown.picture, shown.observables
    if picture is not None and number > seen:
        state |= {"time": picture.time, "side": picture.side, **map_state(picture, query),
                  "bodies": {name: packed(rows) for name, rows in picture.bodies.items()}}
    if observables is not None and number > seen:
        state |= curve_state(observables, query)
    return state


def map_state(picture, query):
    if not picture.fields:
        return {}
    maps, pairs = pictures.maps_of(picture.fields), pictures.pairs_of(picture.fields)
    shown = chosen(maps, query.get("map"), next((field.name for field in shipped_fields() if field.name in maps),
                                                 maps[0]))
    values = pictures.map_of(picture, shown)
    vector = chosen(["none", *pairs], query.get("arrows"), [*pairs][-1] if pairs else "none")
    arrows = numpy.zeros((0, 4)) if vector == "none" else pictures.arrows_of(picture, vector)
    unit = picture.units.get(pairs[shown.strip("|")][0] if shown.startswith("|") else shown, "1")
    points = "means of {} by {} points" if picture.is_mean else "one of {} by {} points"
    return {"maps": maps, "map": shown, "values": packed(values), "shape": values.shape, "unit": unit,
            "vectors": ["none", *pairs], "arrows": packed(arrows), "vector": vector,
            "has_heads": vector != "none" and pairs[vector][0].endswith("_x"),
            "points": "" if picture.step == (1, 1) else points.format(*reversed(picture.step))}


def curve_state(observables, query):
    numbers, spectra = pictures.curves_of(observables)
    state = {"series": numbers, "spectra": spectra}
    if numbers and observables.sizes["time"] > 0:
        shown = chosen(numbers, query.get("series"))
        times, values = pictures.curve_of(observables, shown)
        state["curve"] = {"name": shown, "x": packed(times), "y": packed(values),
                          "unit": observables[shown].attrs.get("units", "1")}
    if spectra and observables.sizes["time"] > 0:
        shown = chosen(spectra, query.get("spectrum"))
        waves, values = pictures.spectrum_of(observables, shown)
        state["structure"] = {"name": shown, "x": packed(waves), "y": packed(values)}
    return state


def chosen(names, wanted, default=None):
    return wanted if wanted in names else default or names[0]


def shown_of(run, settings=()):
    """A run that starts here of a scene, given as one or as a file (.toml), or the run of an archive."""
    from drover.scene import Scene, restored
    if isinstance(run, Scene):
        return LiveRun(run)
    if Path(run).suffix != ".toml":
        if settings:
            raise Error(f"{run} is no scene (.toml), and --set changes scenes alone; expected it without --set")
        return ShownArchive(Path(run))
    scene = Scene.load(run)
    return LiveRun(restored(scene._text, scene.name, list(settings)) if settings else scene)


def serve(run, *, port=0):
    """Shows a run in a browser on this machine, as `drover serve`, until Ctrl-C; prints the address to open.

    `run`: a Scene or the path of one (.toml), which is run in memory and can be steered, or the path of an archive.
    `port`: on 127.0.0.1; 0: a free one.
    """
    serve_shown(shown_of(run), port)


def serve_shown(shown, port):
    try:
        with Server(shown, port) as server:
            print(f"{server.address}\nOpen this address in a browser on this machine; Ctrl-C ends.", flush=True)
            server.serve_forever(poll_interval=0.1)
    except KeyboardInterrupt:  # the end
        pass
    finally:
        shown.close()


def stop(*_):
    raise KeyboardInterrupt


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -P -m drover.server", description="Shows a run in a browser.")
    parser.add_argument("run", help="scene (.toml), which is run and can be steered, or archive of a run")
    parser.add_argument("--port", type=int, default=0, help="port on 127.0.0.1; default: a free one")
    parser.add_argument("--set", action="append", default=[], help="of a scene: section.key=value")
    options = parser.parse_args(arguments)
    signal.signal(signal.SIGTERM, stop)
    return status_of(lambda: serve_shown(shown_of(options.run, options.set), options.port))


if __name__ == "__main__":
    sys.exit(main())
