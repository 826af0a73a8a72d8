"""backend.py: builds a wheel for pip: the Python package with its module, compiled by CMake in build/wheel."""
import base64
import hashlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

TREE = Path(__file__).resolve().parents[2]
BUILD = TREE / "build" / "wheel"


def version():
    return re.search(r"project\(drover VERSION (\S+)", (TREE / "CMakeLists.txt").read_text())[1]


def metadata():
    import tomllib
    project = tomllib.loads((TREE / "pyproject.toml").read_text())["project"]
    lines = ["Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {version()}",
             f"Summary: {project['description']}", f"License: {project['license']['text']}",
             f"Requires-Python: {project['requires-python']}"]
    return "\n".join([*lines, *(f"Requires-Dist: {name}" for name in project["dependencies"]), ""])


def compile_module():
    """Compiles the module with the Python that runs this; returns its file."""
    jobs = str(len(os.sched_getaffinity(0)))
    missing = [name for name in ("cmake", "ninja", "g++") if shutil.which(name) is None]
    if missing:
        raise SystemExit(f"drover: {', '.join(missing)} not found; expected the packages that .ci/setup installs: run "
                         "it, as root or with sudo")
    for words in (["-S", str(TREE), "-B", str(BUILD), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                   "-DCMAKE_UNITY_BUILD=ON", "-DDROVER_TESTS=OFF", f"-DPython3_EXECUTABLE={sys.executable}"],
                  ["--build", str(BUILD), "--parallel", jobs, "--target", "drover_python"]):
        build(["cmake", *words])
    return next((BUILD / "python" / "drover").glob("_drover.*.so"))


def build(words):
    """Runs a command; its progress, "[12/270] ...", goes to the terminal too, which pip hides from commands."""
    try:
        terminal = open("/dev/tty", "w", encoding="utf-8")  # pylint: disable=consider-using-with
    except OSError:
        terminal = None
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            print(line, end="", flush=True)  # shown by pip -v
            found = re.match(r"\[\d+/\d+\]", line)
            if terminal and found:
                terminal.write(f"\r  drover: compiling {found[0]} ")
                terminal.flush()
    if terminal:
        terminal.write("\r" + " " * 40 + "\r")
        terminal.close()
    if process.returncode:
        raise SystemExit(f"drover: {' '.join(words[:2])} ... failed with status {process.returncode}; its messages are "
                         "above (pip -v)")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """The hook of PEP 517; returns the name of the wheel."""
    tag = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    platform = re.sub(r"[-.]", "_", sysconfig.get_platform())
    information = f"drover-{version()}.dist-info"
    module = compile_module()
    package = TREE / "src" / "python" / "drover"
    contents = {f"drover/{path.relative_to(package)}": path.read_bytes() for path in sorted(package.rglob("*"))
                if path.is_file() and "__pycache__" not in path.parts}
    contents[f"drover/{module.name}"] = module.read_bytes()
    contents[f"{information}/METADATA"] = metadata().encode()
    contents[f"{information}/WHEEL"] = (f"Wheel-Version: 1.0\nGenerator: drover\nRoot-Is-Purelib: false\n"
                                        f"Tag: {tag}-{tag}-{platform}\n").encode()
    record = "".join(f"{name},sha256={digest(content)},{len(content)}\n" for name, content in contents.items())
    contents[f"{information}/RECORD"] = f"{record}{information}/RECORD,,\n".encode()
    name = f"drover-{version()}-{tag}-{tag}-{platform}.whl"
    with zipfile.ZipFile(Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, content in contents.items():
            wheel.writestr(path, content)
    return name


def digest(content):
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()


def get_requires_for_build_wheel(config_settings=None):
    return []
