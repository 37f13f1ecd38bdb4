#!/usr/bin/env bash
# Makes every picture of the README with qrad itself: docs/pictures/make.sh
set -euo pipefail
cd "$(dirname "$0")/../.."

cargo build --release
build="${CARGO_TARGET_DIR:-target}/release"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

# pair NAME CAMERA: a place in the atrium with direct light only and with bounced light.
pair() {
    "$build/qrad" --quiet maps/atrium.bsp -o "$scratch/atrium.bsp" --bounces 0 \
        --preview "docs/pictures/$1-direct.png" --camera "$2" --preview-size 480x360
    "$build/qrad" --quiet maps/atrium.bsp -o "$scratch/atrium.bsp" \
        --preview "docs/pictures/$1-bounced.png" --camera "$2" --preview-size 480x360
}

pair corridor -728,-340,60,0,90
pair guardroom -160,-816,110,18,115

"$build/qrad" --quiet --patches maps/cornell/cornell.txt -o "$scratch/cornell-lit.txt"
"$build/draw_patches" "$scratch/cornell-lit.txt" --exposure 50 --size 360x360 \
    -o docs/pictures/cornell.png

# Light that comes through: docs/effects.md.
effect() {
    "$build/qrad" --quiet --patches "maps/cornell/$1.txt" -o "$scratch/$1-lit.txt"
    "$build/draw_patches" "$scratch/$1-lit.txt" --exposure "$2" -o "docs/pictures/$1.png"
}
effect stained_glass 220
effect lantern 40
effect curtain 60
cp maps/through.bsp maps/through.materials.toml "$scratch/"
through() {
    "$build/qrad" --quiet "$scratch/through.bsp" \
        --preview "docs/pictures/through-$1.png" --camera "$2" --preview-size 480x360
}
through glass 100,-60,50,8,150
through lantern 30,-40,70,5,45
through curtain 60,-60,60,5,10
