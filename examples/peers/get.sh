#!/usr/bin/env bash
# Says where the programs are that examples/peers puts beside ours, and what of them is found here.
# Nothing of them is part of this project, and nothing is fetched: read their licences first.
set -u

cat <<'TEXT'
pyEIT   https://github.com/eitcom/pyEIT (BSD licence)
          git clone https://github.com/eitcom/pyEIT; export PYEIT=$PWD/pyEIT
        It needs NumPy, SciPy, h5py, Shapely and Matplotlib:
          apt-get install python3-scipy python3-h5py python3-shapely python3-matplotlib
EIDORS  https://eidors.org, https://github.com/eidors3d/eidors-readonly (GPL)
          git clone https://github.com/eidors3d/eidors-readonly
          export EIDORS=$PWD/eidors-readonly/eidors
        It needs Octave:
          apt-get install octave
Then    ./ertbench run experiments/peers_quick.json

TEXT
if python3 -c 'import os, sys; sys.path.insert(0, os.environ.get("PYEIT", "")); import h5py, pyeit.eit.jac' 2>/dev/null; then
  echo "pyEIT: found"
else
  echo "pyEIT: not found; its rows will say so"
fi
if [[ -n ${EIDORS:-} && -e $EIDORS/eidors_obj.m ]] && command -v octave-cli >/dev/null; then
  echo "EIDORS: found"
else
  echo "EIDORS: not found; its rows will say so"
fi
