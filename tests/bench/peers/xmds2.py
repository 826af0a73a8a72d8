#!/usr/bin/python3
"""tests/bench/peers/xmds2.py: the cost of an error in drover and in XMDS2, on the same equations.

The two-component equations with a smooth start and no noise, in a periodic cell, to t = 4 s.  XMDS2 (Debian package
`xmds2`) generates a C++ program for them: all fields in one vector, the diffusive linear terms in the interaction
picture (operators IP), all derivatives by operators EX, compiled with its own options (-O3 -march=native -ffast-math).
Methods: RK4 with fixed steps, ARK45 with tolerances.

    xmds2.py --drover build/release/drover              an hour; writes settings.csv, xmds2.csv and xmds2.md here
    xmds2.py --drover PATH --problems mild --free --errors 1e-2 1e-4 --pairs 1 --folder DIR     a few minutes

Settings that settings.csv holds are not run again: the search goes on where it was stopped.  Two problems: in "mild"
sound, drag and viscosity of the beads are four to five times smaller than in "stiff", where explicit methods need
shorter steps.

1. Reference: drover with a step of 1/200 s on the grid of --grid points; XMDS2's own finest run must agree with it.
2. Each setting (method and step or tolerance; with the free grid also the grid) runs once, which gives its error: the
   largest over the fields of the root mean square of the difference, relative to that of the field less its mean.
   A run of more than --limit core seconds is stopped, and with it the finer settings of its method.
3. For each error of the ladder, the cheapest settings of both that reach it run again in turns, --pairs times each.
   Costs are core seconds (user and system) of the whole process, from its start to its files; medians.

drover drops modes beyond a quarter of the grid (exact products); XMDS2 keeps all.  Exit status 1: the two disagree.
"""
import argparse
import csv
import datetime
import itertools
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import KeptTable, settings_of  # noqa: E402

SIDE, END = 64.0, 4.0
METHODS = ("etdrk2", "etdrk4", "etdrk4-krogstad", "etd-abm4", "etd-abm5", "etd-abm6")
FIELDS = {"rho": "bead_density", "sigma": "rod_density", "vx": "bead_velocity_x", "vy": "bead_velocity_y",
          "px": "polar_order_x", "py": "polar_order_y"}
START = {"rho": "1 + 0.1*sin(2*pi*x/64)", "sigma": "1 + 0.1*cos(2*pi*x/64)*cos(2*pi*y/64)",
         "vx": "0.05*sin(2*pi*y/64)", "vy": "0.05*cos(2*pi*x/64)",
         "px": "0.5 + 0.1*sin(2*pi*y/64)", "py": "0.1*cos(2*pi*(x + y)/64)"}
# drover's keys, with the symbol of each in the XMDS2 script.
COEFFICIENTS = {"current.speed": ("u", 1.0), "inertia.bead_mass": ("m", 1.0), "drag.coefficient": ("Gamma", 20.0),
                "viscosity.shear": ("eta", 5.0), "driving.strength": ("alpha", 10.0), "stiffness.beads": ("E", 40.0),
                "stiffness.rods": ("F", 1.0), "relaxation.rate": ("a", 0.2), "relaxation.saturation": ("b", 1.0),
                "elasticity.stiffness": ("K", 1.0), "weathercock.strength": ("lambda", 1.0),
                "advection.strength": ("w", 0.3), "pressure.beads": ("A", 0.5), "pressure.rods": ("B", 0.5),
                "diffusion.rods": ("D", 0.5)}
# What "mild" changes: sound of 1.6 instead of 6.3 mm/s, drag of 5 instead of 20 /s, a fifth of the viscosity.
PROBLEMS = {"mild": {"drag.coefficient": 5.0, "driving.strength": 2.5, "stiffness.beads": 2.5, "viscosity.shear": 1.0},
            "stiff": {}}
COLUMNS = ["problem", "code", "grid", "method", "control", "error", "seconds"]
XMDS2 = """<?xml version="1.0" encoding="UTF-8"?>
<simulation xmds-version="2">
  <name>peer</name>
  <features>
    <fftw plan="{plan}" />
    <validation kind="run-time" />
    <arguments>
      <argument name="points" type="integer" default_value="64" />
    </arguments>
    <globals><![CDATA[ {constants} ]]></globals>
  </features>
  <geometry>
    <propagation_dimension>t</propagation_dimension>
    <transverse_dimensions>
      <dimension name="x" lattice="points" domain="(0, {side})" />
      <dimension name="y" lattice="points" domain="(0, {side})" />
    </transverse_dimensions>
  </geometry>
  <vector name="main" type="complex" initial_basis="x y">
    <components>rho sigma vx vy px py</components>
    <initialisation><![CDATA[ const double pi = M_PI; {start} ]]></initialisation>
  </vector>
  <sequence>
    <integrate algorithm="{algorithm}" interval="{end}" {control}>
      <samples>1</samples>
      <operators>
        <integration_vectors>main</integration_vectors>
        <operator kind="ip" constant="yes" type="real">
          <operator_names>Ls Lv Lp</operator_names>
          <![CDATA[
            const double kk = kx*kx + ky*ky;
            Ls = -D*kk;
            Lv = -(Gamma + eta*kk)/m;
            Lp = -a - K*kk;
          ]]>
        </operator>
        <operator kind="ex" constant="yes" type="complex">
          <operator_names>dx dy lap</operator_names>
          <![CDATA[ dx = i*kx; dy = i*ky; lap = -(kx*kx + ky*ky); ]]>
        </operator>
        <![CDATA[
          const double r = rho.Re(), pX = px.Re(), pY = py.Re(), vX = vx.Re(), vY = vy.Re();
          const double rx = dx[rho].Re(), ry = dy[rho].Re(), sx = dx[sigma].Re(), sy = dy[sigma].Re();
          const double pxx = dx[px].Re(), pxy = dy[px].Re(), pyx = dx[py].Re(), pyy = dy[py].Re();
          const double over = 1.0/(m*r), rest = over - 1.0/m, b2 = b*(pX*pX + pY*pY);
          const double gx = rest*(eta*lap[vx].Re() - Gamma*vX) + over*(alpha*pX - E*rx - F*sx);
          const double gy = rest*(eta*lap[vy].Re() - Gamma*vY) + over*(alpha*pY - E*ry - F*sy);
          const double hx = lambda*vX - w*(pX*pxx + pY*pxy) - b2*pX - A*rx - B*sx;
          const double hy = lambda*vY - w*(pX*pyx + pY*pyy) - b2*pY - A*ry - B*sy;
          drho_dt = -r*(dx[vx].Re() + dy[vy].Re()) - vX*rx - vY*ry;
          dsigma_dt = Ls[sigma] - u*(pxx + pyy);
          dvx_dt = Lv[vx] + gx;
          dvy_dt = Lv[vy] + gy;
          dpx_dt = Lp[px] + hx;
          dpy_dt = Lp[py] + hy;
        ]]>
      </operators>
    </integrate>
  </sequence>
  <output format="hdf5" filename="peer.xsil">
    <sampling_group basis="x y" initial_sample="no">
      <moments>{moments}</moments>
      <dependencies>main</dependencies>
      <![CDATA[ {samples} ]]>
    </sampling_group>
  </output>
</simulation>
"""


def parsed(arguments):
    summary, _, rest = __doc__.partition("\n\n")
    parser = argparse.ArgumentParser(description=summary, epilog=rest,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", required=True, help="the program")
    parser.add_argument("--grid", type=int, default=256, help="points along each axis of the fixed grid")
    parser.add_argument("--problems", nargs="+", default=list(PROBLEMS), choices=PROBLEMS)
    parser.add_argument("--limit", type=int, default=60, help="core seconds that one run may take")
    parser.add_argument("--free", type=int, nargs="*", default=[32, 64, 128], help="the other grids of the free grid")
    parser.add_argument("--pairs", type=int, default=3, help="timed runs of each of the chosen settings")
    parser.add_argument("--errors", type=float, nargs="+", default=[1e-2, 1e-4, 1e-6, 1e-8])
    parser.add_argument("--plan", default="measure", choices=["estimate", "measure", "patient"], help="FFTW, of XMDS2")
    parser.add_argument("--folder", type=Path, default=Path(__file__).parent, help="of the tables")
    return parser.parse_args(arguments)


def timed(command, folder, limit):
    """Core seconds of a process; RuntimeError where it fails or needs more than `limit`."""
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                               env={**os.environ, "OMP_NUM_THREADS": "1"},
                               preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit)))
    messages = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        raise RuntimeError(f"{command[0]} ended with {os.waitstatus_to_exitcode(status)}: {messages.strip()[-300:]}")
    return usage.ru_utime + usage.ru_stime


class Drover:
    name = "drover"

    def __init__(self, program, folder, values):
        self.program, self.folder = str(Path(program).resolve()), folder
        sections = {}
        for key, value in values.items():
            section, name = key.split(".")
            sections.setdefault(section, []).append(f"{name} = {value}")
        sections["fields"] = ["bead_density = true", 'bead_velocity = "dynamic"']
        sections["uniform"] = ["rod_density = 1.0", "bead_density = 1.0"]
        sections["initial"] = ['kind = "formula"', *(f'{FIELDS[name]} = "{text}"' for name, text in START.items())]
        text = "\n".join(f"[{name}]\n" + "\n".join(lines) for name, lines in sections.items())
        (folder / "peer.toml").write_text(text + "\n")

    def settings(self, grids):
        steps = (5, 6, 8, 10, 14, 20, 28, 40, 56, 80, 112, 160, 224, 320)
        for grid, method in itertools.product(grids, METHODS):
            for count in steps:
                yield {"grid": grid, "method": method, "control": f"{count} steps", "steps": count}

    def command(self, setting):
        keys = {"grid.nx": setting["grid"], "grid.ny": setting["grid"], "grid.lx": SIDE, "grid.ly": SIDE,
                "time.dt": END / setting["steps"], "time.end": END, "time.stepper": setting["method"],
                "time.max_error": 0.0, "output.frame_every": END, "output.sample_every": END, "run.threads": 1}
        return [self.program, "run", "peer.toml", "--quiet", "--overwrite", "--output", "peer.h5", *settings_of(keys)]

    def run(self, setting, limit=resource.RLIM_INFINITY):
        seconds = timed(self.command(setting), self.folder, limit)
        with h5py.File(self.folder / "peer.h5") as file:
            return seconds, {name: file[key][-1] for name, key in FIELDS.items()}


class Xmds2:
    name = "XMDS2"

    def __init__(self, plan, folder, values):
        self.plan, self.folder, self.values, self.made = plan, folder, values, {}

    def settings(self, grids):
        for grid in grids:
            for count in (28, 40, 56, 80, 112, 160, 224, 320, 640):
                yield {"grid": grid, "method": "RK4", "control": f"{count} steps", "words": f'steps="{count}"'}
            for tolerance in (1e-2, 1e-4, 1e-6, 1e-8):
                yield {"grid": grid, "method": "ARK45", "control": f"tolerance {tolerance:g}",
                       "words": f'steps="40" tolerance="{tolerance}"'}

    def program(self, method, control):
        """Generates and compiles a program, once: the grid is an argument, the steps and the tolerance are not."""
        if (method, control) not in self.made:
            folder = self.folder / f"{method}-{len(self.made)}"
            folder.mkdir()
            constants = " ".join(f"const double {COEFFICIENTS[key][0]} = {value};"
                                 for key, value in self.values.items())
            (folder / "peer.xmds").write_text(XMDS2.format(
                plan=self.plan, constants=constants, side=SIDE, end=END, algorithm=method,
                control=control,
                start=" ".join(f"{name} = {text};" for name, text in START.items()),
                moments=" ".join(f"{name}_" for name in FIELDS),
                samples=" ".join(f"{name}_ = {name}.Re();" for name in FIELDS)))
            made = subprocess.run(["xmds2", "peer.xmds"], cwd=folder, capture_output=True, text=True, check=False)
            if made.returncode != 0:
                raise RuntimeError(f"xmds2 failed: {made.stdout[-2000:]}{made.stderr[-2000:]}")
            self.made[method, control] = folder
        return self.made[method, control]

    def run(self, setting, limit=resource.RLIM_INFINITY):
        folder = self.program(setting["method"], setting["words"])
        seconds = timed(["./peer", f"--points={setting['grid']}"], folder, limit)
        with h5py.File(folder / "peer.h5") as file:
            group = file["1"]
            return seconds, {name: np.squeeze(group[f"{name}_"][()]).T for name in FIELDS}


def error_of(fields, reference):
    worst = 0.0
    for name, wanted in reference.items():
        every = wanted.shape[0] // fields[name].shape[0]
        common = wanted[::every, ::every]
        difference = np.sqrt(np.mean((fields[name] - common) ** 2))
        if not np.isfinite(difference):
            return np.inf
        worst = max(worst, difference / np.sqrt(np.mean((common - common.mean()) ** 2)))
    return worst


def name_of(setting):
    return str(setting["grid"]), setting["method"], setting["control"]


def measure(code, problem, grids, reference, least, limit, kept):
    """Adds rows of all settings to `kept`; a method is left once it is accurate enough or takes too long."""
    before = {name_of(row): row for row in kept.rows if row["problem"] == problem and row["code"] == code.name}
    done = set()
    for setting in code.settings(grids):
        method = (setting["grid"], setting["method"])
        if method in done:
            continue
        row = before.get(name_of(setting))
        if row is None:
            row = {"problem": problem, "code": code.name} | {key: setting[key] for key in ("grid", "method", "control")}
            try:
                row["seconds"], fields = code.run(setting, limit)
                row["error"] = error_of(fields, reference)
            except (RuntimeError, OSError, KeyError) as failure:
                row |= {"seconds": np.inf, "error": np.inf}
                print(f"{code.name} {setting}: {failure}", file=sys.stderr)
            kept.add(row)
            print(f"{problem} {code.name:7} {setting['grid']:4} {setting['method']:16} {setting['control']:16} "
                  f"error {row['error']:.2e} {row['seconds']:.3f} s", file=sys.stderr)
        if float(row["error"]) < least or float(row["seconds"]) == np.inf:
            done.add(method)


def compared(codes, problem, rows, errors, pairs, label):
    """A row for each error: the cheapest setting of each code, timed in turns."""
    table = []
    for wanted in errors:
        best = [min((row for row in rows if (row["problem"], row["code"]) == (problem, code.name)
                     and float(row["error"]) <= wanted), default=None, key=lambda row: float(row["seconds"]))
                for code in codes]
        if None in best:
            print(f"{problem}, {label} grid: an error of {wanted:g} is not reached by both", file=sys.stderr)
            continue
        settings = [next(setting for setting in code.settings([int(chosen["grid"])])
                         if name_of(setting) == name_of(chosen)) for code, chosen in zip(codes, best)]
        seconds = [[], []]
        for _ in range(pairs):
            for k, code in enumerate(codes):
                seconds[k].append(code.run(settings[k])[0])
        medians = [statistics.median(values) for values in seconds]
        row = {"problem": problem, "grid": label, "wanted": wanted, "ratio": medians[1] / medians[0]}
        for code, chosen, median in zip(codes, best, medians):
            row |= {f"{code.name} {key}": chosen[key] for key in ("method", "control", "grid", "error")}
            row[f"{code.name} seconds"] = median
        table.append(row)
    return table


def write_tables(table, folder, versions):
    with open(folder / "xmds2.csv", "w", newline="", encoding="utf-8") as file:
        file.write(f"# {versions}\n")
        writer = csv.DictWriter(file, table[0].keys())
        writer.writeheader()
        writer.writerows({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in row.items()}
                         for row in table)
    lines = [f"{versions}. Core seconds of the whole process, one core, medians of alternate runs.", "",
             "| problem | grid | error | drover | | XMDS2 | | ratio |", "|---|---|---|---|---|---|---|---|"]
    for row in table:
        cells = [f"{row[f'{code} method']}, {row[f'{code} control']}, {row[f'{code} grid']}² | "
                 f"{row[f'{code} seconds']:.2f} s" for code in ("drover", "XMDS2")]
        lines.append(f"| {row['problem']} | {row['grid']} | {row['wanted']:g} | {cells[0]} | {cells[1]} | "
                     f"{row['ratio']:.1f} |")
    (folder / "xmds2.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


def processor():
    """The name of the processor, for the table."""
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), "unknown processor")


def main(arguments):
    options = parsed(arguments)
    if not shutil.which("xmds2"):
        sys.exit("error: xmds2 is not installed; install the Debian package xmds2")
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    kept, table, agree = KeptTable(options.folder / "settings.csv", COLUMNS), [], {}
    for problem in options.problems:
        with tempfile.TemporaryDirectory() as name:
            values = {key: value for key, (_, value) in COEFFICIENTS.items()} | PROBLEMS[problem]
            codes = [Drover(options.drover, Path(name), values), Xmds2(options.plan, Path(name), values)]
            reference = codes[0].run({"grid": options.grid, "method": "etdrk4-krogstad", "steps": 800})[1]
            for label, grids in (("fixed", [options.grid]), ("free", options.free)):
                if grids:
                    for code in codes:
                        measure(code, problem, grids, reference, min(options.errors), options.limit, kept)
                    allowed = [row for row in kept.rows if label == "free" or int(row["grid"]) == options.grid]
                    table += compared(codes, problem, allowed, options.errors, options.pairs, label)
            agree[problem] = min(float(row["error"]) for row in kept.rows
                                 if (row["problem"], row["code"]) == (problem, "XMDS2"))
    version = subprocess.run([codes[0].program, "--version"], capture_output=True, text=True,
                             check=True).stdout.split("\n")[0]
    write_tables(table, options.folder, f"{datetime.date.today()}, {processor()}, {version}, "
                 f"XMDS2 3.1 (FFTW: {options.plan}), {options.grid}², t = {END:g} s, no noise")
    print(*(f"{problem}: XMDS2 agrees with the reference of drover to {error:.1e}" for problem, error in agree.items()),
          sep="\n")
    return 0 if max(agree.values()) < 1e-6 else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
