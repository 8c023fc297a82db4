"""Tests Ctrl-C while the library works."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import softcd
from meshes import PIERCING_T0, PIERCING_T1, PIERCING_TRIANGLES

COINCIDENT = 200000  # triangles; each patch of eight is compared with all others
LONG = np.tile(np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), (COINCIDENT, 1))
LONG_TRIANGLES = np.arange(3 * COINCIDENT).reshape(-1, 3) % 3  # of the same vertices, hence without contacts


@pytest.fixture(autouse=True)
def _listens_to_ctrl_c():
    """Undoes what shells do to programs in the background, which ignore Ctrl-C."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def long_scene():
    scene = softcd.Scene(backend="cpu", max_threads=1)
    body = scene.add_body(LONG_TRIANGLES, 3, self_collision=True)
    scene.set_positions(body, LONG[:3], LONG[:3])
    return scene, body


def interrupted_after(seconds, call):
    """Returns the seconds from Ctrl-C to the exception in the caller."""
    sent = []

    def interrupt():
        time.sleep(seconds)
        sent.append(time.monotonic())
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        call()
    received = time.monotonic()
    thread.join()
    return received - sent[0]


@pytest.mark.parametrize("call", [softcd.Query.detect, lambda query: query.start().wait()])
def test_a_long_detection_is_interrupted_at_once(call):
    scene, body = long_scene()
    query = softcd.Query(scene)
    begin = time.monotonic()
    assert interrupted_after(0.2, lambda: call(query)) < 0.5
    interrupted = time.monotonic() - begin
    scene.remove_body(body)  # waits for the work
    assert time.monotonic() - begin > interrupted
    other = scene.add_body(PIERCING_TRIANGLES, 6, self_collision=True)
    scene.set_positions(other, PIERCING_T0, PIERCING_T1)
    query.options = softcd.QueryOptions(detection="ccd")
    assert len(query.detect()) == 1, "the scene can still be used"


def test_a_call_that_waits_for_interrupted_work_is_interrupted():
    scene, _ = long_scene()
    query = softcd.Query(scene)
    interrupted_after(0.2, query.detect)
    assert interrupted_after(0.1, lambda: [scene.has_body(0) for _ in range(10**7)]) < 0.5


def test_a_signal_that_raises_nothing_changes_nothing():
    scene, _ = long_scene()
    caught = []
    before = signal.signal(signal.SIGALRM, lambda *_: caught.append(time.monotonic()))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        assert len(softcd.Query(scene).detect()) == 0
    finally:
        signal.signal(signal.SIGALRM, before)
    assert len(caught) == 1


def test_a_program_that_is_interrupted_ends_in_order():
    program = (
        "import _thread, signal, threading, test_interrupts as t, softcd\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "scene, _ = t.long_scene()\n"
        "query = softcd.Query(scene)\n"
        "query.set_pair_filter(lambda a, b: True)\n"
        "threading.Timer(0.2, _thread.interrupt_main).start()\n"
        "query.detect()\n"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert "KeyboardInterrupt" in ended.stderr and ended.returncode in (1, -signal.SIGINT, 130), ended
