#!/usr/bin/env bash
# Instructions per step for the value and the gradient of ready-made examples, counted by Valgrind's callgrind: independent of the load of the machine.
#
#   instructions.sh           prints the counts beside those recorded in instructions.txt
#   instructions.sh check     also fails if a count exceeds the recorded one by more than 1 %
#   instructions.sh record    records the counts
#
# Counts depend on the compiler; those of another compiler are printed but not compared. PROGRAMS names a folder of examples that are already built.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
repository=$(cd "$here/.." && pwd)
mode=${1:-print}
recorded=$here/instructions.txt
steps=100
compiler=$(rustc --version)

command -v valgrind >/dev/null || { echo "error: valgrind is not installed (Debian: valgrind)" >&2; exit 2; }
programs=${PROGRAMS:-${CARGO_TARGET_DIR:-$repository/target}/release/examples}
[ -n "${PROGRAMS:-}" ] || cargo build --quiet --locked --release --manifest-path "$repository/Cargo.toml" --example cart_pendulum --example arm --example robot_arm

# Total instructions of a program with the given number of repetitions.
total() {
    local repeat=$1
    shift
    valgrind --tool=callgrind --callgrind-out-file=/dev/null "$@" --steps "$steps" --repeat "$repeat" 2>&1 >/dev/null |
        sed -n 's/.*Collected : \([0-9]*\).*/\1/p'
}

# Instructions per step, from the difference of five repetitions.
count() { echo $((($(total 8 "$@") - $(total 3 "$@")) / (5 * steps))); }

failed=0
fresh="# instructions per step of value and gradient: workload, count; benches/instructions.sh record
# $compiler, $(uname -m)"
compared=0
grep -qxF "# $compiler, $(uname -m)" "$recorded" 2>/dev/null && compared=1
[ "$compared" = 1 ] || echo "recorded with another compiler or for another processor: counts are not compared"

# Counts one workload and compares it with the recorded count.
row() {
    local name=$1 now before note=
    shift
    now=$(count "$@")
    before=$(awk -v name="$name" '$1 == name { print $2 }' "$recorded" 2>/dev/null || true)
    if [ "$compared" = 1 ] && [ -n "$before" ] && [ $((now * 100)) -gt $((before * 101)) ]; then
        note="  MORE by $(awk -v now="$now" -v before="$before" 'BEGIN { printf "%.1f", 100 * (now / before - 1) }') %"
        failed=1
    fi
    printf '%-10s %8d   recorded %8s%s\n' "$name" "$now" "${before:-none}" "$note"
    fresh+=$'\n'"$name $now"
}

row cart-3 "$programs/cart_pendulum" --links 3 --dt 0.02
row cart-10 "$programs/cart_pendulum" --links 10 --dt 0.01
row cart-30 "$programs/cart_pendulum" --links 30 --dt 0.01
row arm "$programs/arm"
row robot-arm "$programs/robot_arm"

case $mode in
record) printf '%s\n' "$fresh" >"$recorded" ;;
check) exit "$failed" ;;
esac
