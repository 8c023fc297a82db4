#!/usr/bin/env bash
# Tries softcd on a bare distribution.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/bare.sh SUITE [COMMAND...]

Makes a bare distribution (debootstrap; Debian's bookworm and trixie, Ubuntu's noble) in build/bare/SUITE, unless it
exists. Copies this clone's files into its /softcd, and runs COMMAND there (default: cmake/build.sh). The packages and
files that COMMAND adds stay for the next one. As root, with the right to mount. Ubuntu's is made in the bare Debian 13,
because Debian 12's debootstrap knows neither it nor its keys.

  packaging/bare.sh trixie tests/run.sh              README's tests on Debian 13
  packaging/bare.sh trixie packaging/debian.sh --try
  packaging/bare.sh bookworm packaging/aarch64.sh    compiled for aarch64, and run by an emulator

Environment: SOFTCD_BARE=NAME puts it into build/bare/NAME; SOFTCD_CUDA, SOFTCD_CMAKE_ARGS: see cmake/build.sh --help.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
  '') usage >&2 && exit 2 ;;
esac
suite=$1
shift
command=("$@")
if [ ${#command[@]} -eq 0 ]; then command=(cmake/build.sh); fi

cd "$(dirname "${BASH_SOURCE[0]}")/.."
bare=$PWD/build/bare/${SOFTCD_BARE:-$suite}

make_debian() {
  SOFTCD_SETUP=on cmake/setup.sh --only debootstrap
  debootstrap --force-check-gpg --variant=minbase --include=ca-certificates "$suite" "$bare.part" >&2
}

make_ubuntu() {
  # shellcheck disable=SC2016  # the inner shell expands it
  SOFTCD_BARE=trixie packaging/bare.sh trixie bash -c '
    set -euo pipefail
    apt-get -qq update
    DEBIAN_FRONTEND=noninteractive apt-get -qq install -y --no-install-recommends debootstrap ubuntu-keyring >/dev/null
    rm -rf /ubuntu
    debootstrap --force-check-gpg --variant=minbase --components=main,universe --include=ca-certificates "$1" /ubuntu >&2
  ' bash "$suite"
  mv build/bare/trixie/ubuntu "$bare.part"
}

# A folder that is not finished is not taken for one that is.
if [ ! -d "$bare" ]; then
  rm -rf "$bare.part"
  mkdir -p build/bare
  if [ "$suite" = noble ]; then make_ubuntu; else make_debian; fi
  mv "$bare.part" "$bare"
fi

mkdir -p "$bare/softcd"
git ls-files --cached --others --exclude-standard -z | tar --null --files-from=- --ignore-failed-read -cf - |
  tar -xf - -C "$bare/softcd"
cp /etc/resolv.conf "$bare/etc/resolv.conf"
# A mount namespace of its own: what is mounted in it goes with it.
# shellcheck disable=SC2016  # the inner shell expands them
exec unshare --mount bash -c '
  set -euo pipefail
  bare=$1 && shift
  mount --bind /proc "$bare/proc"
  mount --rbind /dev "$bare/dev"
  exec chroot "$bare" /usr/bin/env -i HOME=/root TERM=dumb LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin \
    SOFTCD_CUDA="${SOFTCD_CUDA:-off}" SOFTCD_CMAKE_ARGS="${SOFTCD_CMAKE_ARGS:-}" \
    bash -c "cd /softcd && exec \"\$@\"" bash "$@"
' bash "$bare" "${command[@]}"
