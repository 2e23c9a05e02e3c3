"""Builds the C++ module by CMake and puts it into the package with the libraries that it needs.

    pip install --no-build-isolation ./python

Nothing is downloaded: what `./ertbench` installs, pybind11-dev, libpython3-dev and python3-numpy must
be there. Libraries that `./ertbench` has built are taken; without them the build, in build/python, takes
some minutes. $ERTBENCH_BUILD names another build folder.
"""

import os
import shutil
import subprocess
import sys
import sysconfig
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
        build = Path(os.environ.get("ERTBENCH_BUILD", self.built_before() or ROOT / "build/python"))
        if not (build / "CMakeCache.txt").is_file():
            subprocess.run(["cmake", "--preset", "release", "-B", build, "-DBUILD_TESTING=OFF",
                            "-DERTBENCH_BENCHMARKS=OFF", f"-DPython3_EXECUTABLE={sys.executable}"],
                           cwd=ROOT, check=True)
        subprocess.run(["cmake", build], check=True)  # finds what was installed since
        made = subprocess.run(["cmake", "--build", build, "--target", "ertbench_python",
                               "ertbench_models"])
        if made.returncode != 0:
            sys.exit("ertbench: the module was not built; it needs pybind11-dev, libpython3-dev and "
                     "what ./ertbench installs")
        package = Path(self.build_lib) / "ertbench"
        shutil.rmtree(package, ignore_errors=True)
        shutil.copytree(build / "python" / "ertbench", package)
        for name in ("core/libertbench_core", "forward/libertbench_forward",
                     "solvers/libertbench_solvers", "bench/libertbench_bench",
                     "bench/libertbench_models"):
            shutil.copy2(build / (name + ".so"), package)

    @staticmethod
    def built_before():
        """The launcher's build, if it is for this Python; else None."""
        suffix = sysconfig.get_config_var("EXT_SUFFIX")
        asked = "import sysconfig; print(sysconfig.get_config_var('EXT_SUFFIX'), end='')"
        debian = subprocess.run(["/usr/bin/python3", "-c", asked], capture_output=True, text=True)
        release = ROOT / "build" / "release"
        fits = debian.stdout == suffix and (release / "CMakeCache.txt").is_file()
        return release if fits else None


setup(packages=["ertbench"], distclass=WithModule, cmdclass={"build_py": BuildByCMake})
