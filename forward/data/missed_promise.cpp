#include "forward/data/missed_promise.h"

#include <algorithm>
#include <cstdio>

#include "forward/data/dataset_file.h"

namespace ertbench {

std::string MissedPromise::sentence() const {
  if (scenes == 0) return "";
  char text[256];
  std::snprintf(text, sizeof text,
                "%llu of %llu scenes %s voltages whose estimated error is above %g of the noise%s, "
                "at most %.2g V",
                static_cast<unsigned long long>(scenes), static_cast<unsigned long long>(of),
                scenes == 1 ? "has" : "have", model_error, is_noisy ? "" : " of 80 dB",
                largest_error);
  return text;
}

MissedPromise missed_promise(const DatasetSpec& spec, const DatasetFile& file) {
  constexpr std::uint64_t rows_at_once = 4096;
  constexpr double rounding = 1 + 1e-9;
  MissedPromise out{.of = file.size(),
                    .model_error = model_error_of(spec.model),
                    .is_noisy = spec.noise.snr_db.has_value()};
  for (std::uint64_t first = 0; first < file.size(); first += rows_at_once) {
    const std::uint64_t count = std::min(rows_at_once, file.size() - first);
    const Eigen::VectorXd errors = file.model_errors(first, count);
    if (errors.size() == 0) break;
    const Frames clean = file.clean_voltages(first, count);
    for (Eigen::Index i = 0; i < errors.size(); ++i) {
      const double allowed =
          out.model_error * noise_norm(spec.noise, file.reference_voltages(), clean.row(i));
      if (errors[i] <= rounding * allowed) continue;
      ++out.scenes;
      out.largest_error = std::max(out.largest_error, errors[i]);
    }
  }
  return out;
}

}  // namespace ertbench
