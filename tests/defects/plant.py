#!/usr/bin/python3
"""tests/defects/plant.py: plants defects in the source, one at a time, and sees which test fails.

    plant.py --copy FOLDER --build FOLDER --output caught.csv [--only NAME ...]

changes the source of a copy of the repository (which must have no changes of its own; it is restored after each
defect), builds the tests of the layer and of those above it, and runs them in that order until one fails.  The table
has the defect, its file, whether it was caught, and by which test.  Rows that exist are kept: re-run to resume.
"""
import argparse
import csv
import re
import subprocess
import sys
from pathlib import Path

LAYERS = ("base", "numerics", "model", "dem", "theory", "physics", "measure", "calibrate", "io", "run", "analysis",
          "jobs")
SKIPPED = "-*Slow*:*Fuzz*"

# name, file, the code as it is, the code with the defect, the layers whose tests run
DEFECTS = (
    ("products are not dealiased", "src/numerics/fields/grid.cpp", "* (degree + 1) < grid.nx", "* 2 < grid.nx",
     ("numerics", "physics")),
    ("phi3 has one wrong factorial", "src/numerics/algebra/block.cpp", "one / factorials[k];",
     "one / factorials[k == 3 ? 2 : k];", ("numerics",)),
    ("a weight of ETDRK2", "src/numerics/steppers/stepper_table.cpp",
     "{{1, {{{1, 1}}}}, {1, {{{1, 1}, {-1, 2}}, {{1, 2}}}}}",
     "{{1, {{{1, 1}}}}, {1, {{{1, 1}, {-0.9, 2}}, {{0.9, 2}}}}}", ("numerics",)),
    ("a weight of ETDRK4", "src/numerics/steppers/stepper_table.cpp",
     "fourth_order_weights{{{1, 1}, {-3, 2}, {4, 3}}",
     "fourth_order_weights{{{1, 1}, {-3, 2}, {3, 3}}",
     ("numerics",)),
    ("transforms are not normalised", "src/numerics/fields/transform.cpp", "1.0 / static_cast<double>(points(grid))",
     "1.0 / static_cast<double>(points(grid) - 1)", ("numerics",)),
    ("a rejected part is resumed at the wrong time", "src/numerics/steppers/adaptive_stepper.cpp",
     "        i *= 2;\n", "        i *= 1;\n", ("numerics", "physics")),
    ("slow modes are left to double precision", "src/numerics/algebra/precise_eigenvalues.cpp",
     "constexpr double digits = 1e6;", "constexpr double digits = 0.0;", ("numerics",)),
    ("shells forget the conjugate modes", "src/numerics/fields/shells.cpp",
     "means[static_cast<std::size_t>(shells.of_mode[mode])] += mode_weight(grid, i) * per_mode[mode];",
     "means[static_cast<std::size_t>(shells.of_mode[mode])] += per_mode[mode];", ("numerics", "measure")),
    ("two levels of the noise path share their numbers", "src/numerics/steppers/noise_path.cpp",
     "((std::uint64_t{1} << level) + in_root) >> 1", "in_root >> 1", ("numerics",)),
    ("beads are carried at half of their flow", "src/physics/rod_bead.toml", "-div(rho v)", "-0.5 div(rho v)",
     ("physics",)),
    ("the linear part is subtracted twice", "src/model/split.cpp", "graph_.number(value),",
     "graph_.number(2.0 * value),", ("physics",)),
    ("half of a slope is propagated", "src/model/split.cpp", "+= value * coefficient;",
     "+= 0.5 * value * coefficient;", ("physics",)),
    ("noise of the order is twice too strong in theory", "src/physics/equations.cpp",
     ".setConstant(number(e.model, field.noise));", ".setConstant(2.0 * number(e.model, field.noise));",
     ("physics",)),
    ("a prediction forgets the direction of the order", "src/run/fields/field_prediction.cpp",
     "turned(equations.model(), state.values, direction.angle)",
     "turned(equations.model(), state.values, 0.0 * direction.angle)", ("app.test_theory",)),
    ("waves of a flock are looked for on one side alone", "src/theory/instabilities.cpp",
     "quarter = land.state.is_mirrored()", "quarter = true", ("theory",)),
    ("the reference density is frozen", "src/model/field_evolution.cpp",
     "if (reference_level == reference_level_) return;",
     "if (reference_level == reference_level_ || reference_level != 0) return;", ("physics",)),
    ("the step error adds a tenth of each step", "src/numerics/steppers/error_evolution.cpp",
     "drive.values[k] = shifted.values[k] / dt;", "drive.values[k] = 0.1 * shifted.values[k] / dt;", ("numerics",)),
    ("errors do not turn between two checks of the step", "src/numerics/steppers/coarse_error.cpp",
     "a * last.values[k] + b * other.values[k];", "last.values[k];", ("numerics",)),
    ("an oscillation at 0 has no error of the step", "src/numerics/steppers/coarse_error.hpp",
     "std::max({size, moments > 0.0 ? fluctuation() : 0.0, 1e-3 * largest})", "std::max(size, 1e-3 * largest)",
     ("numerics",)),
    ("waves within a step are not seen", "src/numerics/steppers/coarse_error.cpp", "constexpr double turn = 0.5;",
     "constexpr double turn = 1e9;", ("physics",)),
    ("noise that multiplies fields does not decay within a step", "src/model/white_noise.cpp",
     "rate += m(k, k).real() / count;", "rate += 0.0 * m(k, k).real() / count;", ("model",)),
    ("two fields draw a noise that they share apart", "src/model/white_noise.cpp",
     "return drives[i].noise == drives[j].noise && drives[i].part == drives[j].part ? 1.0 : 0.0;",
     "return i == j ? 1.0 : 0.0;", ("model",)),
    ("a noise that two fields share does not correlate them", "src/model/white_noise.cpp",
     "    Symbol strengths = shared * shared.adjoint();\n    for",
     "    Symbol strengths = Symbol((shared * shared.adjoint()).diagonal().asDiagonal());\n    for", ("model",)),
    ("noise that multiplies fields is that of the end of a step", "src/numerics/steppers/stepper.cpp",
     "system.product_noise->add(t + 0.5 * dt, state, product_noise, next);",
     "const Spectra ended = next; system.product_noise->add(t + 0.5 * dt, ended, product_noise, next);", ("model",)),
    ("a mass is clipped", "src/model/point_functions.cpp", "const double over = 1.0 / mass[i];",
     "const double over = 1.0 / (mass[i] < 0.5 ? 0.5 : mass[i]);", ("model", "physics")),
    ("the drag of a balance forgets its products", "src/model/equation_checks.cpp",
     "algebra.graph.make(Operation::add, algebra.graph.number(own), slope)", "algebra.graph.number(own)",
     ("physics",)),
    ("an exponent of number fluctuations is of the variance", "src/run/report/report.cpp",
     "? 0.5 * std::log(variance[b + 1]", "? std::log(variance[b + 1]", ("app.test_theory",)),
    ("the jackknife error is too small", "src/measure/statistics.cpp", "std::sqrt((count - 1.0) / count * sum",
     "std::sqrt(1.0 / count * sum", ("measure",)),
    ("the autocorrelation time is not corrected", "src/measure/statistics.cpp",
     "sum * (1.0 + (2.0 * static_cast<double>(window) + 1.0) / n)", "sum", ("measure",)),
    ("blocks cut waves", "src/measure/statistics.cpp",
     "std::max(correlation.integrated, correlation.coherence)", "correlation.integrated", ("measure",)),
    ("a bounce with the wrong sign of e", "src/dem/impact/impact.hpp", "-(1.0 + restitution) * opening_speed",
     "-(1.0 - restitution) * opening_speed", ("dem",)),
    ("friction is not limited by sticking", "src/dem/impact/impact.hpp",
     "std::min(friction * normal, slip / slip_response)", "friction * normal", ("dem",)),
    ("free flight falls twice as far", "src/dem/flight/bead_flight.cpp",
     "a * (0.5 * tau * tau)", "a * (tau * tau)", ("dem",)),
    ("a turned axis loses its length", "src/dem/bodies/rotation.hpp",
     "double cosine = 0.5 -", "double cosine = 0.25 -", ("dem",)),
    ("a coefficient of the plates' cosine", "src/dem/bodies/plate_motion.hpp",
     "1.0 - square * (0.5 - square * (1.0 / 24.0",
     "1.0 - square * (0.4 - square * (1.0 / 24.0", ("dem",)),
    ("the work of friction counts the speed before alone", "src/dem/impact/impact_increment.hpp",
     "0.5 * (x * (before.x + now.x) + y * (before.y + now.y))", "(x * before.x + y * before.y)", ("dem",)),
    ("lambda of a single rod is that of the mean", "src/physics/rod_bead.toml", "single-rod = 0.5", "single-rod = 1.0",
     ("physics", "run")),
    ("the closure of K3 is twice too large", "src/calibrate/closures.cpp", "/ (16.0 * m[relaxation])",
     "/ (8.0 * m[relaxation])", ("calibrate",)),
    ("a measured number is rounded away", "src/base/text.cpp", "std::log10(error * (1.0 + 1e-12)))) - 1;",
     "std::log10(error * (1.0 + 1e-12))));", ("base",)),
    ("errors that other seeds contradict are kept", "src/jobs/tradeoff/trade_bench.cpp",
     "min_error_[w] = seeds.deviation *", "min_error_[w] = 0.0 * seeds.deviation *", ("app.test_tradeoff",)),
    ("a frame on other points loses a mode", "src/run/fields/field_problem.cpp", "= given[c][at_source[k].fine];",
     "= k == 1 ? numerics::Complex(0.0) : given[c][at_source[k].fine];", ("app.test_start",)),
    ("a followed state keeps its number", "src/analysis/states.cpp",
     "key.empty() ? line : run::scene_with(line, key, value)", "line",
     ("app.test_own_states",)),
    ("correlated blocks count as independent", "src/measure/statistics.cpp",
     "> 2.5 / std::sqrt(count)", "> 1e9 / std::sqrt(count)", ("measure",)),
    ("the mean of a field is fitted as a wave", "src/analysis/wave_fit.cpp", "constexpr double share = 0.1;",
     "constexpr double share = 10.0;", ("app.test_unusual_errors",)),
    ("a warm-up forgets the means of scalars", "src/measure/fields.cpp", "constexpr double times = 40.0;",
     "constexpr double times = 1e9;", ("app.test_unusual_errors",)),
    ("rates that are exactly 0 stop Newton's method", "src/theory/states.cpp", "sizes = there.cwiseMax(1e-14 * ",
     "sizes = there.cwiseMax(0.0 * ", ("theory", "app.test_unusual_errors")),
    ("conserved sums are among the perturbations", "src/numerics/solvers/travelling_state.cpp",
     "constexpr double of_differences = 1e-9;", "constexpr double of_differences = 0.0;",
     ("app.test_unusual_models",)),
    ("a restart forgets the division of a step", "src/numerics/steppers/watched_stepper.cpp",
     "    stepper_.set_division(static_cast<int>(division));\n", "",
     ("physics", "app.test_step_error", "app.test_same_bytes")),
)


def ended(words, folder):
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, errors="replace", check=False)


def catcher(copy, build, layers):
    """The first test that fails; "": none does."""
    for layer in layers:
        if layer.startswith("app."):
            built = ended(["ninja", "-j1", "drover_program"], build)
            if built.returncode != 0:
                return "the compiler"
            tried = ended(["ctest", "-R", f"^{layer}$"], build)
            if tried.returncode != 0:
                return layer
            continue
        if ended(["ninja", "-j1", f"test_{layer}"], build).returncode != 0:
            return "the compiler"
        tried = ended([f"tests/test_{layer}", f"--gtest_filter={SKIPPED}", "--gtest_fail_fast"], build)
        if tried.returncode != 0:
            failed = re.findall(r"\[  FAILED  \] (\S+?)[,\s]", tried.stdout)
            return f"{layer}: {failed[0]}" if failed else f"{layer}: ended with {tried.returncode}"
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--copy", type=Path, required=True)
    parser.add_argument("--build", type=Path, required=True)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--only", nargs="*", default=[])
    options = parser.parse_args()
    known = set()
    if options.output.exists():
        with open(options.output, newline="") as file:
            known = {row["defect"] for row in csv.DictReader(file)}
    missed = []
    with open(options.output, "a", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        if not known:
            writer.writerow(("defect", "file", "caught by"))
        for name, path, code, defect, layers in DEFECTS:
            if name in known or (options.only and name not in options.only):
                continue
            source = options.copy / path
            text = source.read_text()
            if text.count(code) != 1:
                sys.exit(f"{path} contains {code!r} {text.count(code)} times; expected once: mend DEFECTS")
            source.write_text(text.replace(code, defect))
            try:
                caught = catcher(options.copy, options.build, layers)
            finally:
                source.write_text(text)
            missed += [] if caught else [name]
            writer.writerow((name, path, caught or "MISSED"))
            file.flush()
            print(f"{name}: {caught or 'MISSED'}", flush=True)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
