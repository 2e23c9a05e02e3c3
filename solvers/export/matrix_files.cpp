#include "solvers/export/matrix_files.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/errors.h"
#include "core/text.h"
#include "forward/data/sheet_model.h"

namespace ertbench {
namespace {

/// `count` bytes of a number, the least significant one first.
std::string little_endian(std::uint64_t number, int count) {
  std::string out;
  for (int i = 0; i < count; ++i) out += static_cast<char>(number >> (8 * i) & 0xff);
  return out;
}

/// An array in NumPy's format, version 1.
std::string npy(const std::string& type, const std::string& shape, const std::string& bytes) {
  std::string header =
      "{'descr': '" + type + "', 'fortran_order': False, 'shape': " + shape + ", }";
  header.append(63 - (10 + header.size()) % 64, ' ');
  header += '\n';
  return std::string("\x93NUMPY\x01\x00", 8) + little_endian(header.size(), 2) + header + bytes;
}

std::uint32_t crc32(const std::string& bytes) {
  std::uint32_t crc = ~0U;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320U : 0);
  }
  return ~crc;
}

/// A zip archive of files as they are, not compressed.
std::string zip(const std::vector<std::pair<std::string, std::string>>& files) {
  std::string out;
  std::string directory;
  for (const auto& [name, bytes] : files) {
    const std::string common =
        little_endian(20, 2) + little_endian(0, 2) + little_endian(0, 2) + little_endian(0, 2) +
        little_endian(0x21, 2) + little_endian(crc32(bytes), 4) + little_endian(bytes.size(), 4) +
        little_endian(bytes.size(), 4) + little_endian(name.size(), 2) + little_endian(0, 2);
    directory += "PK\x01\x02" + little_endian(20, 2) + common + little_endian(0, 10) +
                 little_endian(out.size(), 4) + name;
    out += "PK\x03\x04" + common + name + bytes;
  }
  const std::string count = little_endian(files.size(), 2);
  return out + directory + "PK\x05\x06" + little_endian(0, 4) + count + count +
         little_endian(directory.size(), 4) + little_endian(out.size(), 4) + little_endian(0, 2);
}

bool is_linear(const ExportProgram& program) {
  const auto& steps = program.steps();
  return std::all_of(steps.begin(), steps.end(), [](const ExportStep& step) {
    const auto is_zero = [](float bias) { return bias == 0; };
    return step.kind == ExportStep::Kind::sums_of_pairs ||
           (step.kind == ExportStep::Kind::convolve && !step.relu &&
            std::all_of(step.bias.begin(), step.bias.end(), is_zero));
  });
}

template <typename Matrix>
std::string bytes_of(const Matrix& matrix) {
  return {reinterpret_cast<const char*>(matrix.data()),
          static_cast<std::size_t>(matrix.size()) * sizeof(typename Matrix::Scalar)};
}

}  // namespace

std::map<std::string, std::string> matrix_files(const ExportProgram& program, const Solver& solver,
                                                const Sensor& sensor, ExportPrecision precision) {
  if (!is_linear(program) || program.is_standardised()) {
    throw InputError("is no matrix; export it with --to c");
  }
  if (precision == ExportPrecision::int8) {
    throw InputError("a matrix is written in float32 or float16; int8 needs --to c");
  }
  const int channels = sensor.channels();
  // The images of unit changes are the columns.
  const Frames units = Frames::Identity(channels, channels);
  Images columns(channels, sensor.pixels());
  std::vector<FrameReport> reports(static_cast<std::size_t>(channels));
  solver.reconstruct(units, columns, reports);
  const FloatRows matrix = columns.transpose().cast<float>();
  const bool half = precision == ExportPrecision::float16;
  const std::string shape =
      "(" + std::to_string(sensor.pixels()) + ", " + std::to_string(channels) + ")";
  const auto halves = matrix.cast<Eigen::half>().eval();
  const std::string image = little_endian(static_cast<std::uint64_t>(sensor.image_rows()), 4) +
                            little_endian(static_cast<std::uint64_t>(sensor.image_columns()), 4);
  const Eigen::VectorXd reference = uniform_reference(sensor);
  TextStream csv;
  csv.precision(half ? 5 : 9);
  for (Eigen::Index p = 0; p < matrix.rows(); ++p) {
    for (Eigen::Index c = 0; c < channels; ++c) {
      csv << (c == 0 ? "" : ",") << (half ? static_cast<float>(halves(p, c)) : matrix(p, c));
    }
    csv << '\n';
  }
  return {
      {"matrix.csv", csv.str()},
      {"matrix.npz", zip({{"matrix.npy", half ? npy("<f2", shape, bytes_of(halves))
                                              : npy("<f4", shape, bytes_of(matrix))},
                          {"reference_voltages.npy",
                           npy("<f8", "(" + std::to_string(channels) + ",)", bytes_of(reference))},
                          {"image.npy", npy("<i4", "(2,)", image)}})}};
}

}  // namespace ertbench
