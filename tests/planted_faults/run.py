"""Plants faults.txt in a copy of the sources, builds it, and runs the tests against each fault: see planted_faults.sh."""

import argparse
import concurrent.futures
import functools
import json
import os
import pathlib
import queue
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
# With --proofs, the faults are those of the proofs, which have to fail for each.
PROOFS = "--proofs" in sys.argv
FAULTS = ROOT / ("tests/proofs/faults.txt" if PROOFS else "tests/planted_faults/faults.txt")
TARGET = "softcd_all_proofs" if PROOFS else "softcd_tests_of_change"
WORK = ROOT / "build" / ("planted_faults_of_proofs" if PROOFS else "planted_faults")
SOURCE = WORK / "source"
BUILD = WORK / "build"
RESULTS = WORK / "results.json"
HEADER = "kernels/include/softcd/planted_fault.hpp"
# The labels that the stages `proofs` and `tests` of .ci/run choose by.
CHOSEN = ["-L", "proof"] if PROOFS else ["-LE", "repetition|slow|gpu|proof"]
os.environ["SOFTCD_FEW_WORLDS"] = "1"  # as the stage `tests`
SHARES = queue.Queue()  # of the cores, one for each job: threads of two programs on one core would wait for each other
MEMORY = 8 << 30  # bytes of addresses that a test may have; a fault can make lists grow without end

# A constant expression has no fault. The variable is 0 until it is initialized.
HEADER_TEXT = """#pragma once

#include <cstdlib>

inline const int softcd_planted_fault = [] {
  const char* const number = std::getenv("SOFTCD_FAULT");
  return number == nullptr ? 0 : std::atoi(number);
}();

constexpr bool softcd_fault(int number) { return !__builtin_is_constant_evaluated() && softcd_planted_fault == number; }
"""


class Fault:
    """A block of faults.txt: its number, its file, what it breaks, and the text before and after."""

    def __init__(self, number, file, breaks):
        self.number, self.file, self.breaks = number, file, breaks
        self.original, self.replacement = [], []

    def __str__(self):
        return f"{self.number} {self.file}: {self.breaks}"

    def plant(self, text):
        """Returns `text` with this fault, which is chosen when the program runs."""
        original = "\n".join(self.original)
        before, part, after = ("", original, "") if "@" not in original else original.split("@")
        place = before + part + after
        if text.count(place) != 1:
            raise SystemExit(f"fault {self}: its text occurs {text.count(place)} times, not once:\n{place}")
        fault = f"softcd_fault({self.number})"
        replacement = "\n".join(self.replacement)
        if "FAULT" in replacement:
            planted = replacement.replace("FAULT", fault).replace("ORIGINAL", part)
        else:
            planted = f"({fault} ? ({replacement}) : ({part}))"
        return text.replace(place, before + planted + after)


def read_faults():
    faults = []
    for number, line in enumerate(FAULTS.read_text().splitlines(), 1):
        heading = re.fullmatch(r"(\d+) (\S+): (.+)", line)
        if heading:
            faults.append(Fault(int(heading[1]), heading[2], heading[3]))
        elif line.startswith("- "):
            faults[-1].original.append(line[2:])
        elif line.startswith("+ "):
            faults[-1].replacement.append(line[2:])
        elif line and not line.startswith("#"):
            raise SystemExit(f"{FAULTS}:{number}: not a fault's line: {line}")
    numbers = [fault.number for fault in faults]
    if len(set(numbers)) != len(numbers):
        raise SystemExit(f"{FAULTS}: a number occurs twice")
    return faults


def planted_files(faults):
    """Returns the changed files' texts by name, and fails where a fault's place is not found, or not the only one."""
    texts = {}
    for fault in faults:
        text = texts.get(fault.file) or (ROOT / fault.file).read_text()
        texts[fault.file] = fault.plant(text)
    for file, text in texts.items():
        include = '#include "softcd/planted_fault.hpp"\n'
        texts[file] = text.replace("#pragma once\n", "#pragma once\n" + include, 1) if file.endswith(".hpp") else include + text
    return {**texts, HEADER: HEADER_TEXT}


def copy_sources(planted):
    """Files whose content is the same keep their times, so that only what has changed is compiled again."""
    listed = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"], cwd=ROOT, check=True,
                            capture_output=True, text=True).stdout.split("\0")
    files = {name for name in listed if name and (ROOT / name).is_file()} | planted.keys()
    for name in files:
        content = planted[name].encode() if name in planted else (ROOT / name).read_bytes()
        target = SOURCE / name
        if not target.is_file() or target.read_bytes() != content:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)
            if name not in planted:
                shutil.copymode(ROOT / name, target)
    for target in SOURCE.rglob("*"):
        if target.is_file() and str(target.relative_to(SOURCE)) not in files:
            target.unlink()


def build():
    data = os.environ.get("SOFTCD_DATA_DIR", ROOT.parent / "shared/data")
    if not pathlib.Path(data).exists():
        data = ROOT / "build/data"
    flags = "-O1 -DNDEBUG -march=native -DHWY_COMPILE_ONLY_STATIC"
    subprocess.run(["cmake", "-S", SOURCE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    f"-DCMAKE_CXX_FLAGS_RELEASE={flags}", "-DCMAKE_UNITY_BUILD=ON", "-DSOFTCD_CUDA=OFF",
                    "-DSOFTCD_BENCHMARKS=OFF", "-DSOFTCD_BULLET_FLOAT64=OFF", "-DSOFTCD_INSTALL=OFF",
                    "-DSOFTCD_QUICK_PROGRAMS=ON", f"-DSOFTCD_DATA_DIR={data}"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", BUILD, "--parallel", os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", str(os.cpu_count())),
                    "--target", TARGET], check=True, stdout=sys.stderr)


class Program:
    def __init__(self, test):
        properties = {each["name"]: each["value"] for each in test.get("properties", [])}
        self.name, self.command = test["name"], test["command"]
        self.expected = properties.get("PASS_REGULAR_EXPRESSION")
        self.environment = dict(each.split("=", 1) for each in properties.get("ENVIRONMENT", []))
        self.seconds = 0.0  # without a fault, the last time
        self.limit = None  # once it was run without a fault
        self.lock = threading.Lock()

    def try_without_fault(self):
        """It has to pass. How long that takes limits how long it may take with a fault."""
        with self.lock:
            if self.limit is not None:
                return
            failure, self.seconds = self.run(0)
            if failure:
                sys.stderr.write(f"a test fails without a fault: {failure}\n")
                os._exit(2)
            self.limit = 60 + 10 * self.seconds

    def run(self, number):
        """Runs it with a fault, or none for 0. Returns None where it passes, else what failed, and its seconds."""
        cores = SHARES.get()
        begin = time.monotonic()
        with tempfile.TemporaryDirectory(dir=WORK) as folder, tempfile.TemporaryFile() as output:
            environment = {**os.environ, **self.environment, "SOFTCD_FAULT": str(number), "GTEST_FAIL_FAST": "1", "TMPDIR": folder}
            process = subprocess.Popen(self.command, cwd=folder, env=environment, stdout=output, stderr=subprocess.STDOUT,
                                       stdin=subprocess.DEVNULL, start_new_session=True,
                                       preexec_fn=functools.partial(limit, cores))
            try:
                code = process.wait(self.limit or 1800)
            except subprocess.TimeoutExpired:
                code = None
            try:  # what it has started, too
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
            process.wait()
            output.seek(0)
            text = output.read().decode(errors="replace")
        SHARES.put(cores)
        return self.judge(code, text), time.monotonic() - begin

    def judge(self, code, text):
        if code is not None and self.expected and code >= 0:
            code = 0 if any(re.search(each, text, re.DOTALL) for each in self.expected) else 1
        if code == 0:
            return None
        failed = re.findall(r"^\[  FAILED  \] (\S+?)[ ,]", text, re.MULTILINE)
        running = re.findall(r"^\[ RUN      \] (\S+)", text, re.MULTILINE)
        test = failed[0] if failed else running[-1] if running and code not in (0, 1) else ""
        how = " (takes too long)" if code is None else f" (signal {-code})" if code < 0 else ""
        return f"{self.name} {test}".strip() + how


def limit(cores):
    os.sched_setaffinity(0, cores)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def read_programs():
    shown = subprocess.run(["ctest", "--test-dir", BUILD, "-C", "programs", "-L", "program", *CHOSEN,
                            "--show-only=json-v1"], check=True, capture_output=True, text=True).stdout
    return [Program(test) for test in json.loads(shown)["tests"]]


def order(programs, caught_by):
    """The program that caught it last time, then the others, the shortest first: most faults fall to several."""
    return sorted(programs, key=lambda program: (program.name != caught_by, program.seconds))


def main():
    parser = argparse.ArgumentParser(usage="tests/planted_faults.sh --help")
    parser.add_argument("--proofs", action="store_true")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--programs", default="")
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args()
    faults = read_faults()
    planted = planted_files(faults)
    chosen = [fault for fault in faults if re.search(arguments.only, str(fault))]
    if not chosen:
        raise SystemExit("there is no such fault")
    if arguments.list:
        print(*chosen, sep="\n")
        return 0
    copy_sources(planted)
    build()
    programs = [program for program in read_programs() if re.search(arguments.programs, program.name)]
    known = json.loads(RESULTS.read_text()) if RESULTS.exists() else {"seconds": {}, "caught": {}}
    for program in programs:
        program.seconds = known["seconds"].get(program.name, 0.0)
    cores = sorted(os.sched_getaffinity(0))
    for job in range(arguments.jobs):
        SHARES.put(cores[job % len(cores) :: arguments.jobs])
    lock = threading.Lock()

    def try_new(program):
        program.try_without_fault()
        print(f"without a fault {program.name} passes in {program.seconds:.1f} s", flush=True)

    def attack(fault):
        failure, begin = None, time.monotonic()
        for program in order(programs, known["caught"].get(str(fault), "").split(" ")[0]):
            program.try_without_fault()
            failure, _ = program.run(fault.number)
            if failure:
                break
        with lock:
            print(f"{'caught  ' if failure else 'SURVIVED'} {fault}", failure or "", f"{time.monotonic() - begin:.0f} s",
                  sep="\n           ", flush=True)
            known["caught"][str(fault)] = failure or ""
            known["seconds"].update({program.name: program.seconds for program in programs})
            RESULTS.write_text(json.dumps(known, indent=1))
        return failure is None

    begin = time.monotonic()
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        list(pool.map(try_new, [program for program in programs if program.seconds == 0.0]))
        survived = [fault for fault, survives in zip(chosen, pool.map(attack, chosen)) if survives]
    print(f"\n{len(chosen) - len(survived)} of {len(chosen)} faults are caught, in {time.monotonic() - begin:.0f} s")
    for layer in ("kernels", "plugin", "bullet_integration"):
        of_layer = [fault for fault in chosen if fault.file.startswith(layer + "/")]
        print(f"  {layer}: {sum(fault not in survived for fault in of_layer)} of {len(of_layer)}")
    if survived:
        print("survived:", *survived, sep="\n  ")
    return 1 if survived else 0


sys.exit(main())
