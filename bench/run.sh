#!/usr/bin/env bash
# Speed and accuracy beside the peers, in one run: installs them into bench/.venv, builds, measures, writes
# results.
#   bench/run.sh          everything (about ten minutes on two idle cores)
#   bench/run.sh --quick  fewer repetitions and shorter records, to see that it works
#   bench/run.sh --rich-families  that section alone, printed
#   bench/run.sh --joint-fits     those of joint fits alone, printed
set -euo pipefail
cd "$(dirname "$0")/.."

die() { echo "error: $1" >&2; echo "  try: $2" >&2; exit 1; }
command -v cargo >/dev/null || die "cargo is not installed" "install a Rust toolchain, see https://rustup.rs"
command -v python3 >/dev/null \
  || die "python3 is not installed" "your system's package, e.g. 'apt-get install python3 python3-venv'"

venv=bench/.venv
if [ ! -x "$venv/bin/python" ]; then
  python3 -m venv "$venv" || die "python3 cannot make a virtual environment" "apt-get install python3-venv"
fi
if ! cmp -s bench/requirements.txt "$venv/installed.txt"; then
  "$venv/bin/python" -m pip install --quiet --disable-pip-version-check -r bench/requirements.txt \
    || die "the peers (numpy, scipy, numba) could not be installed" \
    "check the network, or Python 3.11 to 3.14"
  cp bench/requirements.txt "$venv/installed.txt"
fi

cargo build --release --locked -p hysteron-bench -p hysteron-cli
exec "$venv/bin/python" bench/bench.py "$@"
