#!/bin/bash
# Builds with CUDA, tests the networks on the GPU, measures their training, and prints one table.
#
#   models/benchmarks/gpu.sh [--packages FOLDER] [--torch FOLDER] [--build FOLDER]
#
# --packages: unpacked Debian packages (for p in *.deb; do dpkg -x $p FOLDER; done) of what this machine
#   has not: libeigen3-dev nlohmann-json3-dev libcli11-dev libspdlog-dev libfmt-dev libhdf5-dev
#   libspectra-dev librandom123-dev libxxhash-dev libcpp-httplib-dev libmatio-dev libgtest-dev
#   libgmock-dev libopenblas0-openmp, and what these need.
# --torch: libtorch with share/cmake/Torch (default: that of python3's torch).
# SCENES, BATCH, EPOCHS: of the trainings (4 000 000 presented in all; smaller ones rehearse on a CPU).
# DEVICE: cuda; cpu rehearses.
set -euo pipefail
cd "$(dirname "$0")/../.."
packages= torch= build=build/gpu
while [ $# -gt 0 ]; do
  case $1 in
    --packages) packages=$(realpath "$2") ;;
    --torch) torch=$(realpath "$2") ;;
    --build) build=$2 ;;
    *) echo "gpu.sh: unknown option $1; there are --packages, --torch and --build" >&2; exit 2 ;;
  esac
  shift 2
done
device=${DEVICE:-cuda} scenes=${SCENES:-100000} epochs=${EPOCHS:-40} batch=${BATCH:-1024}
options=(-DCMAKE_BUILD_TYPE=Release -DERTBENCH_UNITY=ON -DERTBENCH_BENCHMARKS=OFF)
if [ -n "$packages" ]; then
  lib=$packages/usr/lib/x86_64-linux-gnu
  options+=("-DCMAKE_PREFIX_PATH=$packages/usr" "-DCMAKE_LIBRARY_PATH=$lib;$lib/hdf5/serial;$lib/openblas-openmp"
    "-DCMAKE_INCLUDE_PATH=$packages/usr/include;$packages/usr/include/hdf5/serial" "-DHDF5_ROOT=$packages/usr")
  export LD_LIBRARY_PATH=$lib:$lib/hdf5/serial:$lib/openblas-openmp:${LD_LIBRARY_PATH:-}
fi
if [ -n "$torch" ]; then
  options+=("-DTorch_DIR=$torch/share/cmake/Torch")
elif found=$(python3 -c 'import torch
print(int(torch.compiled_with_cxx11_abi()), torch.utils.cmake_prefix_path)' 2>/dev/null); then
  # Debian's libraries have the new ABI of std::string, and cannot be linked with the old one.
  [ "${found%% *}" = 1 ] || { echo "gpu.sh: this PyTorch has the old C++ ABI; take 2.7 or later, or --torch" >&2; exit 2; }
  options+=("-DTorch_DIR=${found#* }/Torch")
fi
start=$SECONDS
cmake -S . -B "$build" -G Ninja "${options[@]}" > "$build.log" 2>&1 ||
  { tail -30 "$build.log" >&2; exit 1; }
ninja -C "$build" ertbench models_tests >> "$build.log" 2>&1 || { tail -40 "$build.log" >&2; exit 1; }
built=$((SECONDS - start))
ERTBENCH_DEVICE=$device "$build"/tests/models_tests --gtest_brief=1 --gtest_filter='Training.*:TrainingSet.*:AdversarialObjective.*'
tested=$((SECONDS - start - built))

work=$(mktemp -d) && trap 'rm -rf "$work"' EXIT
python3 - "$scenes" "$epochs" "$batch" > "$work/gpu.json" << 'END'
import json, sys
scenes, epochs, batch = map(int, sys.argv[1:])
touches = {"contacts": [1, 3], "shapes": ["disc", "ellipse", "rectangle"], "radius": [0.06, 0.4],
           "conductivity_ratio": [0.1, 0.9], "placement": "inside"}
def dataset(count, seed):
    return {"count": count, "seed": seed, "grid": 24, "snr_db": 50, "snr_basis": "absolute", "scenes": touches}
shared = {"epochs": epochs, "batch": batch, "precision": "bfloat16", "patience": epochs, "seed": 1}
dd_ert = {"type": "dd-ert", "learning_rate": 0.008, "slow_rate": 0.015, "freeze_statistics": 0.4}
print(json.dumps({
    "title": "Trainings on a GPU",
    "datasets": {"train": dataset(scenes, 1), "validation": dataset(min(2000, scenes), 2), "test": dataset(200, 3)},
    "solvers": [
        {**dd_ert, **shared, "label": "dd-ert, one convolution", "convolutions": 1},
        {**dd_ert, **shared, "label": "dd-ert, two convolutions"},
        {"type": "lean-net", **shared, "label": "lean-net 48", "width": 48}],
    "timing": {"enabled": False}, "figure": {"scenes": []}}))
END
ERTBENCH_CACHE=$work/cache "$build"/bench/ertbench run "$work/gpu.json" --out "$work/out" --jobs 1 --device "$device" > "$work/log" 2>&1 ||
  { tail -30 "$work/log" >&2; exit 1; }
card=$(nvidia-smi --query-gpu=name --format=csv,noheader 2>/dev/null | head -1 || true)
echo
echo "$device: ${card:-no GPU}, $(nproc) cores; build $built s, tests $tested s, all $((SECONDS - start)) s"
python3 - "$work/out/summary.json" "$scenes" << 'END'
import json, sys
rows = json.load(open(sys.argv[1]))["rows"]
print("| network | scenes/s | s for 4 million scenes | device | validation error | status |\n|---|---:|---:|---|---:|---|")
for row in rows:
    training = (row.get("parameters") or {}).get("training")
    if not training: continue
    presented = training["epochs"] * int(sys.argv[2])
    rate = presented / training["seconds"]
    print(f"| {row['label']} | {rate:,.0f} | {4e6 / rate:.0f} | {training['runtime']['device']} | "
          f"{training['validation_error']:.3f} | {training['status']} |")
END
