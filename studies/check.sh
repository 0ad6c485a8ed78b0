#!/usr/bin/env bash
# Runs a study with 4 processes, kills one of them, resumes the study, and compares it with that of a single process. Needs Open MPI (Debian: libopenmpi-dev,
# openmpi-bin, libclang-dev).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
starts=${1:-200}
cargo build --release --locked
program=${CARGO_TARGET_DIR:-target}/release/studies
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
ranks() { OMP_NUM_THREADS=1 mpirun --allow-run-as-root --oversubscribe -n "$@"; }
lines() { if [ -f "$1" ]; then wc -l <"$1"; else echo 0; fi; }

echo "-- 4 ranks, the last of which is killed"
ranks 4 "$program" "$folder/four" "$starts" >/dev/null 2>&1 &
run=$!
until [ "$(lines "$folder/four")" -gt 5 ]; do sleep 0.05; done
pkill -KILL -n -f "$program $folder/four" || true
wait "$run" && { echo "error: the run was not lost" >&2; exit 1; }
echo "$(($(lines "$folder/four") - 1)) outcomes were kept"
# Simulates a machine that stopped while a line was being written.
printf '{"start":3,"x":[0.1' >>"$folder/four"

echo "-- again"
ranks 4 "$program" "$folder/four" "$starts"
echo "-- one rank"
ranks 1 "$program" "$folder/one" "$starts"
[ "$(sort "$folder/four")" = "$(sort "$folder/one")" ] || { echo "error: other outcomes" >&2; exit 1; }
echo "the same outcomes to the last bit"
for n in 2 3 4; do ranks "$n" "$program" "$folder/of-$n" "$starts"; done
