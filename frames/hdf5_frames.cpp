#include <algorithm>
#include <numeric>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "core/lists.h"
#include "forward/data/dataset_file.h"
#include "frames/frame_source.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using Shape = std::vector<std::uint64_t>;

/// Size limit, in numbers, of an array that must be transposed in memory.
constexpr std::uint64_t most_turned = std::uint64_t{1} << 28U;
constexpr const char* default_name = "/voltages";
constexpr const char* reference_name = "reference_voltages";

std::string list_of(std::vector<std::string> names) {
  std::erase_if(names, [](const std::string& name) { return name.starts_with('#'); });  // MATLAB's
  return names.empty() ? "nothing" : joined(names);
}

/// An array of the file with its dimensions in the order of the program that wrote it.
class StoredArray {
 public:
  StoredArray(const Hdf5File& file, std::string name, bool is_matlab)
      : file_(&file), name_(std::move(name)), stored_(name_), reversed_(is_matlab) {
    if (!is_matlab && file.has_attribute(name_, "OCTAVE_NEW_FORMAT") &&
        file.has(name_ + "/value")) {
      stored_ = name_ + "/value";
      reversed_ = true;
    }
    refuse_what_is_no_array();
    shape_ = file.shape(stored_);
    if (reversed_) std::ranges::reverse(shape_);
  }

  const Shape& shape() const { return shape_; }
  bool reversed() const { return reversed_; }
  const std::string& stored() const { return stored_; }

  /// The whole array, [first dimension, the others flattened with the last one fastest].
  RowMajorMatrix all() const {
    const std::uint64_t total =
        std::accumulate(shape_.begin(), shape_.end(), std::uint64_t{1}, std::multiplies<>());
    if (total > most_turned) {
      throw InputError(file_->path().string() + ": " + name_ + ": has " + std::to_string(total) +
                       " numbers, too many to be turned round in memory; save it in parts");
    }
    if (!reversed_ || shape_.size() < 2) return file_->read_rows(stored_, 0, first_stored(), true);
    if (shape_.size() > 3) {
      throw InputError(file_->path().string() + ": " + name_ + ": has " +
                       std::to_string(shape_.size()) + " dimensions; three can be turned round");
    }
    const RowMajorMatrix raw = file_->read_rows(stored_, 0, first_stored(), true);
    const auto rows = static_cast<Eigen::Index>(shape_.front());
    if (shape_.size() == 2) return raw.transpose();
    // [m][d][n] in the file, [n][d][m] here.
    const auto middle = static_cast<Eigen::Index>(shape_[1]);
    const auto last = static_cast<Eigen::Index>(shape_[2]);
    RowMajorMatrix turned(rows, middle * last);
    for (Eigen::Index m = 0; m < last; ++m) {
      for (Eigen::Index d = 0; d < middle; ++d) {
        turned.col(d * last + m) = raw.row(m).segment(d * rows, rows).transpose();
      }
    }
    return turned;
  }

 private:
  std::uint64_t first_stored() const {
    if (shape_.empty()) return 1;
    return reversed_ ? shape_.back() : shape_.front();
  }

  void refuse_what_is_no_array() const {
    if (!file_->has_attribute(name_, "MATLAB_class")) return;
    const std::string type = file_->read_text(name_, "MATLAB_class");
    const auto refuse = [&](const std::string& what) {
      throw InputError(file_->path().string() + ": " + name_ + ": " + what);
    };
    if (type == "cell") refuse("is a cell array; save a matrix, as cell2mat makes one");
    if (type == "struct") {
      refuse("is a struct; name one of its fields by --dataset " + name_ + "/FIELD; it has " +
             list_of(file_->names(name_)));
    }
    if (type == "char" || type == "function_handle") refuse("must hold numbers, is a " + type);
  }

  const Hdf5File* file_;
  std::string name_;
  std::string stored_;
  bool reversed_;
  Shape shape_;
};

class Hdf5Frames final : public FrameSource {
 public:
  Hdf5Frames(const fs::path& input, const FrameFileOptions& options, bool is_matlab)
      : file_(Hdf5File::open(input)),
        is_matlab_(is_matlab),
        name_(name_of_frames(options.dataset)),
        array_(array(name_)) {
    transposed_ = options.transposed.value_or(false);
    require_frames(transposed_);
    if (array_.reversed() || transposed_ || array_.shape().size() == 1) {
      held_ = array_.all();
      if (transposed_) held_.transposeInPlace();
      if (array_.shape().size() == 1) held_.transposeInPlace();
      frames_ = static_cast<std::uint64_t>(held_.rows());
      columns_ = held_.cols();
    } else {
      const Shape& shape = array_.shape();
      frames_ = shape[0];
      columns_ = static_cast<Eigen::Index>(
          std::accumulate(shape.begin() + 1, shape.end(), std::uint64_t{1}, std::multiplies<>()));
    }
    require_finished();
    begin_ = rows(0, 1);
  }

  std::string format() const override {
    if (is_matlab_) return "MATLAB v7.3";
    return array_.reversed() ? "Octave HDF5" : "HDF5";
  }
  std::string dataset() const override { return name_; }
  std::uint64_t frames() const override { return frames_; }
  Eigen::Index columns() const override { return columns_; }
  Shape frame_shape() const override {
    const Shape& shape = array_.shape();
    return shape.size() == 3 ? Shape{shape[1], shape[2]} : Shape{};
  }

  RowMajorMatrix read(std::uint64_t first, std::uint64_t count) const override {
    RowMajorMatrix out = rows(first, count);
    require_same_missing(out, first, begin_, file_.path().string() + ": " + name_);
    return out;
  }

  RowMajorMatrix reference() const override {
    const std::string name = name_.substr(0, name_.rfind('/') + 1) + reference_name;
    if (!file_.has(name)) return {};
    const StoredArray found = array(name);
    RowMajorMatrix all = found.all();
    // A vector is one row, whichever way it lies.
    const bool turned =
        transposed_ && all.rows() == columns_ && static_cast<std::uint64_t>(all.cols()) == frames_;
    if (turned || found.shape().size() == 1 || (all.cols() == 1 && columns_ != 1))
      all.transposeInPlace();
    return all;
  }

  std::optional<Sensor> sensor() const override {
    if (!file_.has_attribute("/", "sensor")) return std::nullopt;
    return sensor_of(file_);
  }

  RowMajorMatrix table(const std::string& name) const override { return array(name).all(); }
  std::vector<fs::path> files() const override { return {file_.path()}; }

 private:
  RowMajorMatrix rows(std::uint64_t first, std::uint64_t count) const {
    if (held_.size() == 0) return file_.read_rows(array_.stored(), first, count, true);
    return held_.middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(count));
  }

  StoredArray array(const std::string& name) const { return {file_, name, is_matlab_}; }

  /// The dataset asked for, otherwise /voltages, otherwise the only one of the file.
  std::string name_of_frames(const std::string& wanted) const {
    if (!wanted.empty()) {
      std::string name = wanted.starts_with('/') ? wanted : "/" + wanted;
      if (!file_.has(name)) {
        throw InputError(file_.path().string() + ": " + name + ": is missing; the file holds " +
                         list_of(file_.names("/")));
      }
      return name;
    }
    if (file_.has(default_name)) return default_name;
    std::vector<std::string> found = file_.names("/");
    std::erase_if(found, [](const std::string& name) {
      return name.starts_with('#') || name == reference_name;
    });
    if (found.size() == 1) return "/" + found.front();
    throw InputError(file_.path().string() + ": /voltages: is missing; name the frames by " +
                     "--dataset, one of " + list_of(file_.names("/")));
  }

  void require_frames(bool transposed) const {
    const Shape& shape = array_.shape();
    const bool empty = std::ranges::find(shape, 0U) != shape.end();
    if (shape.empty() || shape.size() > 3 || empty || (transposed && shape.size() != 2)) {
      throw InputError(file_.path().string() + ": " + name_ + ": must have shape [N, channels]" +
                       (transposed ? " to be transposed" : " or [N, drives, measurements]") +
                       ", has " + std::to_string(shape.size()) + " dimensions" +
                       (empty ? ", one of them empty" : ""));
    }
  }

  /// Refuses a dataset of this program whose generation was interrupted.
  void require_finished() const {
    namespace layout = dataset_layout;
    if (file_.has(layout::scenes_written) &&
        file_.read_rows(layout::scenes_written, 0, 1)(0, 0) != static_cast<double>(frames_)) {
      throw InputError(file_.path().string() + ": is not finished; generate it again to go on");
    }
  }

  Hdf5File file_;
  bool is_matlab_;
  std::string name_;
  StoredArray array_;
  bool transposed_ = false;
  RowMajorMatrix held_;   ///< the frames, if they had to be transposed
  RowMajorMatrix begin_;  ///< the first frame
  std::uint64_t frames_ = 0;
  Eigen::Index columns_ = 0;
};

}  // namespace

std::unique_ptr<FrameSource> open_hdf5_frames(const fs::path& input,
                                              const FrameFileOptions& options, bool is_matlab) {
  return std::make_unique<Hdf5Frames>(input, options, is_matlab);
}

}  // namespace ertbench
