"""Builds the C++ module by CMake and puts it into the package with the libraries that it needs.

    pip install --no-build-isolation ./python

Nothing is downloaded: the Debian packages that `./ertbench` installs, pybind11-dev, libpython3-dev and
python3-numpy must be there. $ERTBENCH_BUILD names the build folder, by default build/python of the
sources; libraries that `./ertbench` has built already are not taken, as they may have been built for
another Python. $ERTBENCH_MODELS=OFF leaves out the learned solvers, which need libtorch.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent.parent


class WithModule(Distribution):
    def has_ext_modules(self):
        return True


class BuildByCMake(build_py):
    def run(self):
        if not (ROOT / "CMakePresets.json").is_file():
            sys.exit("ertbench: the package is built inside a clone of the project, of which "
                     f"{ROOT} is none")
        build = Path(os.environ.get("ERTBENCH_BUILD", ROOT / "build" / "python"))
        models = os.environ.get("ERTBENCH_MODELS", "ON")
        subprocess.run(["cmake", "--preset", "release", "-B", build, f"-DERTBENCH_MODELS={models}",
                        "-DBUILD_TESTING=OFF", "-DERTBENCH_BENCHMARKS=OFF",
                        f"-DPython3_EXECUTABLE={sys.executable}"], cwd=ROOT, check=True)
        targets = ["ertbench_python"] + (["ertbench_models"] if models == "ON" else [])
        made = subprocess.run(["cmake", "--build", build, "--target", *targets], cwd=ROOT)
        if made.returncode != 0:
            sys.exit("ertbench: the module was not built; it needs pybind11-dev, libpython3-dev and "
                     "what ./ertbench installs")
        package = Path(self.build_lib) / "ertbench"
        shutil.rmtree(package, ignore_errors=True)
        shutil.copytree(build / "python" / "ertbench", package)
        names = ["core/libertbench_core.so", "forward/libertbench_forward.so",
                 "solvers/libertbench_solvers.so", "bench/libertbench_bench.so"]
        for name in names + (["bench/libertbench_models.so"] if models == "ON" else []):
            shutil.copy2(build / name, package)


setup(packages=["ertbench"], distclass=WithModule, cmdclass={"build_py": BuildByCMake})
