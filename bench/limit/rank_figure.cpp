#include "bench/limit/rank_figure.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "bench/limit/limit_json.h"
#include "bench/plot/drawing.h"
#include "bench/plot/panel.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr int histogram_bins = 10;

/// Frames of a bin by a flat distribution, within two standard deviations.
Span flat_counts(std::size_t frames) {
  const double mean = static_cast<double>(frames) / histogram_bins;
  const double deviation = std::sqrt(mean * (1 - 1.0 / histogram_bins));
  return {mean - 2 * deviation, mean + 2 * deviation};
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
      std::array<double, histogram_bins> counts{};
      for (const FrameLimit& frame : frames) {
        const double bin = std::clamp(frame.ranks[r] * histogram_bins, 0.0, histogram_bins - 1e-9);
        counts[static_cast<std::size_t>(bin)] += 1;
      }
      std::vector<Bar> bars;
      for (int b = 0; b < histogram_bins; ++b) {
        bars.push_back({(b + 0.5) / histogram_bins, counts[static_cast<std::size_t>(b)],
                        hue(0).towards_white(0.3)});
      }
      const Span flat = flat_counts(frames.size());
      const double most = std::max(*std::max_element(counts.begin(), counts.end()), flat.high);
      const auto& p = calibration.p_values[r];
      Panel panel(canvas, box, Axis::even({0, 1}, "rank of the truth"),
                  Axis::even({0, 1.1 * most}));
      panel.title(std::string(names[r]) + (p ? ", p = " + fixed(*p, 2) : ""));
      panel.bars(bars, 0.9 / histogram_bins);
      panel.level(flat.low, {rgb(0x606060), 1, 3});
      panel.level(flat.high, {rgb(0x606060), 1, 3});
      panel.draw();
    }
  }
  canvas.draw(stem);
}

}  // namespace ertbench
