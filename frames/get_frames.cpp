// Recordings of the Goe-MF II and its relatives (Viasys, CareFusion), ".get" files.
//
// Without a header: frames of 256 float32, little endian. Values 0 to 207 are the voltages of 16
// electrodes with adjacent drive and measurement, drive by drive, measurements from the pair behind
// the drive on (k + 2, ..., k + 14); 208 to 223 the currents and 224 to 239 the voltages of the
// driven pairs, in units of the instrument; the rest is auxiliary. So EIDORS reads them
// (eidors_readdata.m, mceit_readdata; A. Adler, 2005).

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/errors.h"
#include "frames/frame_source.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr Eigen::Index frame_values = 256;
constexpr int get_electrodes = 16;
constexpr int measured_pairs = get_electrodes - 3;
constexpr Eigen::Index voltages = get_electrodes * measured_pairs;

class GetFrames final : public TableFrames {
 public:
  GetFrames(const fs::path& input, const FrameFileOptions& options) : TableFrames(input) {
    if (!options.dataset.empty() || options.transposed.value_or(false)) {
      throw InputError(path_.string() +
                       ": is a .get recording; leave --dataset and --transposed out");
    }
    rows_ = parse_get(text_of_file(path_), path_.string());
  }

  std::string format() const override { return "get"; }
  std::vector<ChannelElectrodes> channels() const override {
    std::vector<ChannelElectrodes> out;
    if (columns() == frame_values) return out;  // the order "full"
    for (int d = 0; d < get_electrodes; ++d) {
      for (int k = 0; k < measured_pairs; ++k) {
        const int m = (d + 2 + k) % get_electrodes;
        out.push_back({{d, (d + 1) % get_electrodes}, {m, (m + 1) % get_electrodes}});
      }
    }
    return out;
  }
  std::vector<std::string> notes() const override {
    return {"the numbers of .get files are the instrument's, no volts: --fix finds their level"};
  }
};

}  // namespace

RowMajorMatrix parse_get(std::string_view bytes, const std::string& source) {
  static_assert(std::endian::native == std::endian::little);
  constexpr std::size_t frame_bytes = frame_values * sizeof(float);
  if (bytes.empty() || bytes.size() % frame_bytes != 0) {
    throw InputError(source + ": has " + std::to_string(bytes.size()) +
                     " bytes, frames of a .get recording have " + std::to_string(frame_bytes) +
                     " each; it is cut off, or of another instrument");
  }
  RowMajorMatrix rows(static_cast<Eigen::Index>(bytes.size() / frame_bytes), frame_values);
  bool is_map = true;
  for (Eigen::Index f = 0; f < rows.rows(); ++f) {
    std::array<float, frame_values> frame{};
    std::memcpy(frame.data(), bytes.data() + static_cast<std::size_t>(f) * frame_bytes,
                frame_bytes);
    for (Eigen::Index c = 0; c < frame_values; ++c) {
      const float value = frame[static_cast<std::size_t>(c)];
      const auto apart = (c - c / get_electrodes + 1 + get_electrodes) % get_electrodes;
      is_map = is_map && (apart > 2 || value == 0);
      if (c < voltages && !(std::abs(value) < 1e9F)) {
        throw InputError(source + ": frame " + std::to_string(f) + ", value " + std::to_string(c) +
                         ": is no voltage; the file is damaged, or no .get recording");
      }
      rows(f, c) = value;
    }
  }
  if (is_map) return rows;
  return rows.leftCols(voltages);
}

std::unique_ptr<FrameSource> open_get_frames(const fs::path& input,
                                             const FrameFileOptions& options) {
  return std::make_unique<GetFrames>(input, options);
}

}  // namespace ertbench
