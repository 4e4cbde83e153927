#!/usr/bin/env bash
# surfit_slam --view on a screen of its own, with its keys, and without one:
#   view_test.sh FOLDER_OF_PROGRAMS SCREENSHOT
# Exits with 77 where what the screen takes is missing.
set -euo pipefail
programs=$1
screenshot=$2
for program in Xvfb xdotool import identify compare python3; do
  command -v "$program" >/dev/null || { echo "skipped: there is no $program"; exit 77; }
done

folder=$(mktemp -d)
started=()
clean_up() {
  ((${#started[@]})) && kill "${started[@]}" 2>/dev/null
  rm -r "$folder"
}
trap clean_up EXIT
fail() {
  echo "$1" >&2
  cat "$folder/err" >&2
  exit 1
}
wait_until() {  # wait_until WHAT COMMAND...: for 30 s at most
  for ((i = 0; i < 300; ++i)); do
    if "${@:2}" >/dev/null 2>&1; then return; fi
    sleep 0.1
  done
  fail "never: $1"
}
slam() {
  exec "$programs/surfit_slam" --sequence="$folder/room" --output="$folder/out" --nopictures --view \
    >"$folder/out.txt" 2>"$folder/err"
}
frames_done() { grep -c '^[0-9]' "$folder/out/frames.csv"; }
start() {
  rm -rf "$folder/out"
  (slam) &
  slam_pid=$!
  started+=("$slam_pid")
  wait_until "a window" xdotool search --onlyvisible --name '^Surfit$'
  window=$(xdotool search --onlyvisible --name '^Surfit$' 2>/dev/null | head -n 1)
}
press() { xdotool key --window "$window" "$1" 2>/dev/null; }
# From then on no frame is done.
press_pause() {
  press space
  wait_until "a pause" xdotool search --name '^Surfit \(paused\)$'
}
has_done() { [[ $(frames_done) == "$1" ]]; }

frames=400
"$programs/surfit_simulate" --output="$folder/room" --frames=$frames --downsample=4 >/dev/null 2>&1

# Without a display the run says so and goes on.
(unset DISPLAY WAYLAND_DISPLAY; slam) || fail "the run without a display failed"
grep -q "no live view: there is no display" "$folder/err" || fail "no word of the missing display"
[[ $(frames_done) == "$frames" ]] || fail "the run without a display is not whole"
digest=$(grep '"digest"' "$folder/out/summary.json")

# Without -noreset it starts anew when its last client leaves, and refuses who comes then.
Xvfb -noreset -displayfd 3 -screen 0 1280x1000x24 3>"$folder/display" 2>/dev/null &
started+=("$!")
wait_until "a display" grep -q "[0-9]" "$folder/display"
DISPLAY=:$(head -n 1 "$folder/display")
export DISPLAY

# A pause holds, a step is one frame, and the window shows a picture.
start
press_pause
paused_at=$(frames_done)
[[ $paused_at -lt $frames ]] || fail "the pause came too late to be one"
sleep 1
has_done "$paused_at" || fail "the pause at $paused_at did not hold: $(frames_done) frames are done"
press s
wait_until "a step" has_done $((paused_at + 1))
sleep 1
has_done $((paused_at + 1)) || fail "a step went from $paused_at to $(frames_done)"
import -window root "$screenshot"
colors=$(identify -format %k "$screenshot")
[[ $colors -gt 1000 ]] || fail "the window shows $colors colours"
# q ends the run, with its results.
press q
wait "$slam_pid" || fail "q made the run fail"
grep -q interrupted "$folder/out.txt" || fail "q did not end the run"
[[ -s $folder/out/map.ply ]] || fail "q left no map"

# At the end the window stays open, and the map in it can be turned.
start
wait_until "the end" xdotool search --name '^Surfit \(done\)$'
grep -q "$digest" "$folder/out/summary.json" || fail "looking on changed the result"
grep -q "frames, " "$folder/out.txt" || fail "the results were not told before the window closes"
sleep 1
import -window root "$folder/before.png"
xdotool mousemove --window "$window" 480 600 mousedown 1 mousemove_relative 100 0 \
  mousemove_relative 100 30 mouseup 1 2>/dev/null
sleep 2
import -window root "$screenshot"
differing=$(compare -metric AE "$folder/before.png" "$screenshot" null: 2>&1 || true)
[[ ${differing%%.*} -gt 10000 ]] || fail "turning the map changed $differing pixels"
press q
wait "$slam_pid" || fail "q at the end made the run fail"

# Closing the window does not stop the run.
start
press_pause
python3 "$(dirname "$0")/close_window.py" "$window"
wait "$slam_pid" || fail "closing the window made the run fail"
grep -q "the live view is closed" "$folder/err" || fail "no word of the closed window"
[[ $(frames_done) == "$frames" ]] || fail "the run ended with its window, after $(frames_done)"
[[ $(grep '"digest"' "$folder/out/summary.json") == "$digest" ]] || fail "looking on changed the result"
