#!/usr/bin/env bash
# Runs one task with other tools and with a program written by hand for this one mechanism; README.md describes the comparison.
#
#   run.sh yardstick          the crate and the program written by hand; needs g++ and cargo, no Python; under a minute once built
#   run.sh peers [FOLDER]     the Python packages, installed into a virtual environment in FOLDER (default: a temporary one)
#   run.sh robots [FOLDER]    two robots from URDF files with Crocoddyl, Pinocchio and MuJoCo; three minutes once built
#   run.sh four-bar [FOLDER]  a four-bar linkage with seven Python libraries; writes docs/comparison.md; fifteen minutes
#   run.sh optima [FOLDER]    optimal motions by `solve` and by IPOPT, from 20 starts each; half an hour
#   run.sh all [FOLDER]       the first three
#
# Prints Markdown. Everything runs on one thread.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
repository=$(cd "$here/../.." && pwd)
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1
export LC_ALL=C PYTHONDONTWRITEBYTECODE=1

rounds=${ROUNDS:-15}
packages=(numpy casadi jax crocoddyl)
robot_packages=(numpy pin==4.1.0 crocoddyl==3.2.1 mujoco==4.0.0 example-robot-data==5.0.0)
four_bar_packages=(numpy casadi==3.8.2 jax==0.10.2 diffrax==0.7.2 pin==4.1.0 mujoco==4.0.0 mujoco-mjx==3.17.0 exudyn==1.13.6 "$repository/python")
peers=(maximal_numpy maximal_casadi minimal_casadi maximal_jax minimal_jax minimal_crocoddyl)

main() {
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
    case "${1:-}" in
    yardstick) machine && yardstick ;;
    peers) machine && peers "${2:-$scratch}" ;;
    robots) machine && robots "${2:-$scratch}" ;;
    four-bar) four_bar "${2:-$scratch}" ;;
    optima) machine && optima "${2:-$scratch}" ;;
    all) machine && yardstick && peers "${2:-$scratch}" && robots "${2:-$scratch}" ;;
    *)
        sed -n '2,11s/^# \{0,1\}//p' "$0"
        return 2
        ;;
    esac
}

# Processor and load of the machine.
machine() {
    local model load
    model=$(sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo 2>/dev/null | head -n 1)
    load=$(cut -d ' ' -f 1 /proc/loadavg 2>/dev/null || true)
    echo "$(date -u +%Y-%m-%d), $(uname -s) $(uname -m), ${model:-unknown processor}, $(getconf _NPROCESSORS_ONLN) cores," \
        "load average at the start ${load:-unknown}"
}

# Alternates the programs, so that all run under the same load, and prints medians over the rounds. The crate is built with cargo's defaults, for
# processors with AVX2, and for this processor, like the program written by hand.
yardstick() {
    local k dt repeat round
    local target=${CARGO_TARGET_DIR:-$repository/target}
    RUSTFLAGS= build "$target"
    local wide=x86-64-v3
    grep -qw avx2 /proc/cpuinfo || wide=native
    RUSTFLAGS="-C target-cpu=$wide" build "$target/v3"
    RUSTFLAGS="-C target-cpu=native" build "$target/native"
    echo
    echo "$(g++ --version | head -n 1), $(rustc --version); medians of $rounds rounds, ms:"
    echo
    echo "| links | crate: simulation | with gradient | $wide | this processor | by hand | ratio | $wide | this processor | by hand, 1e-6 | ratio of the quickest runs | dJ/du differs by |"
    echo "|---|---|---|---|---|---|---|---|---|---|---|---|"
    for k in 3 10 30 100; do
        dt=0.01 && [ "$k" -gt 3 ] || dt=0.02
        repeat=$((1500 / k))
        g++ -O3 -march=native -fno-math-errno -fno-trapping-math -DK="$k" "$here/chain_floor.cpp" -o "$scratch/floor"
        : >"$scratch/rounds"
        for ((round = 0; round < rounds; round++)); do
            crate "$target" plain
            crate "$target/v3" v3
            crate "$target/native" native
            anew "$scratch/floor" 100 "$dt" 1e-9 0 >"$scratch/floor.txt" 2>"$scratch/floor9.log"
            anew "$scratch/floor" 100 "$dt" 1e-6 0 2>"$scratch/floor6.log" >/dev/null
            echo "$(seconds plain forward_s) $(seconds plain value_and_gradient_s) $(seconds v3 value_and_gradient_s)" \
                "$(seconds native value_and_gradient_s) $(floor_ms 9) $(floor_ms 6)" >>"$scratch/rounds"
        done
        row "$k"
    done
}

build() { cargo build --quiet --release --manifest-path "$repository/Cargo.toml" --target-dir "$1" --example cart_pendulum; }

# Runs a fresh copy of a program: the location of its pages in memory changes times by up to 9 % and is the same in all runs of one file.
anew() {
    local program=$1
    shift
    rm -f "$scratch/copy"
    cp "$program" "$scratch/copy"
    "$scratch/copy" "$@"
}

# Times the crate that was built into the given folder.
crate() { anew "$1/release/examples/cart_pendulum" --links "$k" --dt "$dt" --repeat "$repeat" >"$scratch/$2.json"; }

# A time of the crate, in ms.
seconds() { sed -n "s/.*\"$2\": \([^,]*\).*/\1/p" "$scratch/$1.json" | awk '{ print 1e3 * $1 }'; }

# Value and gradient by hand, in ms.
floor_ms() { sed -n 's/.*fwd+grad us med \([^ ]*\).*/\1/p' "$scratch/floor$1.log" | awk '{ print 1e-3 * $1 }'; }

# The median of the numbers on standard input.
median() { sort -g | awk '{ x[NR] = $1 } END { print x[int((NR + 1) / 2)] }'; }

# One line of the table from all rounds.
row() {
    local column medians=()
    for column in '$1' '$2' '$3' '$4' '$5' '$2 / $5' '$3 / $5' '$4 / $5' '$6'; do
        medians+=("$(awk "{ print $column }" "$scratch/rounds" | median)")
    done
    printf '| %s | %.3f | %.3f | %.3f | %.3f | %.4f | **%.2f** | **%.2f** | **%.2f** | %.4f | %.2f | %.0e |\n' "$1" "${medians[@]}" "$(quickest)" "$(difference)"
}

# The ratio of the shortest times, which other programs on the machine disturb least.
quickest() {
    awk '{ if (NR == 1 || $2 < ours) ours = $2; if (NR == 1 || $5 < hand) hand = $5 } END { print ours / hand }' "$scratch/rounds"
}

# The largest difference of the two gradients, relative to the largest entry.
difference() {
    sed -n 's/.*"gradient": \[\(.*\)\].*/\1/p' "$scratch/plain.json" | tr ',' '\n' >"$scratch/crate.txt"
    tail -n +2 "$scratch/floor.txt" | paste "$scratch/crate.txt" - | awk '
        { d = $1 - $2; d = d < 0 ? -d : d; a = $2 < 0 ? -$2 : $2; if (d > worst) worst = d; if (a > size) size = a }
        END { print worst / size }'
}

# Installs packages into FOLDER/venv; one that fails is reported and does not end the script.
install() {
    local folder=$1 package
    shift
    mkdir -p "$folder"
    [ -x "$folder/venv/bin/python" ] || python3 -m venv "$folder/venv"
    python=$folder/venv/bin/python
    for package in "$@"; do
        "$python" -m pip install --quiet --disable-pip-version-check "$package" 2>"$scratch/pip.log" >&2 ||
            echo "$package could not be installed: $(tail -n 1 "$scratch/pip.log")" >&2
    done
    echo
}

# A failed peer becomes a line of the table and does not end the script.
peers() {
    local peer python
    install "$1" "${packages[@]}"
    "$python" "$here/common.py"
    echo
    echo "| tool | unknowns, scheme | value, ms | value + gradient, ms | error of J | error of dJ/du | remarks |"
    echo "|---|---|---|---|---|---|---|"
    for peer in "${peers[@]}"; do
        if ! (cd "$scratch" && "$python" "$here/$peer.py" 2>"$scratch/peer.log"); then
            echo "| $peer | | | | | | failed: $(tail -n 1 "$scratch/peer.log" | tr '|' '/') |"
        fi
    done
}

robots() {
    local python target=${CARGO_TARGET_DIR:-$repository/target}
    cargo build --quiet --release --manifest-path "$repository/Cargo.toml" --target-dir "$target" -p urdf --example robot
    install "$1" "${robot_packages[@]}"
    PYTHONPATH=$here "$python" "$here/robots/table.py" "$target/release/examples/robot" "${ROUNDS:-5}"
}

optima() {
    local python target=${CARGO_TARGET_DIR:-$repository/target}
    cargo build --quiet --release --manifest-path "$repository/Cargo.toml" --target-dir "$target" -p paper-repro
    install "$1" numpy casadi==3.8.2
    "$python" "$here/optima.py" "$target/release/paper-repro" "${STARTS:-20}"
}

# Builds this package, too.
four_bar() {
    local python
    install "$1" "${four_bar_packages[@]}"
    "$python" "$here/four_bar/page.py"
}

main "$@"
