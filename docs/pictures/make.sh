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
