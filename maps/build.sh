#!/bin/bash
# build.sh - demo.wad, .map files, then unlit BSPs (qbsp + vis), all in this folder.
# Usage: ./build.sh [map...]     needs qbsp and vis of ericw-tools 2.0 in $ERICW
set -eu
cd "$(dirname "$0")"
ERICW=${ERICW:?set ERICW to the folder that holds qbsp and vis}
export LD_LIBRARY_PATH="$ERICW${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
THREADS=${THREADS:-2}
MAPS=${*:-cornell atrium atrium_bsp2 furnace furnace_inner slit styles effects_none effects_all}

build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
[ -f demo.wad ] && [ ! make_wad.py -nt demo.wad ] || python3 make_wad.py demo.wad > "$build/wad.txt"
cp demo.wad "$build/"

fail=0
for name in $MAPS; do
    src=${name%_bsp2}
    python3 make_maps.py . "$src"
    opts="-tjunc rotate"
    [ "$src" != "$name" ] && opts="$opts -bsp2 -litwater 0"      # classic unlit liquids in this one
    cp "$src.map" "$build/$name.map"
    ( cd "$build"
      "$ERICW/qbsp" -nopercent -noprogress -noallowupgrade -threads "$THREADS" $opts "$name.map" > "$name.qbsp.txt" 2>&1 ) ||
        { echo "$name: qbsp FAILED"; tail "$build/$name.qbsp.txt"; fail=1; continue; }
    if grep -qiE "leak|WARNING.*(missing|not found|No entities)" "$build/$name.qbsp.txt" || [ -f "$build/$name.pts" ] || [ ! -f "$build/$name.prt" ]; then
        echo "$name: LEAK or warning"; grep -iE "leak|WARNING" "$build/$name.qbsp.txt" || true; fail=1
    fi
    ( cd "$build"; "$ERICW/vis" -nopercent -noprogress -threads "$THREADS" "$name.bsp" > "$name.vis.txt" 2>&1 ) ||
        { echo "$name: vis FAILED"; tail "$build/$name.vis.txt"; fail=1; }
    cp "$build/$name.bsp" .
    # qbsp keeps _phong, _shadow etc. of func_detail/func_group in this side file
    [ -f "$build/$name.texinfo.json" ] && cp "$build/$name.texinfo.json" .
done
exit $fail
