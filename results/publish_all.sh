#!/usr/bin/env bash
# Publishes every result again, or those named, and commits each: results/publish_all.sh [NAME...]
#
# The same command resumes where it was cut off. Compute the limits of the experiments that publish one
# before (ertbench limit), and leave the machine alone: times are measured.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
names=("$@")
((${#names[@]})) || names=($(find results/published -mindepth 2 -name '*.json' -printf '%h\n' | xargs -n1 basename | sort -u))
failed=()
for name in "${names[@]}"; do
  code=0
  ./ertbench publish "$name" || code=$?  # 1: a trial failed, and is published as failed
  ((code <= 1)) || exit "$code"
  ((code == 0)) || failed+=("$name")
  git add -A results/published README.md docs
  git diff --cached --quiet || git commit --quiet --message "Published: $name"
done
((${#failed[@]} == 0)) || { echo "with failed trials: ${failed[*]}" >&2; exit 1; }
