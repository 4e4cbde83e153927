#!/usr/bin/env bash
# Uses Surfit on a clean Debian, in a root of its own:
#   debian_root.sh [--suite=SUITE] [ROOT]             clones this repository, runs demo.sh and test.sh
#                                                     there, and makes the Debian packages
#   debian_root.sh [--suite=SUITE] --packages=BUILD [ROOT]
#                                                     installs the packages of a build, and uses them
# SUITE: release of Debian. Default: bookworm.
# BUILD: build folder of the preset `package` on that release, after `cpack`.
# ROOT: folder of a Debian root. If it is empty, debootstrap creates the root with the apt sources of
# this machine. Default: a temporary folder that is removed at the end.
# DEMO_ONLY=1 in the environment: without test.sh and packages, which take over an hour on two cores.
# Needs root permissions, and a few minutes for downloads.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
suite=bookworm
debs=()
while [[ ${1:-} == --* ]]; do
  case $1 in
    --suite=*) suite=${1#*=} ;;
    --packages=*)
      debs=("${1#*=}"/*.deb)
      [[ -e ${debs[0]} ]] || { echo "error: no packages in ${1#*=}: run cpack there" >&2; exit 1; }
      ;;
    *) echo "error: unknown option $1" >&2; exit 1 ;;
  esac
  shift
done
[[ $(id -u) == 0 ]] || { echo "error: chroot needs root" >&2; exit 1; }

root=${1:-$(mktemp -d)}
clean_up() {
  umount -l "$root/proc" "$root/dev" 2>/dev/null || true
  (($# >= 1)) || rm -rf --one-file-system "$root"
}
trap 'clean_up "$@"' EXIT

mirror_of() {  # mirror_of CODENAME: address of the apt source of this machine
  apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' "Codename: $1" | head -n 1
}
if [[ ! -e $root/etc/debian_version ]]; then
  debootstrap --variant=minbase "$suite" "$root" "$(mirror_of bookworm)"
fi
if [[ $suite == bookworm ]]; then
  rm -rf "$root/etc/apt/sources.list"
  cp -a /etc/apt/. "$root/etc/apt/"
else
  security=$(mirror_of bookworm-security)
  {
    echo "deb $(mirror_of bookworm) $suite main"
    echo "deb $(mirror_of bookworm) $suite-updates main"
    [[ -z $security ]] || echo "deb $security $suite-security main"
  } >"$root/etc/apt/sources.list"
fi
[[ ! -e /etc/resolv.conf ]] || cp -L /etc/resolv.conf "$root/etc/resolv.conf"

# Scripts and tests need /proc and /dev.
mount -t proc proc "$root/proc"
mount --rbind --make-rslave /dev "$root/dev"

inside() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
  DEBIAN_FRONTEND=noninteractive "$@"; }

if ((${#debs[@]} == 0)); then
  inside apt-get update -q
  inside apt-get install -q -y --no-install-recommends ca-certificates git
  rm -rf "$root/checkout"
  git clone --quiet --no-hardlinks "$here/../.." "$root/checkout"
  inside bash /checkout/tools/scripts/demo.sh
  [[ -s $root/checkout/out/demo/map_color.png && -s $root/checkout/out/demo/report.html ]]
  if [[ ${DEMO_ONLY:-} != 1 ]]; then
    inside bash /checkout/tools/scripts/test.sh
    inside bash -c 'cd /checkout && cmake --preset package && cmake --build --preset package -j2 &&
      cd build/package && cpack'
  fi
  echo "The commands of the README work on Debian $(<"$root/etc/debian_version") ($suite)"
  exit 0
fi

mkdir -p "$root/packages" "$root/consumer"
rm -rf "$root"/{packages,consumer}/* "$root"/{room,out}
cp "${debs[@]}" "$root/packages/"
cp "$here"/{CMakeLists.txt,main.cc,own_residual.cc,registration.cc} "$root/consumer/"

inside apt-get update -q
install() { inside bash -c "apt-get install -q -y --no-install-recommends $1"; }
install "--reinstall /packages/*.deb"

echo "Programs"
inside surfit_simulate --output=/room --frames=12 --downsample=4
inside surfit_slam --sequence=/room --output=/out --report
[[ -s $root/out/map_color.png ]]

echo "No toolkit"
if inside dpkg --list | grep -i "libqt\|highgui"; then exit 1; fi

echo "Report"
report=$root/out/report.html
[[ $(stat --format=%s "$report") -lt 30000000 ]]
grep --quiet 'class="run"' "$report"
# The page forbids network access and has no external references.
grep --quiet "Content-Security-Policy\" content=\"default-src 'none'" "$report"
if grep -E --only-matching '(src|href)=["'\''](https?:)?//[^"'\'']*|url\(["'\'']?https?:|@import' "$report"; then
  echo "error: $report refers to the network" >&2
  exit 1
fi

echo "Manual pages"
install man-db
for program in "$root"/usr/bin/surfit_*; do
  name=$(basename "$program")
  [[ -z $(inside man --warnings --local-file "/usr/share/man/man1/$name.1.gz" 2>&1 >/dev/null) ]]
  inside man "$name" | grep "EXIT STATUS" >/dev/null
done

echo "Python"
inside python3 - <<'END'
import json, surfit
slam = surfit.Slam()
for frame in surfit.Sequence("/room"):
    slam.process(frame)
assert slam.digest == json.load(open("/out/summary.json"))["digest"]
END

echo "Development files"
install "g++ make cmake pkg-config"
inside bash -c 'cmake -S /consumer -B /consumer/build && cmake --build /consumer/build &&
  /consumer/build/consumer && /consumer/build/own_residual && /consumer/build/registration &&
  g++ -std=c++17 /consumer/main.cc -o /consumer/by_pkg_config $(pkg-config --cflags --libs surfit) &&
  /consumer/by_pkg_config'
echo "All packages work on a clean Debian $(<"$root/etc/debian_version") ($suite)"
