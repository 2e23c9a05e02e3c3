// The module `ertbench._core`: the C++ library for python/ertbench/*.py, which documents it.

#include "core/build.h"
#include "core/errors.h"
#include "python/module/arrays.h"

PYBIND11_MODULE(_core, module) {
  namespace py = pybind11;
  py::register_exception<ertbench::InputError>(module, "InputError", PyExc_ValueError).doc() =
      "Input that cannot be used. The text names the place and what would be right.";
  module.attr("project_folder") = ertbench::project_folder().string();
  ertbench::bind_sensor(module);
  ertbench::bind_forward(module);
  ertbench::bind_scenes(module);
  ertbench::bind_solver(module);
  ertbench::bind_frames(module);
}
