// Frames as text: a table of numbers, an instrument's .eit file, BERT's unified format, and the
// binary .get. What is accepted is finite and
// has one shape.

#include "frames/frame_source.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

/// Whether all numbers are finite but for columns without any.
bool is_finite(const ertbench::RowMajorMatrix& rows) {
  for (const auto& column : rows.colwise()) {
    if (!column.allFinite() && !column.array().isNaN().all()) return false;
  }
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ertbench;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  fuzzing::accepted("frames.csv", [&] {
    const RowMajorMatrix rows = numbers_of_text(text, "frames.csv");
    fuzzing::require(rows.size() > 0 && is_finite(rows), "a table without finite numbers");
  });
  const std::filesystem::path file = fuzzing::file_of(bytes, size, "frames.csv");
  fuzzing::accepted(file.string(), [&] {
    const auto frames = open_csv_frames(file, {});
    const RowMajorMatrix rows = frames->read(0, frames->frames());
    fuzzing::require(rows.size() > 0 && is_finite(rows) && rows.cols() == frames->columns(),
                     "frames without finite numbers");
    fuzzing::require(frames->channels().empty() || std::ssize(frames->channels()) == rows.cols(),
                     "channels that are not those of the columns");
  });
  fuzzing::accepted("frame.dat", [&] {
    const UnifiedFile unified = parse_unified(text, "frame.dat");
    fuzzing::require(
        static_cast<std::size_t>(unified.sensor.channels()) == unified.resistances.size(),
        "resistances of other channels");
  });
  fuzzing::accepted("frame.get", [&] {
    const RowMajorMatrix rows = parse_get(text, "frame.get");
    fuzzing::require(rows.size() > 0 && rows.leftCols(208).allFinite(), "no finite frames");
  });
  fuzzing::accepted("frame.eit", [&] {
    const EitFile eit = parse_eit(text, "frame.eit");
    const auto rows = static_cast<Eigen::Index>(eit.injections.size());
    const auto columns = static_cast<Eigen::Index>(eit.electrodes.size()) * eit.frequencies;
    fuzzing::require(
        eit.in_phase.rows() == rows && eit.in_phase.cols() == columns && eit.in_phase.allFinite(),
        "potentials of another shape than the header's");
  });
  return 0;
}
