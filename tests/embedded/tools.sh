#!/bin/sh
# What `make embedded` needs beside Python: a cross compiler with a C library, and the emulator. Installs them where it can.
set -eu
packages="gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm"
there() {
  command -v qemu-system-arm >/dev/null && command -v arm-none-eabi-gcc >/dev/null &&
    test -f "$(arm-none-eabi-gcc -print-file-name=rdimon.specs)"
}
if there; then
  exit 0
fi
echo "installing $packages" >&2
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
  # The lists of packages may be older than the packages.
  apt-get install -y -qq --no-install-recommends $packages >/dev/null 2>&1 ||
    { apt-get update -qq && apt-get install -y -qq --no-install-recommends $packages >/dev/null; } || true
fi
there || {
  echo "make embedded needs $packages (Debian's names). Install them as root: apt-get install $packages" >&2
  exit 1
}
