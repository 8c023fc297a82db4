"""Tests calls that run out of memory: the same bytes, or a MemoryError and an unchanged scene. No crash, no leak."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

import softcd

FOLDER = pathlib.Path(__file__).resolve().parent


def has_its_own_operator_new():
    """Whether libstdc++ is in the module, as in published wheels: then a preloaded operator new is not called."""
    return b"libstdc++.so" not in pathlib.Path(softcd._core.__file__).read_bytes()


@pytest.mark.skipif(has_its_own_operator_new(), reason="the module's allocations cannot be made to fail")
def test_each_allocation_of_each_call_may_fail(tmp_path):
    compiler = os.environ.get("CXX") or shutil.which("c++")
    if compiler is None:
        pytest.skip("there is no C++ compiler for the library that lets allocations fail")
    library = tmp_path / "libfailing.so"
    source = FOLDER / "failing_allocations.cpp"
    subprocess.run([compiler, "-std=c++17", "-O1", "-shared", "-fPIC", source, "-o", library], check=True)
    run = subprocess.run(
        [sys.executable, FOLDER / "failed_calls.py", library],
        env={**os.environ, "LD_PRELOAD": str(library)},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    failures, calls = map(int, re.search(r"(\d+) failures in (\d+) calls", run.stdout).groups())
    assert failures > 500 and calls > 25, run.stdout
