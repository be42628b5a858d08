#!/usr/bin/env bash
# Proves at link time that hysteron-rt needs no std and cannot panic, f32 and f64, every n; and that the
# proof can fail.
set -euo pipefail
cd "$(dirname "$0")"
command -v cargo >/dev/null || { echo "no_std proof: cargo not found; install a Rust toolchain" >&2; exit 1; }
command -v cc >/dev/null || { echo "no_std proof: C compiler 'cc' not found (needed as linker)" >&2; exit 1; }
target="${CARGO_TARGET_DIR:-$(cd ../../.. && pwd)/target}/no-std-proof"
mkdir -p "$target"
library="$target/release/libhysteron_rt_proof.a"
log="$target/log"
entries="proof_step_f32 proof_step_f64 proof_simulate_f32 proof_simulate_f64
proof_sensitivities_f32 proof_sensitivities_f64 proof_plays_f32 proof_plays_f64
proof_online_f32 proof_online_f64 proof_model_f32 proof_model_f64
proof_compensator_f32 proof_compensator_f64 proof_controller_f32 proof_controller_f64"

build() { cargo build --quiet --locked --release --target-dir "$target" "$@" >"$log" 2>&1; }
# Links the entries named, with everything they reach and nothing else.
link() {
    local flags=()
    for entry in "$@"; do flags+=("-Wl,--require-defined=$entry"); done
    cc -nostartfiles -Wl,--gc-sections -Wl,-e,"$1" "${flags[@]}" "$library" -o "$target/linked" >"$log" 2>&1
}
fail() { echo "no_std proof FAILED: $1" >&2; cat "$log" >&2; exit 1; }

build || fail "hysteron-rt does not build without std"
for entry in $entries; do
    link "$entry" || fail "$entry can panic (or does not link)"
done

build --features panicking || fail "the negative control does not build"
link proof_panicking && fail "a function that can panic was linked: the proof proves nothing"
grep -q "hysteron_rt_can_panic" "$log" || fail "the negative control failed for another reason"

build --features std && fail "a library with std was built: the proof proves nothing"
grep -q "E0152" "$log" || fail "the std control failed for another reason"

echo "no_std proof: $(wc -w <<<"$entries") entries need no std and cannot panic; both negative" \
    "controls fail as they must"
