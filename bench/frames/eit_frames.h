#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "bench/frames/frame_source.h"

namespace ertbench {

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
