// MATLAB's files of versions 5 to 7 ("level 5"), by libmatio; those of version 7.3 are HDF5.

#include <matio.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>

#include "core/errors.h"
#include "core/lists.h"
#include "core/text.h"
#include "frames/frame_source.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_numbers = std::size_t{1} << 27U;

struct CloseMat {
  void operator()(mat_t* file) const { Mat_Close(file); }
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Variable = std::unique_ptr<matvar_t, CloseMat>;

template <typename Number>
void read_numbers(const void* data, std::size_t count, std::vector<double>& out) {
  const auto* const numbers = static_cast<const Number*>(data);
  out.assign(numbers, numbers + count);
}

/// Set by libmatio where it finds something wrong and goes on, with zeros for what is missing.
thread_local bool complained = false;

/// Whether the elements of a level-5 file, each with type and length before it, end with the file.
bool is_whole(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::uint64_t size = fs::file_size(path);
  std::uint64_t at = 128;
  std::array<char, 128> head{};
  in.read(head.data(), std::ssize(head));
  if (!std::string_view(head.data(), head.size()).starts_with("MATLAB 5.0")) return true;
  const bool swapped = head[126] == 'M';  // "IM" is little endian
  while (at < size) {
    std::array<unsigned char, 8> tag{};
    in.seekg(static_cast<std::streamoff>(at));
    if (!in.read(reinterpret_cast<char*>(tag.data()), std::ssize(tag))) return false;
    std::uint64_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      length |= std::uint64_t{tag[4 + i]} << (8 * (swapped ? 3 - i : i));
    }
    at += 8 + length;
  }
  return at == size;
}

class MatlabFile {
 public:
  explicit MatlabFile(const fs::path& path) : path_(path) {
    complained = false;
    Mat_LogInitFunc("ertbench", [](int, char*) { complained = true; });
    if (!is_whole(path)) fail("", "is cut off or damaged; save it again in MATLAB or Octave");
    file_.reset(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
    if (!file_) fail("", "is damaged; save it again in MATLAB or Octave");
    std::size_t count = 0;
    char* const* const names = Mat_GetDir(file_.get(), &count);
    for (std::size_t i = 0; names && i < count; ++i) {
      if (names[i]) names_.emplace_back(names[i]);
    }
    if (names_.empty()) fail("", "is damaged, or holds no variables; save it again");
  }

  const std::vector<std::string>& names() const { return names_; }
  /// Whether there is a variable, or a struct with the field "session/voltages".
  bool has(const std::string& name) const {
    const std::string first = name.substr(0, name.find('/'));
    if (std::ranges::find(names_, first) == names_.end()) return false;
    if (first == name) return true;
    const Variable whole(Mat_VarRead(file_.get(), first.c_str()));
    const std::string field = name.substr(first.size() + 1);
    return whole && whole->class_type == MAT_C_STRUCT &&
           Mat_VarGetStructFieldByName(whole.get(), field.c_str(), 0);
  }
  std::string list() const {
    return joined(names_, ", ", [](const std::string& name) { return printable(name); });
  }

  struct Matrix {
    RowMajorMatrix rows;  ///< the first dimension, the others flattened with the last one fastest
    std::vector<std::uint64_t> shape;
    bool is_complex = false;
    bool is_eidors = false;  ///< frames are columns
  };

  /// The numbers of a variable, or of a field, "session/voltages".
  Matrix matrix(const std::string& name, bool may_lack_values = false) const {
    const std::size_t slash = name.find('/');
    const Variable whole(Mat_VarRead(file_.get(), name.substr(0, slash).c_str()));
    if (!whole) fail(name, "is missing or damaged; the file holds " + list());
    matvar_t* variable = whole.get();
    Matrix out;
    std::string rest = slash == std::string::npos ? "" : name.substr(slash + 1);
    while (variable->class_type == MAT_C_STRUCT) {
      // EIDORS keeps the voltages of a data object in its field "meas".
      out.is_eidors = rest.empty();
      const std::string field = rest.empty() ? "meas" : rest.substr(0, rest.find('/'));
      rest = rest.find('/') == std::string::npos ? "" : rest.substr(rest.find('/') + 1);
      std::string has;
      char* const* const names = Mat_VarGetStructFieldnames(variable);
      for (unsigned i = 0; names && i < Mat_VarGetNumberOfFields(variable); ++i) {
        has += (i > 0 ? ", " : "") + printable(names[i]);
      }
      matvar_t* const next = Mat_VarGetStructFieldByName(variable, field.c_str(), 0);
      if (!next) fail(name, "has no field " + field + "; name one by --dataset: " + has);
      variable = next;
    }
    read(*variable, name, out);
    if (!may_lack_values && !out.rows.allFinite())
      fail(name, "holds values that are not finite; leave such frames out");
    return out;
  }

  [[noreturn]] void fail(const std::string& name, const std::string& what) const {
    throw InputError(path_.string() + ": " + (name.empty() ? "" : printable(name) + ": ") + what);
  }

 private:
  void read(const matvar_t& variable, const std::string& name, Matrix& out) const {
    if (variable.class_type == MAT_C_CELL) fail(name, "is a cell array; save a matrix (cell2mat)");
    if (variable.rank < 2 || variable.rank > 3) fail(name, "must have two or three dimensions");
    std::size_t count = 1;
    for (int d = 0; d < variable.rank; ++d) {
      out.shape.push_back(variable.dims[d]);
      if (variable.dims[d] == 0 || variable.dims[d] > most_numbers / count) {
        fail(name, "is empty, or too large to be turned round in memory");
      }
      count *= variable.dims[d];
    }
    out.is_complex = variable.isComplex != 0;
    const void* data = variable.data;
    if (data && out.is_complex) data = static_cast<const mat_complex_split_t*>(data)->Re;
    if (complained || !data ||
        variable.nbytes < count * static_cast<std::size_t>(variable.data_size)) {
      fail(name, "is damaged; save it again");
    }
    constexpr std::pair<matio_classes, void (*)(const void*, std::size_t, std::vector<double>&)>
        readers[] = {
            {MAT_C_DOUBLE, read_numbers<double>},      {MAT_C_SINGLE, read_numbers<float>},
            {MAT_C_INT8, read_numbers<std::int8_t>},   {MAT_C_UINT8, read_numbers<std::uint8_t>},
            {MAT_C_INT16, read_numbers<std::int16_t>}, {MAT_C_UINT16, read_numbers<std::uint16_t>},
            {MAT_C_INT32, read_numbers<std::int32_t>}, {MAT_C_UINT32, read_numbers<std::uint32_t>}};
    std::vector<double> numbers;
    for (const auto& [type, read_all] : readers) {
      if (type == variable.class_type) read_all(data, count, numbers);
    }
    if (numbers.empty()) fail(name, "must hold numbers, double or single; save it so");
    const auto rows = static_cast<Eigen::Index>(out.shape[0]);
    const auto middle = static_cast<Eigen::Index>(out.shape[1]);
    const auto last = static_cast<Eigen::Index>(count) / rows / middle;
    out.rows.resize(rows, middle * last);
    for (Eigen::Index m = 0; m < last; ++m) {
      for (Eigen::Index d = 0; d < middle; ++d) {
        out.rows.col(d * last + m) =
            Eigen::Map<const Eigen::VectorXd>(numbers.data() + (m * middle + d) * rows, rows);
      }
    }
  }

  fs::path path_;
  std::unique_ptr<mat_t, CloseMat> file_;
  std::vector<std::string> names_;
};

class MatlabFrames final : public TableFrames {
 public:
  MatlabFrames(const fs::path& input, const FrameFileOptions& options) : TableFrames(input) {
    const MatlabFile file(path_);
    name_ = options.dataset.starts_with('/') ? options.dataset.substr(1) : options.dataset;
    if (name_.empty() && file.has("voltages")) name_ = "voltages";
    if (name_.empty() && file.has("vi") && file.has("vh")) name_ = "vi";
    if (name_.empty() && file.names().size() == 1) name_ = file.names().front();
    if (name_.empty()) file.fail("", "name the frames by --dataset, one of " + file.list());
    const std::string folder = name_.substr(0, name_.rfind('/') + 1);
    const std::string reference = name_ == "vi" ? "vh" : folder + "reference_voltages";
    MatlabFile::Matrix found = file.matrix(name_);
    const bool by_columns = options.transposed.value_or(found.is_eidors || name_ == "vi");
    const auto turn = [&](RowMajorMatrix& rows) {
      if (by_columns || (rows.cols() == 1 && rows.rows() > 1)) rows.transposeInPlace();
    };
    turn(found.rows);
    rows_ = std::move(found.rows);
    is_complex_ = found.is_complex;
    if (!by_columns && found.shape.size() == 3) frame_shape_ = {found.shape[1], found.shape[2]};
    if (!file.has(reference)) return;
    reference_ = file.matrix(reference).rows;
    turn(reference_);
  }

  std::string format() const override { return "MATLAB"; }
  std::string dataset() const override { return name_; }
  std::vector<std::uint64_t> frame_shape() const override { return frame_shape_; }
  RowMajorMatrix reference() const override { return reference_; }
  std::vector<std::string> notes() const override {
    if (!is_complex_) return {};
    return {"the values are complex: their part in phase is taken"};
  }

 private:
  std::string name_;
  bool is_complex_ = false;
  std::vector<std::uint64_t> frame_shape_;
  RowMajorMatrix reference_;
};

}  // namespace

std::unique_ptr<FrameSource> open_matlab_frames(const fs::path& input,
                                                const FrameFileOptions& options) {
  return std::make_unique<MatlabFrames>(input, options);
}

RowMajorMatrix read_matlab_matrix(const fs::path& file, const std::string& name) {
  return MatlabFile(file).matrix(name, true).rows;
}

}  // namespace ertbench
