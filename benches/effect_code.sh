#!/bin/sh
# What the code of effects costs a map without them, in instructions (times are too noisy for 1 %):
#
#     benches/effect_code.sh [MAP...]
#
# builds qrad as it is and with the feature `without-effects`, which leaves the branches of effects out of
# the hot loops, lights each map (default: maps/effects_none.bsp) with both on one thread, and compares the
# instructions that valgrind counts and what was written.
set -eu
cd "$(dirname "$0")/.."
out=target/effect_code
mkdir -p "$out"
cargo build --release --bin qrad --features without-effects
cp target/release/qrad "$out/without"
cargo build --release --bin qrad
cp target/release/qrad "$out/with"

# Instructions that a build executes to light a map.
count() {
    RAYON_NUM_THREADS=1 valgrind --tool=cachegrind --cache-sim=no --cachegrind-out-file=/dev/null \
        "$out/$1" "$2" --quiet --no-check --output "$out/$1.bsp" 2>&1 |
        sed -n 's/.*I *refs: *//p' | tr -d ,
}

for map in "${@:-maps/effects_none.bsp}"; do
    with=$(count with "$map")
    without=$(count without "$map")
    cmp "$out/with.bsp" "$out/without.bsp"
    echo "$map $with $without" | awk '{
        printf "%s: %.0f instructions, %.0f without the code of effects: %+.3f %%\n",
            $1, $2, $3, 100 * ($2 / $3 - 1)
    }'
done
