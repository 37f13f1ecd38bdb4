#!/bin/sh
# Renews the sweeps and the figures of docs/accuracy.md and README.md:
#
#     docs/accuracy.sh SHARED [FOLDER]
#
# SHARED holds the maps, scenes and known light (see tests/support); FOLDER keeps the sweeps, which go on
# where they were (default: target/accuracy). Prints the tables of the document.
set -eu
shared=$1
root=$(dirname "$0")/..
folder=${2:-$root/target/accuracy}
qrad=$root/target/release/qrad
(cd "$root" && cargo build --release --bin qrad)
mkdir -p "$folder"
for scene in cornell_small tinylight_box wedge5 slit_rooms; do
    "$qrad" --patches "$shared/scenes/$scene.txt" --sweep "$folder/$scene" \
        --truth "$shared/scenes/truth/$scene.csv"
done
for map in start lqdm2 lqdm1; do
    "$qrad" "$shared/maps/librequake/$map.bsp" --set minlight=0 --bounces all \
        --sweep "$folder/$map" --truth "$shared/reference/bounce/$map.csv"
done
for name in cornell_small slit_rooms start lqdm2 lqdm1; do
    test ! -f "$folder/$name/error-seconds.svg" ||
        cp "$folder/$name/error-seconds.svg" "$root/docs/pictures/accuracy-$name.svg"
done
python3 "$root/docs/accuracy.py" "$folder"
