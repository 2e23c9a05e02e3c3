#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// How to read a file of frames.
struct FrameFileOptions {
  /// The dataset or variable of an HDF5 or MATLAB file, or the number, from 1, of a frequency of an
  /// `.eit` recording. Empty: the only one.
  std::string dataset;
  /// Whether frames are columns. Undeclared they are rows, and a square table is refused.
  std::optional<bool> transposed;
};

/// A current of an `.eit` recording, by electrodes counted from 0; it enters the sheet at `source`.
struct Injection {
  int source = 0;
  int sink = 0;

  bool operator==(const Injection&) const = default;
};

/// The frames of a file, one per row, with columns in the file's own order and unit.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  virtual std::string format() const = 0;  ///< "HDF5", "MATLAB v7.3", "Octave HDF5", "CSV", "eit"
  virtual std::string dataset() const { return {}; }  ///< empty for formats without datasets
  virtual std::uint64_t frames() const = 0;           ///< at least 1
  virtual Eigen::Index columns() const = 0;           ///< at least 1
  /// Extents of a frame that is stored as an array of two dimensions; empty for one dimension.
  virtual std::vector<std::uint64_t> frame_shape() const { return {}; }
  /// Rows [first, first + count) as [count, columns]. Throws InputError naming the place of a
  /// number that is not finite.
  virtual RowMajorMatrix read(std::uint64_t first, std::uint64_t count) const = 0;

  /// Reference voltages in the file: [1, columns] or one row for each frame; without rows if there
  /// are none. The number of columns is not checked.
  virtual RowMajorMatrix reference() const { return {}; }
  /// The sensor named in the file.
  virtual std::optional<Sensor> sensor() const { return std::nullopt; }
  /// The electrodes, counted from 0, of each column of a file that names them; `current` enters at
  /// the second electrode of a drive. Empty if it does not.
  virtual std::vector<ChannelElectrodes> channels() const { return {}; }
  /// For columns of potentials: the current of each run of columns, and the electrode, counted from
  /// 0, of each column of a run. Empty if columns are voltages of pairs.
  virtual std::vector<Injection> injections() const { return {}; }
  virtual std::vector<int> electrodes() const { return {}; }
  virtual std::optional<double> current() const { return std::nullopt; }  ///< A, if the file has it
  /// A dataset [n, 2] or [n, 3] of whole numbers, for channel orders in the same file.
  virtual RowMajorMatrix table(const std::string& name) const;
  /// All files that are read.
  virtual std::vector<std::filesystem::path> files() const = 0;
};

/// Opens a file of frames by its content: HDF5 (also MATLAB's v7.3 and Octave's), `.eit` text, a
/// folder of `.eit` files, otherwise CSV. Throws InputError naming the file and the remedy.
std::unique_ptr<FrameSource> open_frames(const std::filesystem::path& input,
                                         const FrameFileOptions& options);

/// A checksum of the files' bytes, in order (Checksum).
std::string checksum_of(const std::vector<std::filesystem::path>& files);

/// Size limit of a text file of frames, which is held in memory.
inline constexpr std::uint64_t most_text_bytes = std::uint64_t{1} << 30U;

/// Reads a text file. Throws InputError if it is no regular file or has more than most_text_bytes.
std::string text_of_file(const std::filesystem::path& file);

/// Opens a text file with one frame per line: numbers with a decimal point, separated by commas,
/// semicolons, tabs or blanks. Empty lines, those that begin with "#" and a first line of titles
/// (is_title_line) are skipped. Throws InputError with line and column for fields that are no
/// finite numbers and for lines of different lengths.
std::unique_ptr<FrameSource> open_csv_frames(const std::filesystem::path& input,
                                             const FrameFileOptions& options);

/// Whether a line can only be column titles: none of its fields is a number, or they count the
/// columns from 0 on, as pandas writes them.
bool is_title_line(std::string_view line);

/// The numbers of such a text, [lines, columns]; `source` names it in messages.
RowMajorMatrix numbers_of_text(std::string_view text, const std::string& source);

/// Opens an HDF5 file: `/voltages` or the dataset that the options name, [N, columns] or [N,
/// drives, measurements] (the last two flattened, drive by drive), with `/reference_voltages` if
/// present.
///
/// MATLAB (v7.3) and Octave (`save -hdf5`) store arrays with the first index fastest, so their
/// dimensions are reversed in the file; they are transposed back. A variable is a dataset in
/// MATLAB's files, a field of a struct one in a group ("/session/voltages"); cells and complex
/// numbers are refused with what to save instead. In Octave's a variable is a group with the
/// dataset "value".
std::unique_ptr<FrameSource> open_hdf5_frames(const std::filesystem::path& input,
                                              const FrameFileOptions& options, bool is_matlab);

/// One `.eit` text file of Sciospec's EIT instruments: one frame of complex potentials.
///
/// The first line is the number of lines of the header, itself counted: 9 in files without a
/// version, 11 or more, 18 today, in those whose second line is the version. Then follow the name,
/// date and time, the least and the largest frequency (Hz), 0 or 1 for a linear or a logarithmic
/// scale, the number of frequencies, the amplitude of the current (A) and the frames a second; and,
/// with more lines, the phase correction, gain, range of the converter, mode of the measurement and
/// two more, and two lists, "MeasurementChannels: 1,2,..." of the electrodes in use and
/// "MeasurementChannelsIndependentFromInjectionPattern: 1,2,..." of the columns that each line of
/// potentials has. After the header, for each injection, come a line of its two electrodes, the
/// current entering the sheet at the first, and for each frequency a line with real and imaginary
/// part of each electrode's potential against ground (V).
struct EitFile {
  int frequencies = 0;
  double current = 0;                 ///< A
  std::vector<int> electrodes;        ///< of each column, counted from 0
  std::vector<Injection> injections;  ///< electrodes counted from 0
  /// [injections, frequencies x columns]: in-phase and quadrature, V.
  RowMajorMatrix in_phase, quadrature;
};

/// Throws InputError with `source` and the line of what is wrong.
EitFile parse_eit(std::string_view text, const std::string& source);

/// The frames of one file or of a folder of them, in the order of the numbers in their names. The
/// columns are the in-phase potentials, injection by injection.
std::unique_ptr<FrameSource> open_eit_frames(const std::filesystem::path& input,
                                             const FrameFileOptions& options);

}  // namespace ertbench
