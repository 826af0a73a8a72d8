"""tests/app/test_wheel.py: the wheel that pip builds, without its compilation."""
import base64
import csv
import hashlib
import importlib.util
import io
import re
import zipfile
from email import message_from_string

import pytest
from support import MODELS

TREE = MODELS.parent
PACKAGE = TREE / "src" / "python" / "drover"


@pytest.fixture(name="backend")
def the_backend():
    spec = importlib.util.spec_from_file_location("backend", TREE / "src" / "python" / "backend.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_wheel_holds_the_package_with_its_digests(backend, tmp_path, monkeypatch):
    compiled = tmp_path / "_drover.cpython-311.so"
    compiled.write_bytes(b"\x7fELF")
    monkeypatch.setattr(backend, "compile_module", lambda: compiled)
    name = backend.build_wheel(tmp_path)
    assert re.fullmatch(r"drover-[\d.]+-cp3\d+-cp3\d+-linux_\w+\.whl", name)
    with zipfile.ZipFile(tmp_path / name) as wheel:
        names = set(wheel.namelist())
        installed = {f"drover/{path.relative_to(PACKAGE)}" for path in PACKAGE.rglob("*") if path.is_file()}
        assert names >= installed - {name for name in installed if name.endswith(".pyc")}
        assert {f"drover/{compiled.name}", "drover/server.html", "drover/figures/panels.py"} <= names
        information = next(one for one in names if one.endswith("/METADATA")).partition("/")[0]
        rows = {row[0]: row[1:] for row in csv.reader(io.StringIO(wheel.read(f"{information}/RECORD").decode()))}
        assert set(rows) == names
        for file, (digest, size) in rows.items():
            if not file.endswith("/RECORD"):
                content = wheel.read(file)
                expected = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
                assert (digest, int(size)) == (f"sha256={expected}", len(content)), file
        metadata = message_from_string(wheel.read(f"{information}/METADATA").decode())
    # Debian's h5py, whose HDF5 the module shares, has another name for pip: it would look for one elsewhere.
    assert metadata.get_all("Requires-Dist") == ["numpy", "xarray", "matplotlib"]
    assert (metadata["Name"], metadata["Version"]) == ("drover", backend.version())


def test_a_missing_compiler_is_a_sentence(backend, monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(SystemExit, match="cmake, ninja, g\\+\\+ not found.*\\.ci/setup"):
        backend.compile_module()
