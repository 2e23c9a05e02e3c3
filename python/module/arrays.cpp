#include "python/module/arrays.h"

#include <sched.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <mutex>
#include <string_view>

#include "core/errors.h"
#include "core/lists.h"
#include "core/process.h"

namespace ertbench {

namespace {

std::string text_of(const std::vector<py::ssize_t>& shape, const std::string& first = "") {
  return "[" + first + (first.empty() || shape.empty() ? "" : ", ") + joined(shape) + "]";
}

void require_finite(const Array& array, const std::string& name) {
  const Eigen::Map<const Eigen::VectorXd> numbers(array.data(), array.size());
  if (numbers.allFinite()) return;
  Eigen::Index first = 0;
  while (std::isfinite(numbers[first])) ++first;
  std::vector<py::ssize_t> place(static_cast<std::size_t>(array.ndim()));
  for (py::ssize_t axis = array.ndim(), left = first; axis-- > 0;) {
    place[static_cast<std::size_t>(axis)] = left % array.shape(axis);
    left /= array.shape(axis);
  }
  throw InputError(name + ": must be finite, got " + (std::isnan(numbers[first]) ? "nan" : "inf") +
                   " at " + text_of(place));
}

std::recursive_mutex hdf5_turns;  // a progress report may save a solver

}  // namespace

std::string shape_text(const py::array& array) {
  return text_of({array.shape(), array.shape() + array.ndim()});
}

Array Rows::make(const std::vector<py::ssize_t>& item) const {
  std::vector<py::ssize_t> shape = item;
  if (!single) shape.insert(shape.begin(), count);
  return Array(shape);
}

Array numbers_of(const py::handle& object, const std::string& name, bool finite) {
  const py::array any = py::array::ensure(object);
  if (!any) {
    PyErr_Clear();
    throw InputError(name + ": must be an array of numbers, got " +
                     py::str(py::type::of(object).attr("__name__")).cast<std::string>());
  }
  const char kind = any.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u') {
    throw InputError(name + ": must be an array of real numbers (float64 or float32), got " +
                     py::str(any.dtype()).cast<std::string>() +
                     (kind == 'c' ? "; take its .real" : ""));
  }
  Array array = Array::ensure(any);
  if (!array) throw py::error_already_set();
  if (finite) require_finite(array, name);
  return array;
}

Rows rows_of(const py::handle& object, const std::string& name,
             const std::vector<py::ssize_t>& item, const std::string& unit, bool finite) {
  Rows rows;
  rows.array = numbers_of(object, name, finite);
  const auto dimensions = static_cast<py::ssize_t>(item.size());
  const py::ssize_t extra = rows.array.ndim() - dimensions;
  const bool fits = (extra == 0 || extra == 1) &&
                    std::equal(item.begin(), item.end(), rows.array.shape() + extra);
  if (!fits) {
    throw InputError(name + ": must have the shape " + text_of(item) + " or " + text_of(item, "N") +
                     " (" + unit + "), got " + shape_text(rows.array));
  }
  rows.single = extra == 0;
  rows.count = rows.single ? 1 : rows.array.shape(0);
  rows.size = 1;
  for (const py::ssize_t side : item) rows.size *= side;
  return rows;
}

Array array_of(const Eigen::Ref<const RowMajorMatrix>& rows, std::vector<py::ssize_t> shape) {
  Array out(std::move(shape));
  Eigen::Map<RowMajorMatrix>(out.mutable_data(), rows.rows(), rows.cols()) = rows;
  return out;
}

Hdf5Turn::Hdf5Turn() {
  const py::gil_scoped_release unlocked;
  hdf5_turns.lock();
}
Hdf5Turn::~Hdf5Turn() { hdf5_turns.unlock(); }

void check_signals() {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

int threads_of(int given) {
  std::string_view text;
  if (given == 0) {
    const char* const variable = std::getenv("ERTBENCH_THREADS");
    if (variable) text = variable;
    if (text.empty()) {
      cpu_set_t set;
      return sched_getaffinity(0, sizeof set, &set) == 0 ? std::max(1, CPU_COUNT(&set)) : 1;
    }
    std::from_chars(text.data(), text.data() + text.size(), given);
  }
  if (given < 1) {
    throw InputError((text.empty() ? "threads" : "$ERTBENCH_THREADS") +
                     std::string(": must be a number >= 1, or 0 in a call for all cores"));
  }
  return given;
}

void for_blocks(Eigen::Index count, Eigen::Index block, int threads,
                const std::function<void(Eigen::Index, Eigen::Index)>& work) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds patience(100);
  threads = count > block || threads < 0 ? threads_of(threads) : 1;
  const py::gil_scoped_release unlocked;
  Eigen::Index stride = block * threads;
  for (Eigen::Index first = 0; first < count;) {
    const auto start = Clock::now();
    const Eigen::Index now = std::min(stride, count - first);
    parallel_for(static_cast<std::size_t>(now), static_cast<std::size_t>(block), threads,
                 [&](std::size_t begin, std::size_t end) {
                   work(first + static_cast<Eigen::Index>(begin),
                        first + static_cast<Eigen::Index>(end));
                 });
    first += now;
    if (first == count) return;
    // Many blocks at once keep all threads busy; few let Ctrl-C through.
    if (Clock::now() - start < patience / 2) stride *= 2;
    if (Clock::now() - start > patience)
      stride = std::max(block * threads, stride / 2 / block * block);
    const py::gil_scoped_acquire locked;
    check_signals();
  }
}

}  // namespace ertbench
