#!/usr/bin/env bash
# Installs what the tests of exported source use, as far as it may: clang, a compiler and a simulator of ARM,
# GNU Octave, FMPy; for the binaries of units the compilers for Windows and aarch64, wine and QEMU. Quick
# where all is there. What cannot be installed is named; the tests then say which of them they skip.
set -uo pipefail
cd "$(dirname "$0")/../../.."
missing=()
has_newlib() { [[ "$(arm-none-eabi-gcc -print-file-name=rdimon.specs 2>/dev/null)" == */* ]]; }
command -v clang >/dev/null || missing+=(clang)
command -v arm-none-eabi-gcc >/dev/null || missing+=(gcc-arm-none-eabi)
has_newlib || missing+=(libnewlib-arm-none-eabi)
command -v qemu-system-arm >/dev/null || missing+=(qemu-system-arm)
command -v octave-cli >/dev/null || missing+=(octave)
# Without what they recommend: wine's is most of a desktop.
lean=()
command -v x86_64-w64-mingw32-gcc >/dev/null || lean+=(gcc-mingw-w64-x86-64)
command -v aarch64-linux-gnu-gcc >/dev/null || lean+=(gcc-aarch64-linux-gnu libc6-dev-arm64-cross)
command -v qemu-aarch64 >/dev/null || lean+=(qemu-user)
command -v wine >/dev/null || lean+=(wine wine64)
install() {
    apt-get install -y -qq "$@" || { apt-get update -qq && apt-get install -y -qq "$@"; }
}
if ((${#missing[@]} + ${#lean[@]})); then
    echo "tools for exported source: installing ${missing[*]} ${lean[*]}"
    if [[ $(id -u) -eq 0 ]] && command -v apt-get >/dev/null; then
        ((${#missing[@]} == 0)) || install "${missing[@]}" >/dev/null 2>&1 ||
            echo "warning: could not install ${missing[*]}; their tests are skipped"
        ((${#lean[@]} == 0)) || install --no-install-recommends "${lean[@]}" >/dev/null 2>&1 ||
            echo "warning: could not install ${lean[*]}; their tests are skipped"
    else
        echo "warning: not root, or no apt-get: install ${missing[*]} ${lean[*]} yourself; until then their" \
            "tests are skipped"
    fi
fi
venv=target/fmpy-venv
if ! "$venv/bin/python" -c 'import fmpy' 2>/dev/null; then
    echo "tools for exported source: installing FMPy into $venv"
    mkdir -p target
    { python3 -m venv "$venv" && "$venv/bin/pip" install -q fmpy==0.3.32; } >/dev/null 2>&1 ||
        echo "warning: could not install FMPy (python3, venv and the network are needed); the tests of" \
            "FMUs are skipped"
fi
exit 0
