#!/usr/bin/env bash
# Installs what the tests of the page use, as far as it may: node, npm and a browser of the system. Quick where
# all is there. What cannot be installed is named.
set -uo pipefail
missing=()
command -v node >/dev/null || missing+=(nodejs)
command -v npm >/dev/null || missing+=(npm)
command -v chromium >/dev/null || command -v chromium-browser >/dev/null ||
    command -v google-chrome >/dev/null || missing+=(chromium)
if ((${#missing[@]})); then
    echo "tools for the page: installing ${missing[*]}"
    if [[ $(id -u) -eq 0 ]] && command -v apt-get >/dev/null; then
        {
            apt-get install -y -qq "${missing[@]}" ||
                { apt-get update -qq && apt-get install -y -qq "${missing[@]}"; }
        } >/dev/null 2>&1 || echo "warning: could not install ${missing[*]}"
    else
        echo "warning: not root, or no apt-get: install ${missing[*]} yourself"
    fi
fi
exit 0
