#!/usr/bin/env bash
# Packs what a release carries beside the tree: reports, logs and records of the named results, and the
# fitted solvers and datasets of the cache. Nothing of it is committed.
#
#   results/archive.sh ertbench-0.3.tar.xz table_c1 stability
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if (($# < 2)); then
  echo "results/archive.sh ARCHIVE.tar.xz NAME...: the results are those of ./ertbench run" >&2
  exit 2
fi
archive=$1
parts=()
for name in "${@:2}"; do
  if [[ ! -d results/$name ]]; then
    echo "results/$name: there is no such result; ./ertbench run experiments/$name.json makes it" >&2
    exit 2
  fi
  parts+=("results/$name")
done
for folder in solvers datasets; do
  [[ -d cache/$folder ]] && parts+=("cache/$folder")
done
tar --create --xz --file "$archive.part" "${parts[@]}"
mv "$archive.part" "$archive"
echo "$archive: $(du -h "$archive" | cut -f1)"
