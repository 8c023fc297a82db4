#!/usr/bin/env python3
"""Writes what a release's files contain of others, with versions and licences: a bill of materials in CycloneDX's JSON."""

import argparse
import hashlib
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]

# Libraries that are compiled into files: name, licence (SPDX), and the Debian package, or a file of it, that has the version.
ONETBB = ("oneTBB", "Apache-2.0", "libtbb-dev")
FMT = ("fmt", "MIT", "libfmt-dev")
HIGHWAY = ("Highway", "Apache-2.0", "libhwy-dev")
BOOST = ("Boost", "BSL-1.0", "/usr/include/boost/version.hpp")
CLI11 = ("CLI11", "BSD-3-Clause", "libcli11-dev")
JSON = ("nlohmann_json", "MIT", "nlohmann-json3-dev")
EIGEN = ("Eigen", "MPL-2.0", "libeigen3-dev")
IMGUI = ("Dear ImGui", "MIT", "libimgui-dev")
LIBSTDCXX = ("libstdc++", "GPL-3.0-or-later WITH GCC-exception-3.1", "libstdc++-{compiler}-dev")

# Files of a release by pattern, and what each contains beside softcd. Debian's packages use shared libraries.
CONTENTS = {
    r"softcd-.*\.whl": [ONETBB, FMT, HIGHWAY, BOOST, CLI11, JSON, LIBSTDCXX],
    r"softcd_pybullet-.*\.whl": [ONETBB, FMT, HIGHWAY, LIBSTDCXX],
    r"softcd-tools_.*\.deb": [CLI11, JSON, BOOST, EIGEN, IMGUI],
    r"libsoftcd.*\.deb": [],
    r".*\.tar\.gz": [],
    r".*\.abi\.xz": [],
}


def component(kind, name, version, licence, **more):
    return {"type": kind, "name": name, "version": version, "licenses": [{"expression": licence}], **more}


def output_of(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def of_debian(name, licence, package):
    """Describes a library whose sources or headers are the installed Debian package's."""
    package = package.format(compiler=output_of("c++", "-dumpversion").split(".")[0].strip())
    if package.startswith("/"):
        package = output_of("dpkg-query", "--search", package).split(":")[0]
    shown = output_of("dpkg-query", "--show", "--showformat", "${source:Package} ${source:Version}\n", package)
    source, version = shown.splitlines()[0].split()
    upstream = re.sub(r"^\d+:|[+-](ds|dfsg|really).*|-[^-]*$", "", version)
    purl = f"pkg:deb/debian/{source}@{version.replace(':', '%3A')}?arch=source"
    return component("library", name, upstream, licence, purl=purl)


def of_wheel(name, has_cuda, options):
    """Describes what a wheel has of others that are no Debian packages."""
    if name.startswith("softcd-"):
        version = options.nanobind
        yield component("library", "nanobind", version, "BSD-3-Clause", purl=f"pkg:pypi/nanobind@{version}")
    else:
        version = options.pybullet
        yield component("library", "Bullet", version, "Zlib", purl=f"pkg:pypi/pybullet@{version}")
    if has_cuda:
        licence = [{"license": {"name": "CUDA Toolkit End User License Agreement"}}]
        yield {"type": "library", "name": "CUDA runtime", "version": options.cuda, "licenses": licence}


def describe(file, version, options):
    content = file.read_bytes()
    found = [parts for pattern, parts in CONTENTS.items() if re.fullmatch(pattern, file.name)]
    if len(found) != 1:
        sys.exit(f"softcd: packaging/sbom.py does not know what {file.name} contains: add it to CONTENTS")
    parts = [of_debian(*part) for part in found[0]]
    if file.suffix == ".whl":
        parts += of_wheel(file.name, options.cuda != "none", options)
    hashes = [{"alg": "SHA-256", "content": hashlib.sha256(content).hexdigest()}]
    return component("file", file.name, version, "Zlib", hashes=hashes, components=parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path, help="the release's files")
    parser.add_argument("--cuda", default="none", help="version of the CUDA runtime in the wheels; none: without it")
    parser.add_argument("--nanobind", required=True, help="version of nanobind in the wheels")
    parser.add_argument("--pybullet", required=True, help="version of PyBullet whose Bullet softcd-pybullet has")
    options = parser.parse_args()
    header = (ROOT / "kernels/include/softcd/version.hpp").read_text()
    version = re.search(r'SOFTCD_VERSION_STRING "(.*)"', header)[1]
    document = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": component("library", "softcd", version, "Zlib")},
        "components": [describe(file, version, options) for file in sorted(options.folder.iterdir())],
    }
    print(json.dumps(document, indent=2))


if __name__ == "__main__":
    main()
