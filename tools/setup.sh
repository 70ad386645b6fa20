#!/usr/bin/env bash
# Installs with apt what vildar needs on Debian 12. Does nothing where everything is there already.
#   tools/setup.sh        what building and running needs
#   tools/setup.sh test   that, and what the tests need
set -euo pipefail

build_packages=(
  g++ cmake ninja-build pkg-config ccache
  libeigen3-dev libceres-dev libyaml-cpp-dev nlohmann-json3-dev libcli11-dev libhwy-dev
  libavformat-dev libavcodec-dev libavutil-dev libswscale-dev libsndfile1-dev nettle-dev
  libopencv-core-dev libopencv-imgproc-dev
)
test_packages=(libgtest-dev librapidcheck-dev libbenchmark-dev libopencv-calib3d-dev python3 git ca-certificates)

wanted=("${build_packages[@]}")
if [[ "${1:-}" == test ]]; then wanted+=("${test_packages[@]}"); fi

missing=()
for package in "${wanted[@]}"; do
  status=$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ "$status" == installed ]] || missing+=("$package")
done
if ((${#missing[@]} == 0)); then exit 0; fi

echo "installing: ${missing[*]}" >&2
as_root=()
if [[ $(id -u) != 0 ]]; then
  command -v sudo >/dev/null || {
    echo "tools/setup.sh: these packages are missing and need root to install: ${missing[*]}" >&2
    echo "run as root:  apt-get update && apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 1
  }
  as_root=(sudo)
fi
# One unreachable list of many makes this fail; the packages may be there all the same.
"${as_root[@]}" apt-get -qq update || echo "tools/setup.sh: apt-get update failed, going on with the lists there are" >&2
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get -qq install -y --no-install-recommends "${missing[@]}" >/dev/null
