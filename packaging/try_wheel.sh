#!/usr/bin/env bash
# Tries the Python package's wheels on a bare distribution, which has no compiler and no library of theirs.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/try_wheel.sh FOLDER SUITE

Makes a bare distribution (SUITE: bookworm, trixie or noble; packaging/bare.sh) in build/bare/wheel-SUITE, unless it
exists, with Python and without a compiler. Installs the wheel in FOLDER that fits its Python, with a numpy that is
fetched outside of it. Runs packaging/wheel_sample.py, and compares the output with packaging/wheel_sample.txt. If PyPI has
a wheel of PyBullet for that Python, also installs softcd-pybullet and runs the first example of docs/use/pybullet.md. As
root, with the right to mount.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
if [ $# -ne 2 ]; then usage >&2 && exit 2; fi

# This runs in the bare distribution.
case $1 in
  --prepare)
    if ! python3 -c 'import ensurepip' 2>/dev/null; then
      apt-get -qq update
      DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends python3-venv >/dev/null
    fi
    for program in cc c++ gcc g++ clang nvcc cmake; do
      if command -v "$program" >/dev/null; then echo "this is no bare distribution: it has $program" >&2 && exit 1; fi
    done
    python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])' >/python_version
    exit
    ;;
  --install)
    rm -rf /venv
    python3 -m venv /venv
    time /venv/bin/python -m pip --quiet --disable-pip-version-check install --no-index --find-links "$2" softcd
    /venv/bin/python packaging/wheel_sample.py >/found.txt
    diff packaging/wheel_sample.txt /found.txt
    /venv/bin/softcd-detect --help >/dev/null
    /venv/bin/python -c 'import numpy, softcd, sys; print(softcd.__file__, numpy.__version__, sys.version)'
    if compgen -G "$2/pybullet-*.whl" >/dev/null; then
      time /venv/bin/python -m pip --quiet --disable-pip-version-check install --no-index --find-links "$2" softcd-pybullet
      # shellcheck disable=SC2016  # the page's own backticks
      sed -n '/^```python$/,/^```$/{//!p; /^```$/q}' docs/use/pybullet.md >/example.py
      /venv/bin/python /example.py
    fi
    exit
    ;;
esac

folder=$(cd "$1" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export SOFTCD_BARE=wheel-$2
bare=build/bare/$SOFTCD_BARE
packaging/bare.sh "$2" packaging/try_wheel.sh --prepare python3
rm -rf "$bare/wheels"
cp -r "$folder" "$bare/wheels"
# Fetches the wheel of the package $1.
fetch() {
  python3 -m pip --quiet --disable-pip-version-check download "$1" --dest "$bare/wheels" --no-deps --only-binary :all: \
    --python-version "$(<"$bare/python_version")" --platform "manylinux_2_28_$(uname -m)" --platform "manylinux_2_17_$(uname -m)"
}
fetch numpy
fetch pybullet 2>/dev/null || echo "PyPI has no wheel of PyBullet for Python $(<"$bare/python_version")"
packaging/bare.sh "$2" packaging/try_wheel.sh --install /wheels
