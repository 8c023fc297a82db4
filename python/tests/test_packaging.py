import importlib.metadata
import importlib.util
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

import import_order
import softcd

FOLDER = pathlib.Path(softcd.__file__).parent
HEADER = pathlib.Path(__file__).resolve().parents[2] / "kernels" / "include" / "softcd" / "version.hpp"


def test_the_version_is_the_headers():
    version = re.search(r'SOFTCD_VERSION_STRING "(.*)"', HEADER.read_text())[1]
    assert softcd.__version__ == version == importlib.metadata.version("softcd")


def test_annotations_are_installed():
    assert (FOLDER / "py.typed").exists()
    stub = (FOLDER / "_core.pyi").read_text()
    assert "class Scene:" in stub and "def set_positions(self, body: int, vertices_t0" in stub
    assert "def wait(self) -> numpy.typing.NDArray[numpy.void] | Any" in stub
    assert "class BatchScene:" in stub and "def detect(self, pairs: Pairs | str = ...) -> softcd.BatchContacts | Any" in stub
    assert "backend: Backend | str = ..." in stub and "import Backend" not in stub


@pytest.mark.skipif(shutil.which("nm") is None, reason="there is no nm")
def test_the_modules_export_no_name_but_their_entry():
    plugin = importlib.util.find_spec("softcd_pybullet")
    folders = [FOLDER, *([pathlib.Path(plugin.origin).parent] if plugin else [])]
    for module in (file for folder in folders for file in folder.glob("*.so")):
        if module.name.startswith("lib"):
            continue
        listed = subprocess.run(["nm", "-D", "--defined-only", module], capture_output=True, check=True, text=True)
        names = [line.split()[-1] for line in listed.stdout.splitlines()]
        entries = r"PyInit__core" if module.name.startswith("_core") else r"\w*Plugin\w*_softcd"
        assert names and all(re.fullmatch(entries, name) for name in names), module.name


@pytest.mark.parametrize("order", ["first", "second"])
@pytest.mark.parametrize("package", ["numba", "open3d", "scipy", "torch"])
def test_contacts_are_the_same_beside_other_packages(package, order):
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"there is no {package}")
    program = pathlib.Path(import_order.__file__)
    command = [sys.executable, program.name, package, order]
    run = subprocess.run(command, cwd=program.parent, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert run.stdout.split() == [import_order.detect()]


def test_everything_public_is_there():
    assert all(hasattr(softcd, name) for name in softcd.__all__)
    names = {name for name in vars(softcd) if not name.startswith("_")}
    assert names <= {*softcd.__all__, "bullet", "torch"}  # these two only where they have been imported


def test_licences_of_what_is_bundled_are_installed():
    texts = [file for file in importlib.metadata.files("softcd") if "licenses" in file.parts]
    packages = {file.parent.name for file in texts}
    bundled = {file.name.split(".")[0] for file in FOLDER.glob("lib*.so*")}
    for name in ["nanobind", *bundled]:
        assert any(package.startswith(name) for package in packages), name
    assert any(file.match("licenses/LICENSE") for file in texts)  # softcd's own
    # CUDA's repeats those of others.
    joined = "\n".join(file.read_text() for file in texts if file.parent.name != "cuda")
    for words in ("provided 'as-is'", "Wenzel Jakob", "Victor Zverovich", "Google LLC", "Apache License", "Niels Lohmann",
                  "University of Cincinnati", "Boost Software License"):
        assert words in joined
