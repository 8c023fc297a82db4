"""Checks the types of the pages' examples and of python/examples, where mypy or pyright is installed."""

import importlib.util
import os
import re
import subprocess
import sys

import pytest

from test_documentation import ROOT, examples

COMMANDS = {"mypy": ["--ignore-missing-imports"], "pyright": ["--pythonpath", sys.executable]}


def is_runnable(program):
    """Returns whether all packages that a program imports are installed, so that checkers find them."""
    packages = set(re.findall(r"^(?:import|from) (\w+)", program.read_text(), re.MULTILINE))
    return all(importlib.util.find_spec(package) for package in packages if not (program.parent / f"{package}.py").exists())


@pytest.mark.parametrize("checker", COMMANDS)
def test_examples_have_the_right_types(checker, tmp_path):
    if importlib.util.find_spec(checker) is None:
        pytest.skip(f"there is no {checker}")
    programs = [program for program in sorted((ROOT / "python" / "examples").glob("*.py")) if is_runnable(program)]
    assert len(programs) >= 2
    for i, example in enumerate(examples()):
        if any(package in example.values[0] for package in ("torch", "jax", "plot(")):
            continue
        programs.append(tmp_path / f"example_{i}.py")
        programs[-1].write_text(example.values[0])
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import softcd\nsoftcd.BatchScene(3).set_positions(vertices=0)\n")
    command = [sys.executable, "-m", checker, *COMMANDS[checker]]
    place = {"cwd": ROOT / "python" / "examples", "env": {**os.environ, "MYPY_CACHE_DIR": str(tmp_path)}}
    run = subprocess.run([*command, *programs], **place, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout
    run = subprocess.run([*command, wrong], **place, capture_output=True, text=True)
    assert run.returncode == 1 and "vertices" in run.stdout, "the stubs are read"
