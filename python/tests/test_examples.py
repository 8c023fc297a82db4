"""Runs python/examples, where the packages that they use are installed."""

import pathlib
import re
import runpy

import pytest

EXAMPLES = pathlib.Path(__file__).resolve().parents[1] / "examples"


def run(name, capsys, *packages):
    """Runs an example and returns what it has printed."""
    for package in packages:
        pytest.importorskip(package)
    runpy.run_path(str(EXAMPLES / name), run_name="__main__")
    return capsys.readouterr().out


def test_a_cloth_drapes_over_a_sphere_without_crossings(capsys):
    torch = pytest.importorskip("torch")
    code = (EXAMPLES / "drape.py").read_text().replace("ITERATIONS, SIDE, RADIUS = 150,", "ITERATIONS, SIDE, RADIUS = 25,")
    thread_count, dtype = torch.get_num_threads(), torch.get_default_dtype()
    try:
        exec(compile(code, "drape.py", "exec"), {})
    finally:
        torch.set_num_threads(thread_count)
        torch.set_default_dtype(dtype)
    text = capsys.readouterr().out
    figures = re.fullmatch(r"25 iterations, .* 0 crossings, smallest gap (0\.\d+), lowest point (-?0\.\d+)\n", text)
    assert figures, text
    assert 0 < float(figures[1]) < 0.02 and float(figures[2]) < 0.2


def test_cloths_are_lowered_without_crossings(capsys):
    text = run("batch_lowering.py", capsys)
    figures = re.fullmatch(r"64 cloths, (\d+) contacts .*, (\d+) crossings, middles (\S+) to (\S+) above .*\n", text)
    assert figures, text
    assert int(figures[1]) > 64 and int(figures[2]) == 0
    assert 0 < float(figures[3]) <= float(figures[4]) < 0.05


def counts(text, name):
    """Returns a row's counts of every audit in a text."""
    return [[int(word) for word in row.split()] for row in re.findall(rf"^  {name}((?: +\d+)+)", text, re.MULTILINE)]


def test_a_float32_test_with_few_samples_misses_contacts(capsys):
    text = run("audit_float32.py", capsys)
    missed, confirmed = counts(text, "missed"), counts(text, "confirmed")
    assert missed[0] > missed[1] > missed[2] == [0]
    assert len({m[0] + c[0] for m, c in zip(missed, confirmed)}) == 1 and confirmed[2] > [200]


def test_ipc_toolkit_misses_nothing(capsys):
    text = run("audit_ipc_toolkit.py", capsys, "ipctk")
    assert counts(text, "missed") == [[0, 0]] * 2 and counts(text, "confirmed")[0] == counts(text, "confirmed")[1]
    assert counts(text, "invented")[0] == [0, 0] and min(counts(text, "invented")[1]) > 0


@pytest.mark.filterwarnings("ignore")
def test_warp_misses_nothing(capsys):
    text = run("audit_warp.py", capsys, "warp")
    assert counts(text, "missed") == counts(text, "invented") == [[0]] * 2 and min(counts(text, "confirmed")) > [1000]


@pytest.mark.filterwarnings("ignore")
def test_newton_misses_nothing(capsys):
    text = run("audit_newton.py", capsys, "newton")
    assert counts(text, "missed") == counts(text, "invented") == [[0, 0]] * 2
    assert min(min(row) for row in counts(text, "confirmed")) > 1000
