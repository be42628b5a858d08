#!/bin/sh
# Installs the PostgreSQL server with which the tests of the registry run, from the system's packages. Where that
# cannot be done, the tests say so and are skipped.
set -u
if ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || command -v initdb >/dev/null; then
  exit 0
fi
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
  export DEBIAN_FRONTEND=noninteractive
  { apt-get update && apt-get install --yes --no-install-recommends postgresql; } >/dev/null 2>&1 && exit 0
fi
echo "note: no PostgreSQL server is installed; its tests are skipped"
echo "  try: your system's package, e.g. 'apt-get install postgresql'"
