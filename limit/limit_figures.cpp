#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bench/plot/canvas.h"
#include "bench/plot/image_panel.h"
#include "bench/plot/panel.h"
#include "core/statistics.h"
#include "core/text.h"
#include "forward/border/border_model.h"
#include "forward/border/contact_electrodes.h"
#include "limit/limit_run.h"

namespace ertbench {
namespace {

/// Frames per bin for a flat distribution: its mean plus and minus two standard deviations.
Span flat_counts(std::size_t frames) {
  const double mean = static_cast<double>(frames) / rank_bins;
  const double deviation = std::sqrt(mean * (1 - 1.0 / rank_bins));
  return {mean - 2 * deviation, mean + 2 * deviation};
}

constexpr double bound_resolution = 4;  ///< of the border model
constexpr double map_side = 200;        ///< px
constexpr double map_gap = 30;
constexpr double map_left = 50;
constexpr double map_top = 74;

std::vector<double> finite_values(const Eigen::RowVectorXd& values) {
  std::vector<double> out;
  for (const double value : values) {
    if (std::isfinite(value)) out.push_back(value);
  }
  return out;
}

/// Scale from zero to the 90 % quantile of the worst map.
ColourScale scale_of(const std::vector<BoundMap>& maps, Eigen::RowVectorXd BoundMap::*quantity) {
  double high = 0;
  for (const BoundMap& map : maps) {
    const SortedValues sorted(finite_values(map.*quantity));
    high = std::max(high, interpolated_quantile(sorted, 0.9));
  }
  const double step = round_step(high, 5);
  return {0, step * std::ceil(high / step), step, false, true};
}

/// Draws medians over the sheet against the signal-to-noise ratio, one line for each map.
void draw_medians(Canvas& canvas, const Box& box, const std::vector<BoundMap>& maps,
                  Eigen::RowVectorXd BoundMap::*quantity, const std::string& title) {
  constexpr std::array<double, 5> snr_db = {40, 50, 60, 70, 80};
  Span span;
  std::vector<Points> lines;
  for (const BoundMap& map : maps) {
    const double middle = median(SortedValues(finite_values(map.*quantity)));
    Points& line = lines.emplace_back();
    for (const double db : snr_db) {
      line.emplace_back(db, middle * std::pow(10, (bound_map_db - db) / 20));
      span.extend(line.back().second);
    }
  }
  Panel panel(canvas, box, Axis::even({38, 82}, "signal-to-noise ratio (dB)"),
              Axis::logarithms({span.low / 1.3, span.high * 1.3}, title));
  panel.title("median over the sheet");
  for (std::size_t i = 0; i < lines.size(); ++i) {
    panel.line(lines[i], {hue(i), 1.6});
    panel.marks(lines[i], {filled(i), hue(i)});
  }
  panel.draw();
}

}  // namespace

void draw_rank_figure(std::span<const SetLimit> limits, const std::string& title,
                      const std::filesystem::path& stem) {
  constexpr std::array<const char*, limit_ranks.size()> names = {
      "sum of δσ", "x of the centroid", "y of the centroid", "norm of δσ", "number of contacts"};
  std::vector<const SetLimit*> shown;
  for (const SetLimit& limit : limits) {
    if (limit.prior == "oracle") shown.push_back(&limit);
  }
  constexpr double side = 150;
  constexpr double row_height = 240;
  Canvas canvas(70 + limit_ranks.size() * (side + 45.0),
                70 + row_height * static_cast<double>(shown.size()));
  canvas.title(title);
  for (std::size_t s = 0; s < shown.size(); ++s) {
    const std::vector<FrameLimit>& frames = shown[s]->frames;
    const LimitCalibration calibration = calibration_of(frames);
    const double top = 90 + row_height * static_cast<double>(s);
    canvas.text(shown[s]->dataset + ", " + std::to_string(frames.size()) +
                    " frames; squared error over posterior variance " +
                    fixed(calibration.squared_error_over_variance, 2) + " [" +
                    fixed(calibration.ci95.low, 2) + ", " + fixed(calibration.ci95.high, 2) + "]",
                60, top - 36, {.size = 11, .align = TextAlign::left});
    canvas.text("frames", 22, top + (side - 20) / 2, {.size = 11, .upright = true});
    for (std::size_t r = 0; r < limit_ranks.size(); ++r) {
      const Box box = Box::sized(60 + static_cast<double>(r) * (side + 45), top, side, side - 20);
      if (!is_ranked(frames, r)) {
        canvas.text(names[r], box.middle(), box.top - 12, {.size = 11});
        canvas.lines("the same in all samples", characters_in(box.width(), 10), box.middle(),
                     box.centre(), {.size = 10, .colour = ink::note});
        continue;
      }
      const std::array<double, rank_bins> counts = rank_counts(frames, r);
      std::vector<Bar> bars;
      for (int b = 0; b < rank_bins; ++b) {
        bars.push_back({(b + 0.5) / rank_bins, counts[static_cast<std::size_t>(b)],
                        hue(0).towards_white(0.3)});
      }
      const Span flat = flat_counts(frames.size());
      const double most = std::max(*std::ranges::max_element(counts), flat.high);
      const auto& p = calibration.p_values[r];
      Panel panel(canvas, box, Axis::even({0, 1}, "rank of the truth"),
                  Axis::even({0, 1.1 * most}));
      panel.title(std::string(names[r]) + (p ? ", p = " + fixed(*p, 2) : ""));
      panel.bars(bars, 0.9 / rank_bins);
      panel.level(flat.low, {rgb(0x606060), 1, 3});
      panel.level(flat.high, {rgb(0x606060), 1, 3});
      panel.draw();
    }
  }
  canvas.draw(stem);
}

BoundMap bound_map(const Sensor& sensor, double radius, double ratio) {
  const BorderModel model(sensor);
  const double noise = model.reference_voltages().norm() * std::pow(10, -bound_map_db / 20) /
                       std::sqrt(static_cast<double>(sensor.channels()));
  const PixelGrid places = sensor.image();
  BoundMap map{sensor, {}, {}};
  map.place_mm.setConstant(places.count(), std::numeric_limits<double>::quiet_NaN());
  map.radius_mm = map.place_mm;
  for (int p = 0; p < places.count(); ++p) {
    Contact disc;
    disc.centre = places.centre(p);
    disc.half_size.setConstant(radius);
    disc.conductivity_ratio = ratio;
    if (sensor.sheet->depth(disc.centre) <= radius) continue;
    const Scene scene{{disc}};
    const RowMajorMatrix all = model.linearise(scene, bound_resolution).derivatives;
    Eigen::MatrixX4d jacobian(all.rows(), 4);
    jacobian << all.col(ContactMotion::x), all.col(ContactMotion::y),
        all.col(ContactMotion::growth) / radius, all.col(ContactMotion::log_ratio) / ratio;
    const Eigen::Matrix4d covariance =
        (jacobian.transpose() * jacobian).inverse() * (noise * noise);
    const double unit = sensor.sheet->unit_mm();
    map.place_mm[p] = unit * std::sqrt(covariance(0, 0) + covariance(1, 1));
    map.radius_mm[p] = unit * std::sqrt(covariance(2, 2));
  }
  return map;
}

void draw_bound_maps(const std::vector<BoundMap>& maps, const std::string& title,
                     const std::filesystem::path& stem) {
  const double right = map_left + static_cast<double>(maps.size()) * (map_side + map_gap);
  const double chart_left = right + 120;
  const double width = chart_left + 250;
  const double row_height = map_side + 66;
  Canvas canvas(width, map_top + 2 * row_height + 10);
  canvas.title(title);
  const auto row = [&](int number, Eigen::RowVectorXd BoundMap::*quantity,
                       const std::string& name) {
    const double top = map_top + number * row_height;
    const ColourScale scale = scale_of(maps, quantity);
    for (std::size_t i = 0; i < maps.size(); ++i) {
      const Box box = Box::sized(map_left + static_cast<double>(i) * (map_side + map_gap), top,
                                 map_side, map_side);
      ImagePanels panels(canvas, maps[i].sensor, scale);
      panels.image(box, maps[i].*quantity, "");
      canvas.text(std::to_string(maps[i].sensor.electrode_count) + " electrodes, " +
                      fixed(bound_map_db, 0) + " dB: median " +
                      three_digits(median(SortedValues(finite_values(maps[i].*quantity)))) + " mm",
                  box.middle(), top - 12, {.size = 10, .align = TextAlign::centre});
      if (i + 1 == maps.size()) {
        panels.colour_bar(Box::sized(right, top, ImagePanels::bar_width, map_side), name);
      }
    }
    draw_medians(canvas, Box::sized(chart_left + 30, top, 200, map_side - 30), maps, quantity,
                 name);
  };
  row(0, &BoundMap::place_mm, "rms error of the place (mm)");
  row(1, &BoundMap::radius_mm, "rms error of the radius (mm)");
  Legend legend(chart_left + 20, width);
  for (std::size_t i = 0; i < maps.size(); ++i) {
    legend.add({std::to_string(maps[i].sensor.electrode_count), LineStyle{hue(i), 1.6},
                MarkStyle{filled(i), hue(i)}});
  }
  legend.draw(canvas, 46);
  canvas.draw(stem);
}

}  // namespace ertbench
