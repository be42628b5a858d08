#!/usr/bin/env bash
# Instructions of the hot paths, counted by valgrind's callgrind; fails where one has grown by more than 3 %.
#   bench/instructions.sh            compares with bench/instructions.txt
#   bench/instructions.sh --accept   writes the counts into it
# A path's count is that of 3 repetitions less that of 1, halved: making the inputs does not enter. One
# thread, since which thread takes what from another differs from run to run, and with it the count.
set -euo pipefail
cd "$(dirname "$0")/.."
export LC_ALL=C RAYON_NUM_THREADS=1

accept=false
case "${1-}" in
  "") ;;
  --accept) accept=true ;;
  *) echo "error: unknown argument '$1'" >&2; echo "  try: bench/instructions.sh [--accept]" >&2; exit 2 ;;
esac
skip() { echo "instruction counts SKIPPED: $1"; echo "  try: $2"; exit 0; }
command -v valgrind >/dev/null \
  || skip "valgrind is not installed" "your system's package, e.g. 'apt-get install valgrind'"
# valgrind shows a program the processor it runs on, without AVX-512: with AVX2 the kernels and the FFTs are
# then the same code everywhere.
[ "$(uname -m)" = x86_64 ] && grep -qw avx2 /proc/cpuinfo && grep -qw fma /proc/cpuinfo \
  || skip "the counts on file are those of an x86-64 processor with AVX2 and FMA" "such a machine"

cargo build --release --locked -p hysteron-bench --bin hysteron-instructions
binary=target/release/hysteron-instructions
file=bench/instructions.txt
compiler=$(rustc --version)

instructions() {
  local log
  log=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null "$binary" "$1" "$2" 2>&1) \
    || { echo "error: '$1' failed under valgrind:" >&2; echo "$log" >&2; exit 1; }
  awk '/Collected/ { print $NF }' <<<"$log"
}

new=$(mktemp)
trap 'rm -f "$new"' EXIT
echo "# instructions of one repetition; $compiler; written by bench/instructions.sh --accept" >"$new"
failed=false
if [ -f "$file" ] && ! head -n 1 "$file" | grep -qF "$compiler"; then
  echo "note: the counts on file are those of another compiler, which alone may move them:" \
    "$(head -n 1 "$file")"
fi
printf '%-18s %15s %15s %9s\n' path instructions "on file" change
for path in $("$binary"); do
  one=$(instructions "$path" 1)
  three=$(instructions "$path" 3)
  count=$(((three - one) / 2))
  echo "$path $count" >>"$new"
  before=$(awk -v path="$path" '$1 == path { print $2 }' "$file" 2>/dev/null || true)
  if [ -z "$before" ]; then
    printf '%-18s %15d %15s %9s\n' "$path" "$count" none new
    $accept || failed=true
    continue
  fi
  verdict=$(awk -v a="$count" -v b="$before" \
    'BEGIN { c = 100 * (a / b - 1); printf("%+.2f%%%s", c, (c > 3) ? "  GREW" : "") }')
  printf '%-18s %15d %15d %9s\n' "$path" "$count" "$before" "$verdict"
  case "$verdict" in *GREW) failed=true ;; esac
done
if $accept; then
  cp "$new" "$file"
  echo "written: $file"
elif $failed; then
  echo "error: a hot path takes over 3 % more instructions than on file, or is not on file" >&2
  echo "  try: find the cause; if the growth is wanted, bench/instructions.sh --accept and say why in the" \
    "commit" >&2
  exit 1
fi
