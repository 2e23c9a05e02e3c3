#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
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
  /// Rows [first, first + count) as [count, columns], NaN in columns without a number in any frame.
  /// Throws InputError naming the place of another number that is not finite.
  virtual RowMajorMatrix read(std::uint64_t first, std::uint64_t count) const = 0;

  /// Reference voltages in the file: [1, columns] or one row for each frame; without rows if there
  /// are none. The number of columns is not checked.
  virtual RowMajorMatrix reference() const { return {}; }
  /// The sensor named in the file.
  virtual std::optional<Sensor> sensor() const { return std::nullopt; }
  /// False if the background of that sensor is the one that fits the reference voltages.
  virtual bool knows_background() const { return true; }
  /// The electrodes, counted from 0, of each column of a file that names them; `current` enters at
  /// the second electrode of a drive. Empty if it does not.
  virtual std::vector<ChannelElectrodes> channels() const { return {}; }
  virtual std::string unit() const { return {}; }  ///< "V", "mV" or "uV", if the file says it
  /// What the reader took for granted or passed over, in sentences.
  virtual std::vector<std::string> notes() const { return {}; }
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

/// The frames of one file, which are held in memory.
class TableFrames : public FrameSource {
 public:
  explicit TableFrames(std::filesystem::path input) : path_(std::move(input)) {}

  std::uint64_t frames() const override { return static_cast<std::uint64_t>(rows_.rows()); }
  Eigen::Index columns() const override { return rows_.cols(); }
  RowMajorMatrix read(std::uint64_t first, std::uint64_t count) const override {
    return rows_.middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(count));
  }
  std::vector<std::filesystem::path> files() const override { return {path_}; }

 protected:
  std::filesystem::path path_;
  RowMajorMatrix rows_;  ///< [frames, columns]
};

/// Opens a file of frames by its content: HDF5 (also MATLAB's v7.3 and Octave's), MATLAB's older
/// files, `.get` recordings, BERT's unified format, `.eit` text, a folder of `.eit` files,
/// otherwise a table of text. Throws InputError naming the file and the remedy.
std::unique_ptr<FrameSource> open_frames(const std::filesystem::path& input,
                                         const FrameFileOptions& options);

bool is_hdf5_file(const std::filesystem::path& file);

/// Throws InputError at `place` for numbers that are not finite in `rows`, which begin with row
/// `first`, but for those that are NaN in `begin` [1, columns] as well, and for numbers there.
void require_same_missing(const RowMajorMatrix& rows, std::uint64_t first,
                          const RowMajorMatrix& begin, const std::string& place);

/// A checksum of the files' bytes, in order (Checksum).
std::string checksum_of(const std::vector<std::filesystem::path>& files);

/// Size limit of a text file of frames, which is held in memory.
inline constexpr std::uint64_t most_text_bytes = std::uint64_t{1} << 30U;

/// Reads a text file. Throws InputError if it is no regular file or has more than most_text_bytes.
std::string text_of_file(const std::filesystem::path& file);

/// Opens a text file with one frame per line: numbers separated by commas, semicolons, tabs or
/// blanks, with decimal commas where these separate nothing, complex ones as their part in phase.
/// Empty lines, those that begin with "#" or "%", words before the numbers and lines without
/// numbers before the first frame are passed over, and so are columns of times, counts and words.
/// Titles that name four electrodes give the channels (TitledColumns). Throws InputError with line
/// and column for other fields that are no finite numbers and for lines of different lengths;
/// what is missing in all lines of a column is NaN.
std::unique_ptr<FrameSource> open_csv_frames(const std::filesystem::path& input,
                                             const FrameFileOptions& options);

/// All numbers of such a text, [lines, columns]; `source` names it in messages.
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

/// Opens a MATLAB file of version 5 to 7 ("level 5"): `voltages` with `reference_voltages`,
/// EIDORS's `vi` with `vh` (frames are columns), the only variable, or the one that the options
/// name; a struct by its field, or by "meas" as EIDORS's data have it.
std::unique_ptr<FrameSource> open_matlab_frames(const std::filesystem::path& input,
                                                const FrameFileOptions& options);

/// Opens a ".get" recording of the Goe-MF II.
std::unique_ptr<FrameSource> open_get_frames(const std::filesystem::path& input,
                                             const FrameFileOptions& options);
/// The voltages of such bytes, [frames, 208], or [frames, 256] if they are maps of 16 x 16.
RowMajorMatrix parse_get(std::string_view bytes, const std::string& source);

/// One frame in the unified data format of BERT and pyGIMLi: the number of electrodes, a line "# x
/// y" (or "x z", or "x y z"), their places in metres; the number of data, a line of names, "# a b m
/// n r" with r = u / i in ohms, or u and i, or rhoa and k, and the data, electrodes counted from 1.
struct UnifiedFile {
  /// A disc or a rectangle with the electrodes on its border and these channels, driven by 1 A.
  Sensor sensor;
  std::vector<ChannelElectrodes> channels;
  /// [channels] V of 1 A. The format's current enters at a, in files of some programs at b: which
  /// is told by the electrodes' places, and the voltages are turned accordingly.
  std::vector<double> resistances;
};

/// Throws InputError with `source` and the line of what is wrong.
UnifiedFile parse_unified(std::string_view text, const std::string& source);
/// Whether a text begins as such a file does.
bool is_unified(std::string_view begin);
std::unique_ptr<FrameSource> open_unified_frames(const std::filesystem::path& input,
                                                 const FrameFileOptions& options);

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
  RowMajorMatrix in_phase;            ///< [injections, frequencies x columns] V
};

/// Throws InputError with `source` and the line of what is wrong.
EitFile parse_eit(std::string_view text, const std::string& source);

/// The frames of one file or of a folder of them, in the order of the numbers in their names. The
/// columns are the in-phase potentials, injection by injection.
std::unique_ptr<FrameSource> open_eit_frames(const std::filesystem::path& input,
                                             const FrameFileOptions& options);

/// The numbers of a variable of a MATLAB file (versions 5 to 7), which may be NaN. Throws
/// InputError naming file and variable.
RowMajorMatrix read_matlab_matrix(const std::filesystem::path& file, const std::string& name);

}  // namespace ertbench
