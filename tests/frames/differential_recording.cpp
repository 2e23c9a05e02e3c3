#include <fstream>

#include "core/hdf5_file.h"
#include "tests/frames/differential.h"
#include "tests/frames/frames_testing.h"

namespace ertbench::differential {

namespace fs = std::filesystem;

namespace {

constexpr double noise_of_reference = 3e-4;  ///< 70 dB

/// Discs whose images by one-step Gauss-Newton lie within millimetres of them.
std::vector<Contact> discs_of(unsigned seed) {
  Random random(seed);
  std::uniform_real_distribution<double> place(-0.45, 0.45);
  std::uniform_real_distribution<double> radius(0.2, 0.28);
  std::uniform_real_distribution<double> ratio(0.3, 0.6);
  std::vector<Contact> out;
  for (Eigen::Index i = 0; i < touched_frames; ++i) {
    Eigen::Vector2d centre(place(random), place(random));
    out.push_back(
        testing::disc_at(centre.x(), centre.y(), radius(random), ratio(random)).contacts.front());
  }
  return out;
}

}  // namespace

std::vector<Eigen::Vector2d> places_of(unsigned seed) {
  std::vector<Eigen::Vector2d> out;
  for (const Contact& disc : discs_of(seed)) out.emplace_back(100 * disc.centre);
  return out;
}

Recording sound_recording(Reader reader, unsigned seed) {
  Recording out;
  out.reader = reader;
  Random random(seed + 1000);
  const BorderModel model(out.sensor);
  const Eigen::RowVectorXd reference =
      testing::reference_with_gains(out.sensor, random).transpose();
  const auto channels = static_cast<double>(reference.size());
  std::normal_distribution<double> noise(
      0, noise_of_reference * reference.norm() / std::sqrt(channels));
  out.frames = reference.replicate(quiet_frames + touched_frames, 1);
  const std::vector<Contact> discs = discs_of(seed);
  for (std::size_t i = 0; i < discs.size(); ++i) {
    out.frames.row(quiet_frames + static_cast<Eigen::Index>(i)) +=
        model.solve_at({{discs[i]}}, 1).change.transpose();
  }
  for (double& v : out.frames.reshaped()) v += noise(random);
  for (int f = 0; f < out.frames.rows(); ++f) out.sound.push_back(f);
  if (reader == Reader::hdf5) {
    out.reference = reference;
  } else {
    out.options = " --background 0-" + std::to_string(quiet_frames - 1);
  }
  return out;
}

namespace {

std::string number_of(const Recording& recording, double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", recording.digits, value);
  std::string out = text;
  if (const auto point = out.find('.'); point != std::string::npos) out[point] = recording.decimal;
  return out;
}

/// One file for each frame, with a potential for each electrode. The sensor's pairs are neighbours;
/// what it does not measure, beside the drive, is set to zero.
void write_eit(const Recording& recording, const fs::path& folder) {
  const auto drives = drive_pairs(recording.sensor);
  const std::vector<Channel> channels = channels_of(recording.sensor);
  const auto electrodes = static_cast<std::size_t>(recording.sensor.electrode_count);
  for (Eigen::Index f = 0; f < recording.frames.rows(); ++f) {
    std::ofstream out(folder / ("frame_" + std::to_string(f) + ".eit"));
    out << "9\nframes\n2026.01.01\n1000\n1000\n0\n1\n"
        << recording.sensor.drive_current << "\n50\n";
    for (std::size_t d = 0; d < drives.size(); ++d) {
      std::vector<double> steps(electrodes, 0);
      for (std::size_t c = 0; c < channels.size(); ++c) {
        if (channels[c].drive != static_cast<int>(d)) continue;
        steps[static_cast<std::size_t>(channels[c].measurement)] =
            recording.frames(f, static_cast<Eigen::Index>(c));
      }
      // Voltages are first minus second; the step behind the last electrode must close the ring,
      // and it is moved into the drive, which is not measured.
      const auto pairs = measurement_pairs(recording.sensor);
      std::vector<double> potentials(electrodes, 0);
      const auto begin = static_cast<std::size_t>(drives[d].second);
      for (std::size_t i = 0; i + 1 < electrodes; ++i) {
        const std::size_t here = (begin + i) % electrodes;
        const std::size_t next = (here + 1) % electrodes;
        for (std::size_t p = 0; p < pairs.size(); ++p) {
          const auto a = static_cast<std::size_t>(pairs[p].first);
          const auto b = static_cast<std::size_t>(pairs[p].second);
          if (a == here && b == next) potentials[next] = potentials[here] - steps[p];
          if (b == here && a == next) potentials[next] = potentials[here] + steps[p];
        }
      }
      out << drives[d].second + 1 << ' ' << drives[d].first + 1 << '\n';
      for (const double v : potentials) out << number_of(recording, v) << "\t0\t";
      out << '\n';
    }
  }
}

}  // namespace

std::string text_of(const Recording& recording) {
  std::string out = recording.before;
  const Frames frames = recording.turned ? Frames(recording.frames.transpose()) : recording.frames;
  for (Eigen::Index row = 0; row < frames.rows(); ++row) {
    std::string line = recording.line_begin;
    if (const auto at = line.find('#'); at != std::string::npos) {
      line.replace(at, 1, std::to_string(row));
    }
    for (Eigen::Index c = 0; c < frames.cols(); ++c) {
      line += (c > 0 ? recording.separator : "") + number_of(recording, frames(row, c));
    }
    out += line + recording.line_end + "\n";
  }
  return out;
}

std::string write(const Recording& recording, const fs::path& folder) {
  if (recording.reader == Reader::eit) {
    fs::create_directory(folder / "frames");
    write_eit(recording, folder / "frames");
    return "frames";
  }
  if (recording.reader == Reader::text) {
    std::ofstream(folder / "frames.csv") << text_of(recording);
    return "frames.csv";
  }
  Hdf5File out = Hdf5File::create(folder / "frames.h5");
  const RowMajorMatrix frames =
      recording.turned ? RowMajorMatrix(recording.frames.transpose()) : recording.frames;
  std::vector<std::uint64_t> shape = recording.shape;
  if (shape.empty()) {
    shape = {static_cast<std::uint64_t>(frames.rows()), static_cast<std::uint64_t>(frames.cols())};
  }
  const auto type = recording.digits < 8 ? Hdf5File::Number::real32 : Hdf5File::Number::real64;
  out.create_dataset("/voltages", shape, type);
  const auto rows = static_cast<Eigen::Index>(shape[0]);
  out.write_rows("/voltages", 0, frames.reshaped<Eigen::RowMajor>(rows, frames.size() / rows));
  if (recording.reference.rows() == 1) {
    out.write_vector("/reference_voltages", recording.reference.transpose());
  } else if (recording.reference.rows() > 1) {
    out.write_matrix("/reference_voltages", recording.reference);
  }
  out.close();
  return "frames.h5";
}

}  // namespace ertbench::differential
