"""Checks the types of the package, the pages' examples and python/examples, where mypy or pyright is installed."""

import importlib.util
import os
import pathlib
import re
import subprocess
import sys

import pytest

import softcd
from test_documentation import ROOT, examples

COMMANDS = {"mypy": ["--ignore-missing-imports"], "pyright": ["--pythonpath", sys.executable]}


def is_runnable(program):
    """Returns whether all packages that a file imports are installed, so that checkers find them."""
    packages = set(re.findall(r"^(?:import|from) (\w+)", program.read_text(), re.MULTILINE))
    return all(importlib.util.find_spec(package) for package in packages if not (program.parent / f"{package}.py").exists())


def check(checker, files, tmp_path):
    if importlib.util.find_spec(checker) is None:
        pytest.skip(f"there is no {checker}")
    place = {"cwd": ROOT / "python" / "examples", "env": {**os.environ, "MYPY_CACHE_DIR": str(tmp_path)}}
    return subprocess.run([sys.executable, "-m", checker, *COMMANDS[checker], *files], **place, capture_output=True, text=True)


@pytest.mark.parametrize("checker", COMMANDS)
def test_the_package_has_the_right_types(checker, tmp_path):
    modules = sorted(pathlib.Path(softcd.__file__).parent.glob("*.py"))
    lacking = {f"{package}.py" for package in ("torch", "jax") if importlib.util.find_spec(package) is None}
    if importlib.util.find_spec("pybullet") is None:
        lacking |= {module.name for module in modules if "bullet" in module.name}
    files = [module for module in modules if module.name not in lacking]
    assert len(files) >= 8
    if checker == "mypy":  # which takes installed packages by name alone
        files = [option for module in files for option in ("-m", f"softcd.{module.stem}".removesuffix(".__init__"))]
    run = check(checker, files, tmp_path)
    assert run.returncode == 0, run.stdout


@pytest.mark.parametrize("checker", COMMANDS)
def test_examples_have_the_right_types(checker, tmp_path):
    programs = [program for program in sorted((ROOT / "python" / "examples").glob("*.py")) if is_runnable(program)]
    assert len(programs) >= 2
    for i, example in enumerate(examples()):
        if any(package in example.values[0] for package in ("torch", "jax", "plot(")):
            continue
        programs.append(tmp_path / f"example_{i}.py")
        programs[-1].write_text(example.values[0])
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import softcd\nsoftcd.BatchScene(3).set_positions(vertices=0)\n")
    run = check(checker, programs, tmp_path)
    assert run.returncode == 0, run.stdout
    run = check(checker, [wrong], tmp_path)
    assert run.returncode == 1 and "vertices" in run.stdout, "the stubs are read"
