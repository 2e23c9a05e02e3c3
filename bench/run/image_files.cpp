#include "bench/run/image_files.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>

#include "bench/charts/images_figure.h"
#include "core/errors.h"
#include "core/hdf5_file.h"
#include "core/output_file.h"
#include "core/replace_file.h"
#include "forward/data/dataset_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view titles = "frame,status,reason,";
constexpr std::string_view png_signature = "\x89PNG\r\n\x1a\n";

bool begins_with(const fs::path& file, std::string_view text) {
  std::ifstream in(file, std::ios::binary);
  std::string begin(text.size(), '\0');
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return in && begin == text;
}

void append_number(std::string& text, double value) {
  char digits[32];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
  if (error == std::errc()) text.append(digits, end);
}

}  // namespace

void require_table_of_images(const fs::path& file, const std::vector<fs::path>& inputs) {
  require_output(file, inputs, {"table of images (CSV)", [](const fs::path& there) {
                                  return begins_with(there, titles);
                                }});
}

void require_picture(const fs::path& file, const std::vector<fs::path>& inputs) {
  if (file.extension() != ".png") {
    throw InputError("--png: must end in .png, got " + file.string());
  }
  require_output(file, inputs, {"picture (PNG)", [](const fs::path& there) {
                                  return begins_with(there, png_signature);
                                }});
  fs::path beside = file;
  beside.replace_extension(".svg");
  require_output(beside, inputs, {"picture (SVG)", [](const fs::path& there) {
                                    return begins_with(there, "<?xml") ||
                                           begins_with(there, "<svg");
                                  }});
}

void write_table_of_images(const fs::path& images, const fs::path& file) {
  const Hdf5File in = Hdf5File::open(images);
  const std::vector<std::uint64_t> shape = in.require_shape("/conductivity_change", {0, 0, 0});
  replace_file(file, [&](const fs::path& place) {
    std::ofstream out(place, std::ios::binary);
    std::string text(titles);
    for (std::uint64_t row = 0; row < shape[1]; ++row) {
      for (std::uint64_t column = 0; column < shape[2]; ++column) {
        if (row + column > 0) text += ',';
        text += 'r';
        append_number(text, static_cast<double>(row));
        text += 'c';
        append_number(text, static_cast<double>(column));
      }
    }
    text += '\n';
    for (std::uint64_t frame = 0; frame < shape[0]; ++frame) {
      const RowMajorMatrix image = in.read_rows("/conductivity_change", frame, 1, true);
      append_number(text, static_cast<double>(frame));
      for (const char* what : {"/status", "/reason"}) {
        text += ',';
        append_number(text, in.read_rows(what, frame, 1)(0, 0));
      }
      for (const double value : image.reshaped<Eigen::RowMajor>()) {
        text += ',';
        if (std::isfinite(value)) append_number(text, value);
      }
      text += '\n';
      out << text;
      text.clear();
    }
    out.close();
    if (!out) throw InputError(file.string() + ": cannot be written; is the disk full?");
  });
}

void draw_images(const fs::path& images, const std::vector<std::uint64_t>& frames,
                 const fs::path& file) {
  const Hdf5File in = Hdf5File::open(images);
  const std::uint64_t there = in.require_shape("/conductivity_change", {0, 0, 0})[0];
  std::vector<std::uint64_t> shown = frames;
  if (shown.empty()) {
    const std::uint64_t count = std::min<std::uint64_t>(there, most_pictured);
    for (std::uint64_t i = 0; i < count; ++i) {
      shown.push_back(count > 1 ? i * (there - 1) / (count - 1) : 0);
    }
  }
  const Sensor sensor = sensor_of(in);
  Images pictures(static_cast<Eigen::Index>(shown.size()), sensor.pixels());
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    if (shown[i] >= there) {
      throw InputError("--png-frames: there is no frame " + std::to_string(shown[i]) + "; the " +
                       std::to_string(there) + " frames are counted from 0");
    }
    pictures.row(static_cast<Eigen::Index>(i)) =
        in.read_rows("/conductivity_change", shown[i], 1, true).row(0);
    labels.push_back("frame " + std::to_string(shown[i]));
  }
  fs::path stem = file;
  stem.replace_extension();
  draw_images_figure(sensor, pictures, labels, stem);
}

}  // namespace ertbench
