#!/usr/bin/env bash
# Builds the Python package's wheel, installs it into a fresh environment and runs its tests there.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: python/tests/run.sh [BUILD_DIR] [ARGUMENT...]

Builds a wheel from this clone in BUILD_DIR (default: build/python), installs it into a fresh virtual environment there
and runs python/tests with pytest. ARGUMENTs go to pytest.

  PYTHON=python3            the interpreter to build for, 3.10 or newer
  SOFTCD_CUDA=auto|on|off   the CUDA backend; default: off
  SOFTCD_WHEELS=            a folder of wheels (packaging/wheels.sh): builds none, and tests the wheels that fit
  SOFTCD_BESIDE=            further packages to install and to import before and after softcd: scipy numba open3d torch mypy pyright.
                            With pybullet, of the version that softcd-pybullet is built for, that wheel is tested, too
  SOFTCD_PYBULLET_SOURCE=   PyBullet's sources: builds softcd-pybullet too, and tests it in that version's wheel

Exit code 77: the interpreter, its headers or venv are missing, or no package index can be reached.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=${1:-$root/build/python}
if [ $# -gt 0 ]; then shift; fi
cuda=${SOFTCD_CUDA:-off}
python=${PYTHON:-python3}

skip() {
  printf 'softcd: the Python package is not tested: %s\n' "$*" >&2
  exit 77
}

command -v "$python" >/dev/null || skip "there is no $python"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' || skip "$python is older than 3.10"
"$python" -c 'import os, sysconfig, sys; sys.exit(not os.path.exists(sysconfig.get_path("include") + "/Python.h"))' ||
  skip "$python has no headers; on Debian, install python3-dev"
mkdir -p "$build"
build=$(cd "$build" && pwd)
rm -rf "$build/venv" "$build/wheel"
"$python" -m venv "$build/venv" || skip "$python makes no virtual environment; on Debian, install python3-venv"
pip=("$build/venv/bin/python" -m pip --quiet --disable-pip-version-check)
# Packages that are installed beside bring plugins of pytest, which may not fit this pytest.
export PYTEST_DISABLE_PLUGIN_AUTOLOAD=1
read -ra beside <<<"${SOFTCD_BESIDE:-}"
"${pip[@]}" install pytest numpy ${beside[@]+"${beside[@]}"} || skip "pip cannot fetch pytest, numpy ${beside[*]}"

if [ -n "${SOFTCD_WHEELS:-}" ]; then
  wheels=(softcd)
  if [[ " ${beside[*]} " = *" pybullet "* ]]; then wheels+=(softcd-pybullet); fi
  "${pip[@]}" install --no-deps --no-index --find-links "$SOFTCD_WHEELS" "${wheels[@]}"
  cd "$root/python/tests"
  exec "$build/venv/bin/python" -m pytest -q -p no:cacheprovider "$@"
fi

# Debian 12's pip does not know the short form, -C. $1: the project's folder; more arguments for pip.
build_wheel() {
  "${pip[@]}" wheel "$1" --no-deps --wheel-dir "$build/wheel" --config-settings=cmake.define.SOFTCD_CUDA="${cuda^^}" "${@:2}"
}
build_wheel "$root" --config-settings=build-dir="$build/{wheel_tag}"
if [ -n "${SOFTCD_PYBULLET_SOURCE:-}" ]; then
  source=$(cd "$SOFTCD_PYBULLET_SOURCE" && pwd)
  build_wheel "$root/python/pybullet" --config-settings=build-dir="$build/pybullet" \
    --config-settings=cmake.define.SOFTCD_PYBULLET_SOURCE="$source"
fi
"${pip[@]}" install --only-binary :all: "$build"/wheel/softcd*.whl
cd "$root/python/tests"
exec "$build/venv/bin/python" -m pytest -q -p no:cacheprovider "$@"
