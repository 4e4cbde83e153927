#!/usr/bin/env bash
# Installs with apt what this Debian 12 lacks, and with npm, where there is one, what reports do
# without otherwise:
#   install_dependencies.sh            all that building, running and testing Surfit needs
#   install_dependencies.sh programs   what building and running the programs needs
#   install_dependencies.sh cluster    what the test of scans on Slurm needs besides (label cluster)
#   install_dependencies.sh arm        what compiling for ARM needs besides, whose libraries are
#                                      unpacked into build/arm-system
# Needs no root, and does nothing, when nothing is missing.
set -euo pipefail
group=${1:-all}
[[ $group =~ ^(all|programs|cluster|arm)$ ]] || { echo "error: '$group' is none of all, programs, cluster, arm" >&2; exit 1; }

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
npm_packages() {  # npm_packages FOLDER PACKAGE WHAT_LACKS_WITHOUT: what FOLDER/package-lock.json names
  [[ ! -e $1/node_modules/$2 ]] && command -v npm >/dev/null || return 0
  # Without peers: Chart.js is Debian's.
  npm ci --prefix "$1" --legacy-peer-deps --ignore-scripts --no-audit --no-fund </dev/null ||
    echo "warning: npm failed, so $3" >&2
}
[[ $group =~ ^(cluster|arm)$ ]] ||
  npm_packages "$root/src/browser/npm" chartjs-plugin-zoom "the plots of reports will not zoom"
[[ $group != all ]] ||
  npm_packages "$root/tests/tools/bags" @mcap/core "no test writes MCAP files"

packages=(
  # compiler and build tools
  g++ make cmake ninja-build ccache pkg-config
  # the libraries and the programs
  libeigen3-dev libceres-dev libgoogle-glog-dev libgflags-dev libopencv-dev libtbb-dev
  nlohmann-json3-dev libboost-dev
  libturbojpeg0-dev libpng-dev libtiff-dev libdeflate-dev liblzf-dev libmeshoptimizer-dev
  liblz4-dev libzstd-dev libbz2-dev libsqlite3-dev
  libopenni2-dev
  # what reports hold
  libjs-three libjs-chart.js
  # CMake looks for these at once
  libgtest-dev libgmock-dev
)
test_packages=(
  # format and clang-tidy of what changed
  git clang-format clang-tidy
  # documentation, manual pages and Debian packages
  doxygen help2man dpkg-dev
  # the Python module
  python3-dev pybind11-dev python3-numpy python3-matplotlib python3-pip python3-venv mypy
  # the tests
  libbenchmark-dev zlib1g-dev python3-pytest
  zsh valgrind
  python3-rosbag python3-sensor-msgs lz4 zstd
  chromium chromium-driver python3-selenium python3-pil
  snakemake
)
[[ $group != all ]] || packages+=("${test_packages[@]}")
[[ $group != cluster ]] || packages=(snakemake slurm-wlm munge)
arm_packages=(libblas-dev liblapack-dev)
for package in "${packages[@]}"; do
  [[ ! $package =~ ^lib|^nlohmann ]] || arm_packages+=("$package")
done
[[ $group != arm ]] || packages=(g++-aarch64-linux-gnu qemu-user mmdebstrap)

if ! command -v dpkg-query apt-get >/dev/null; then
  echo "error: no dpkg-query and apt-get here; install what third_party_notes.md lists by hand" >&2
  exit 1
fi

unpack_for_arm() {
  local system=$root/build/arm-system
  [[ $group == arm && ! -d $system ]] || return 0
  mkdir -p "$root/build"
  rm -rf "$system.part"
  mmdebstrap --variant=extract --architectures=arm64 --include="${arm_packages[*]}" \
    "$(. /etc/os-release && echo "$VERSION_CODENAME")" "$system.part"
  # What installing does besides: Debian's alternatives, and Ceres' files name libraries by path.
  local libraries=usr/lib/aarch64-linux-gnu
  for name in blas lapack; do
    ln -s "$name/lib$name.so" "$name/lib$name.so.3" "$system.part/$libraries"
  done
  sed -i "s|/$libraries/|$system&|g" "$system.part/$libraries/cmake/Ceres/CeresTargets.cmake"
  mv "$system.part" "$system"
}

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $status == installed ]] || missing+=("$package")
done
[[ ${#missing[@]} -gt 0 ]] || { unpack_for_arm; exit 0; }

if [[ $(id -u) == 0 ]]; then
  as_root=(env)
elif command -v sudo >/dev/null; then
  as_root=(sudo env)
else
  echo "error: Debian packages are missing, and this is neither root nor is there sudo;" >&2
  echo "have an administrator run: apt-get install --no-install-recommends ${missing[*]}" >&2
  exit 1
fi

apt() {
  "${as_root[@]}" DEBIAN_FRONTEND=noninteractive \
    apt-get -o Acquire::Retries=3 -o DPkg::Lock::Timeout=300 "$@" </dev/null
}
echo "Installing ${missing[*]}"
apt update -q || echo "warning: apt-get update failed, trying with the lists at hand" >&2
apt install -q -y --no-install-recommends "${missing[@]}"
unpack_for_arm
