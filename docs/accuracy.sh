#!/bin/sh
# Renews all that is measured in docs/accuracy.md and README.md, and what --target-error knows:
#
#     docs/accuracy.sh SHARED [FOLDER]
#
# SHARED holds the maps, scenes and known light (see tests/support); FOLDER keeps the sweeps, which go on
# where they were as long as the program is the same (default: target/accuracy). Names of other scenes and
# maps can be given in SCENES, MAPS, DEMO (swept, the last without known light), ASKED_SCENES and ASKED_MAPS
# (lit for an error).
set -eu
shared=$1
root=$(cd "$(dirname "$0")/.." && pwd)
folder=${2:-$root/target/accuracy}
scenes=${SCENES:-wedge5 tinylight_box cornell_small slit_rooms}
maps=${MAPS:-start lqdm2 lqdm1}
demo=${DEMO:-atrium effects_all}
asked_scenes=${ASKED_SCENES:-$(cd "$shared/scenes/truth" && ls ./*.csv | sed 's|^./||; s|\.csv$||' |
    grep -v -e cornell_8000 -e _shift -e _x1e)}
asked_maps=${ASKED_MAPS:-start lqdm1 lqdm2 lq_e0m1_nodirt}
mkdir -p "$folder"

# Sweeps are by a copy of the program, since what they find goes into the program.
sources=$(cd "$root" && find Cargo.lock src -type f ! -name 'measured*.csv' -exec sha256sum {} + |
    sort | sha256sum)
(cd "$root" && cargo build --release --bin qrad)
if test "$sources" != "$(cat "$folder/sources" 2>/dev/null)"; then
    cp "$root/target/release/qrad" "$folder/qrad"
    echo "$sources" >"$folder/sources"
fi

# A map with known light has its name, and the options that its truth was made with, behind it.
lit_map() {
    map=$1
    shift
    set -- "$@" --set minlight=0 --bounces all --truth "$shared/reference/bounce/$map.csv"
    case $map in *_nodirt) set -- "$@" --set _dirt=0 ;; esac
    "$program" "$shared/maps/librequake/${map%_nodirt}.bsp" "$@"
}
lit_scene() {
    scene=$1
    shift
    "$program" --patches "$shared/scenes/$scene.txt" "$@" --truth "$shared/scenes/truth/$scene.csv"
}

program=$folder/qrad
for scene in $scenes; do lit_scene "$scene" --sweep "$folder/sweeps/$scene"; done
for map in $maps; do lit_map "$map" --sweep "$folder/sweeps/$map"; done
for map in $demo; do "$program" "$root/maps/$map.bsp" --sweep "$folder/sweeps/$map"; done
python3 "$root/docs/accuracy.py" known "$folder" "$root"

(cd "$root" && cargo build --release --bin qrad)
program=$root/target/release/qrad
for error in 1 0.2 0.1; do
    for scene in $asked_scenes; do
        lit_scene "$scene" -q --sweep "$folder/asked/$scene-$error" --target-error "$error%"
    done
done
for error in 5 2 1; do
    for map in $asked_maps; do
        lit_map "$map" -q --sweep "$folder/asked/$map-$error" --target-error "$error%"
    done
done
for name in $scenes $maps; do
    cp "$folder/sweeps/$name/error-seconds.svg" "$root/docs/pictures/accuracy-$name.svg"
done
python3 "$root/docs/accuracy.py" tables "$folder" "$root"
