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
# Cargo verifies a crate against the packages made just before, which it takes for a registry without a name, and
# does not unpack again what it unpacked there in an earlier run: that would be the source of then.
rm -rf "${CARGO_HOME:-$HOME/.cargo}"/registry/{src,cache}/-*/hysteron{,-*}-"$version"{,.crate}
if ((left)); then
    cargo publish --workspace --locked "${arguments[@]}" "$@"
fi
