#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <functional>
#include <string>
#include <vector>

#include "core/arrays.h"

/// What the files of the Python module share: arrays of NumPy as Eigen's, and loops that Ctrl-C
/// ends.
namespace ertbench {

namespace py = pybind11;

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
using RowsView = Eigen::Map<const RowMajorMatrix>;

/// Items of an array that came from Python, a row each. Contiguous float64 is viewed without a
/// copy, other real numbers are converted.
struct Rows {
  Array array;
  bool single = false;  ///< one item, without the axis of items
  Eigen::Index count = 0;
  Eigen::Index size = 0;  ///< numbers of an item

  RowsView view() const { return {array.data(), count, size}; }
  /// A new array of as many items, each of the shape `item`; squeezed as this one was.
  Array make(const std::vector<py::ssize_t>& item) const;
};

/// Throws InputError, which names `name`, unless `object` is an array of real numbers. `finite`:
/// and all of them are finite.
Array numbers_of(const py::handle& object, const std::string& name, bool finite = true);

/// Reads an array [items, *item], or one item alone. Throws InputError for other shapes: "frames:
/// must have the shape [208] or [N, 208] (V), got [16, 13]".
Rows rows_of(const py::handle& object, const std::string& name,
             const std::vector<py::ssize_t>& item, const std::string& unit, bool finite = true);

/// "[3, 24, 24]"
std::string shape_text(const py::array& array);

/// The numbers of an Eigen array, row by row, as a new array of this shape.
Array array_of(const Eigen::Ref<const RowMajorMatrix>& rows, std::vector<py::ssize_t> shape);

/// The number of threads to use: `given`; of 0 what $ERTBENCH_THREADS says, else all cores.
int threads_of(int given);

/// Calls `work(begin, end)` for blocks of [0, count) on up to threads_of(`threads`) threads,
/// without Python's lock. Throws Python's KeyboardInterrupt soon after Ctrl-C. Exceptions as from
/// parallel_for.
void for_blocks(Eigen::Index count, Eigen::Index block, int threads,
                const std::function<void(Eigen::Index begin, Eigen::Index end)>& work);

/// A turn with the HDF5 library, which serves one thread at a time. Waits for it without Python's
/// lock, so that whoever has the turn may take that.
class Hdf5Turn {
 public:
  Hdf5Turn();
  ~Hdf5Turn();
  Hdf5Turn(const Hdf5Turn&) = delete;
  Hdf5Turn& operator=(const Hdf5Turn&) = delete;
};

/// Throws what a signal handler of Python's raised, such as KeyboardInterrupt.
void check_signals();

// Each adds a part of the module `ertbench._core`.
void bind_sensor(py::module_& module);
void bind_forward(py::module_& module);
void bind_scenes(py::module_& module);
void bind_solver(py::module_& module);
void bind_frames(py::module_& module);  ///< and scores

}  // namespace ertbench
