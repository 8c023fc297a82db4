#!/usr/bin/env bash
# Installs what building softcd needs and this machine lacks (Debian 12, Ubuntu 24.04 and later).
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: cmake/setup.sh [--only] [EXTRA_PACKAGE...]

Installs the packages that building softcd needs, and EXTRA_PACKAGEs, with apt-get, as root or with sudo. Does nothing if
all are there.

  --only           installs EXTRA_PACKAGEs alone
  SOFTCD_CUDA=on   if there is no nvcc, also fetches NVIDIA's CUDA compiler (100 MB) into build/nvcc
  SOFTCD_SETUP=off installs nothing: install the packages yourself
TEXT
}

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

packages=(
  cmake ninja-build g++ pkg-config
  libtbb-dev libhwy-dev libbullet-dev libeigen3-dev
  libcli11-dev libfmt-dev nlohmann-json3-dev libpng-dev libssl-dev
  libglfw3-dev libimgui-dev libepoxy-dev libegl-dev libgl1-mesa-dri
  libgtest-dev libgmock-dev libboost-dev libgmp-dev libbenchmark-dev libassimp-dev
)

say() { printf 'softcd setup: %s\n' "$*" >&2; }

is_installed() { [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

install_packages() {
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    say "this is neither Debian nor Ubuntu, so nothing is installed; softcd needs what they call: $*"
    return
  fi
  local missing=() package
  for package in "$@"; do is_installed "$package" || missing+=("$package"); done
  [ ${#missing[@]} -gt 0 ] || return 0

  local as_root=()
  if [ "$(id -u)" != 0 ]; then
    if ! command -v sudo >/dev/null; then
      say "these packages are missing: ${missing[*]}"
      say "installing them needs root; as root, run: apt-get install ${missing[*]}"
      exit 1
    fi
    as_root=(sudo)
  fi
  say "installing ${missing[*]}"
  # Others, such as unattended-upgrades, may be installing: apt-get waits for them only when it is told to.
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300)
  "${apt[@]}" update || say "the package lists could not be brought up to date; trying with the old ones"
  if ! "${apt[@]}" install -y --no-install-recommends "${missing[@]}" >/dev/null; then
    say "apt-get could not install ${missing[*]}; its messages above say why"
    exit 1
  fi
}

has_nvcc() {
  [ -n "${CUDACXX:-}" ] || command -v nvcc >/dev/null || [ -x /usr/local/cuda/bin/nvcc ] ||
    [ -x "$root/build/nvcc/nvidia/cu13/bin/nvcc" ]
}

# The compiler and the headers and libraries it needs, without the rest of the toolkit. The packages do not pin each
# other, and lack two links that CMake's detection follows.
fetch_nvcc() {
  install_packages python3 python3-pip
  local target=$root/build/nvcc fresh=$root/build/nvcc.part
  say "fetching NVIDIA's CUDA compiler into $target"
  rm -rf "$fresh"
  if ! python3 -m pip install --quiet --disable-pip-version-check --root-user-action=ignore --target "$fresh" \
    nvidia-cuda-nvcc==13.0.88 nvidia-cuda-crt==13.0.88 nvidia-nvvm==13.0.88 nvidia-cuda-runtime==13.0.96 \
    nvidia-cuda-cccl==13.0.85 nvidia-nvtx==13.0.85; then
    say "the CUDA compiler could not be fetched; install a CUDA toolkit (12 or later), or use SOFTCD_CUDA=off"
    exit 1
  fi
  ln -sfn lib "$fresh/nvidia/cu13/lib64"
  ln -sfn libcudart.so.13 "$fresh/nvidia/cu13/lib/libcudart.so"
  rm -rf "$target"
  mv "$fresh" "$target"
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
[ "${SOFTCD_SETUP:-on}" != off ] || exit 0

if [ "${1:-}" = --only ]; then
  shift
  install_packages "$@"
  exit 0
fi
install_packages "${packages[@]}" "$@"
if [ "${SOFTCD_CUDA:-auto}" = on ] && ! has_nvcc; then fetch_nvcc; fi
