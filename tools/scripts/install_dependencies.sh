#!/usr/bin/env bash
# Installs missing packages: Debian 12 packages with apt, and JavaScript packages for optional parts of
# reports with npm, if it is available:
#   install_dependencies.sh            all packages for building, running and testing Surfit
#   install_dependencies.sh programs   packages for building and running the programs
#   install_dependencies.sh cluster    additional packages for the test of scans on Slurm (label cluster)
#   install_dependencies.sh arm        additional packages for compiling for ARM; its libraries are
#                                      unpacked into build/arm-system
# If no package is missing, the script does nothing and needs no root.
set -euo pipefail
group=${1:-all}
[[ $group =~ ^(all|programs|cluster|arm)$ ]] || { echo "error: group is '$group', must be all, programs, cluster or arm" >&2; exit 1; }

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
npm_packages() {  # npm_packages FOLDER PACKAGE CONSEQUENCE: installs the packages of FOLDER/package-lock.json
  [[ ! -e $1/node_modules/$2 ]] && command -v npm >/dev/null || return 0
  # Without peer dependencies: Chart.js is a Debian package.
  npm ci --prefix "$1" --legacy-peer-deps --ignore-scripts --no-audit --no-fund </dev/null ||
    echo "warning: npm failed: $3" >&2
}
[[ $group =~ ^(cluster|arm)$ ]] ||
  npm_packages "$root/src/browser/npm" chartjs-plugin-zoom "plots in reports cannot be zoomed"
[[ $group != all ]] ||
  npm_packages "$root/tests/tools/bags" @mcap/core "tests cannot write MCAP files"

packages=(
  # compiler and build tools
  g++ make cmake ninja-build ccache pkg-config
  # the libraries and the programs
  libeigen3-dev libceres-dev libgoogle-glog-dev libgflags-dev libopencv-dev libtbb-dev
  nlohmann-json3-dev libboost-dev
  libturbojpeg0-dev libpng-dev libtiff-dev libdeflate-dev liblzf-dev libmeshoptimizer-dev
  liblz4-dev libzstd-dev libbz2-dev libsqlite3-dev
  libopenni2-dev
  # JavaScript libraries of reports
  libjs-three libjs-chart.js
  # required by CMake
  libgtest-dev libgmock-dev
)
test_packages=(
  # format and clang-tidy of changed files
  git clang-format clang-tidy
  # documentation, manual pages and Debian packages
  doxygen help2man dpkg-dev file
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
  echo "error: dpkg-query or apt-get is missing: install the packages of third_party_notes.md manually" >&2
  exit 1
fi

unpack_for_arm() {
  local system=$root/build/arm-system
  [[ $group == arm && ! -d $system ]] || return 0
  mkdir -p "$root/build"
  rm -rf "$system.part"
  mmdebstrap --variant=extract --architectures=arm64 --include="${arm_packages[*]}" \
    "$(. /etc/os-release && echo "$VERSION_CODENAME")" "$system.part"
  # Other steps of an installation: the alternatives for BLAS and LAPACK, and the library paths of
  # Ceres.
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
  echo "error: Debian packages are missing, and their installation requires root or sudo:" >&2
  echo "run as administrator: apt-get install --no-install-recommends ${missing[*]}" >&2
  exit 1
fi

apt() {
  "${as_root[@]}" DEBIAN_FRONTEND=noninteractive \
    apt-get -o Acquire::Retries=3 -o DPkg::Lock::Timeout=300 "$@" </dev/null
}
echo "Installing ${missing[*]}"
apt update -q || echo "warning: apt-get update failed, using the existing package lists" >&2
apt install -q -y --no-install-recommends "${missing[@]}"
unpack_for_arm
