#!/usr/bin/env bash
# Makes every result in results/published again, from one commit of the sources.
#
#   results/publish_all.sh --plan      what it will take
#   results/publish_all.sh             all of it
#   results/publish_all.sh NAME...     some of it, by the names of the experiments
#   results/publish_all.sh --clocks    the times of all tables again, together on this machine
#   results/publish_all.sh --part NAME LABEL,...  some solvers of one that takes more than a sitting
#
# It may be cut off at any time: the same command goes on where it stopped, since fits, records and
# the frames of limits are kept in the cache and in results/. Each experiment is committed when it
# is finished; that commit changes results alone, so that the next is still of the same sources.
# Clocks are taken at the end of each experiment: leave the machine to it. Where the experiments came
# from several machines, or from one over days, --clocks makes their times comparable. (Studies of
# touch count times in; their own stay. So do those of other people's programs.)
#
# What takes longer than a machine is there for is made in parts. --part runs the solvers with these
# labels ("dd-ert,lean-net width=8") and commits their records, packed, to results/parts. Where an
# experiment has parts, whatever machine they came from, their solvers are not fitted again, its times
# stay as they were published, and --clocks is to be called afterwards; publishing it removes the parts.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# Experiment; "fidelity" where the sheet's models are compared on its scenes, "load" where rates of frames
# are measured; "limit" where its limit is computed, of how many frames and with which options. (What the
# training sets of the broad readings allow takes minutes a frame, and is left to who asks for it.)
experiments=(
  "quick"
  "table_c1 limit 200"
  "table_c1_broad limit 200 --prior oracle"
  "table_c1_fine limit 200 --prior oracle"
  "table_c1_literal limit 200 --prior oracle"
  "table_c1_continuous limit 200 --prior oracle"
  "load load"
  "speed_accuracy limit 100"
  "two_fingers"
  "stability"
  "stability_training"
  "robustness"
  "ablation"
  "grid_alpha_beta"
  "shared_grid_24"
  "shared_grid_192"
  "shared_grid_auto"
  "fidelity fidelity"
  "training_budget"
  "adversarial"
  "localisation"
  "localisation_rising"
  "sensitivity"
  "sensitivity_rising"
  "targets"
  "targets_rising"
  "tracking"
  "tracking_rising"
  "collision"
  "collision_rising"
  "tank"
  "skin"
  "peers"
)

clocks=(quick table_c1 table_c1_broad table_c1_fine table_c1_literal table_c1_continuous
  speed_accuracy two_fingers)

publish_clocks() {
  local files=() name
  for name in "${clocks[@]}"; do files+=("experiments/$name.json"); done
  ./ertbench publish --clocks "${files[@]}"
  commit_published "Published: the clocks of all tables"
}

# parts_of NAME: the archives of its records, the oldest first.
parts_of() {
  [[ -d results/parts ]] || return 0
  find results/parts -name "$1.[0-9]*.tar.gz" | sort -V
}

# bring_parts NAME: what they hold, beside the results of this machine, which go first.
bring_parts() {
  local part
  mkdir -p "results/$1"
  for part in $(parts_of "$1"); do
    tar --extract --gzip --skip-old-files --file "$part" --directory "results/$1"
  done
}

# keep_part NAME LABELS: runs these solvers and packs the records that no part has yet. Returns 1 where
# one of them failed; what the others left is packed.
keep_part() {
  local name="$1" labels="$2" part kept made number code=0
  bring_parts "$name"
  ./ertbench run "experiments/$name.json" --only "$labels" || code=$?
  if ((code > 1)); then return "$code"; fi
  kept=$(for part in $(parts_of "$name"); do tar --list --gzip --file "$part"; done | sort)
  made=$(cd "results/$name" && find . -path "./records/*.accuracy.json" -o -path "./training/*.csv" | sort)
  made=$(comm -13 <(printf '%s\n' "$kept") <(printf '%s\n' "$made"))
  if [[ -z "$made" ]]; then
    echo "results/publish_all.sh: results/parts has all that there is of these" >&2
    return "$code"
  fi
  number=$(parts_of "$name" | wc -l)
  part="results/parts/$name.$((number + 1)).tar.gz"
  mkdir -p results/parts
  tar --create --gzip --file "$part.new" --directory "results/$name" --files-from - <<< "$made"
  mv "$part.new" "$part"
  git add "$part"
  git commit --quiet --message "A part of $name: $labels" -- "$part"
  return "$code"
}

# commit_published MESSAGE: what publishing has changed.
commit_published() {
  git add -A results/published README.md docs
  git diff --cached --quiet || git commit --quiet --message "$1"
}

# bring_limit NAME: the published limit with its figure, beside results that have none. `ertbench limit`
# leaves both as they are where they are of this code and these sets, as the frames' own records may be on
# another machine; without the figure it would compute anew.
bring_limit() {
  local from="results/published/$1" to="results/$1" name
  [[ -e "$to/limit.json" || ! -e "$from/limit.json" ]] && return
  mkdir -p "$to"
  for name in limit_ranks.png limit_ranks.svg limit.json; do
    [[ -e "$from/$name" ]] || continue
    cp "$from/$name" "$to/.$name.new"
    mv "$to/.$name.new" "$to/$name"
  done
}

# A function, which the shell has read whole before it begins: this file may change meanwhile, as
# commits come in.
main() {
  if [[ "${1:-}" == --part ]]; then
    if (($# != 3)) || [[ ! -e "experiments/$2.json" ]]; then
      echo "usage: results/publish_all.sh --part NAME LABEL,... (experiments/NAME.json)" >&2
      exit 2
    fi
    keep_part "$2" "$3"
    exit 0
  fi
  plan=false
  wanted=()
  for argument in "$@"; do
    case "$argument" in
      --plan) plan=true ;;
      --clocks) publish_clocks; exit 0 ;;
      -*)
        echo "usage: results/publish_all.sh [--plan | --clocks | --part NAME LABEL,... | NAME...]" >&2
        exit 2
        ;;
      *) wanted+=("$argument") ;;
    esac
  done

  chosen=()
  for line in "${experiments[@]}"; do
    name="${line%% *}"
    if [[ ${#wanted[@]} -eq 0 ]] || printf '%s\n' "${wanted[@]}" | grep -qxF "$name"; then
      chosen+=("$line")
    fi
  done
  for name in "${wanted[@]}"; do
    if ! printf '%s\n' "${experiments[@]%% *}" | grep -qxF "$name"; then
      echo "results/publish_all.sh: no published experiment is called \"$name\"" >&2
      exit 2
    fi
  done

  files=()
  for line in "${chosen[@]}"; do
    [[ "$line" == *" fidelity" ]] || files+=("experiments/${line%% *}.json")  # it fits nothing
  done
  if ((${#files[@]})); then ./ertbench publish --plan "${files[@]}"; fi
  $plan && exit 0

  local failed=()
  for line in "${chosen[@]}"; do
    read -r name what frames options <<< "$line"
    if [[ "$what" == limit ]]; then
      bring_limit "$name"
      # shellcheck disable=SC2086  # options are words
      ./ertbench limit "experiments/$name.json" --frames "$frames" --threads "$(nproc)" $options
    fi
    how=()
    parts=$(parts_of "$name")
    if [[ -n "$parts" ]]; then
      bring_parts "$name"
      how=(--scores)
    fi
    if [[ "$what" == fidelity || "$what" == load ]]; then how=("--$what"); fi
    # 1: a trial failed, and stands as failed in what was published; the others go on.
    local code=0
    ./ertbench publish "${how[@]}" "experiments/$name.json" || code=$?
    if ((code > 1)); then exit "$code"; fi
    if ((code == 1)); then failed+=("$name"); fi
    # What failed is tried again, perhaps on another machine, which needs the others' parts.
    # shellcheck disable=SC2086  # a name each
    if [[ -n "$parts" ]] && ((code == 0)); then git rm --quiet $parts; fi
    commit_published "Published: $name"
  done
  if ((${#failed[@]})); then
    echo "results/publish_all.sh: with failed trials: ${failed[*]}" >&2
    exit 1
  fi
}

main "$@"
exit
