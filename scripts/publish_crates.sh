#!/usr/bin/env bash
# Publishes the crates in the order of their dependencies, without those of this version that the registry has:
# a run that broke off half-way is started again. Arguments go to `cargo publish` (`--dry-run`).
set -euo pipefail
cd "$(dirname "$0")/.."
version=$(scripts/release_version.py | cut -d= -f2)
crates=$(cargo metadata --no-deps --format-version 1 --locked |
    python3 -c 'import json, sys
for p in json.load(sys.stdin)["packages"]:
    if p["publish"] != []:
        print(p["name"])')
arguments=()
left=0
for crate in $crates; do
    # Asked outside of the workspace, where the name means the registry's crate.
    if (cd / && cargo info --quiet "$crate@$version" >/dev/null 2>&1); then
        echo "$crate $version is published"
        arguments+=(--exclude "$crate")
    else
        left=$((left + 1))
    fi
done
# Cargo verifies a crate against the packages made just before, which it takes for a registry whose versions never
# change: what it unpacked and built of them in an earlier run would be the source of then. So they are built in a
# folder of their own, without what is there of these crates.
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-target}/packages
rm -rf "$CARGO_TARGET_DIR"/package "$CARGO_TARGET_DIR"/debug/{.fingerprint,build,deps,incremental}/*hysteron* \
    "${CARGO_HOME:-$HOME/.cargo}"/registry/{src,cache}/-*/hysteron{,-*}-"$version"{,.crate}
if ((left)); then
    cargo publish --workspace --locked "${arguments[@]}" "$@"
fi
