// Times frames from the voltages to the contacts, under SCHED_FIFO where that is permitted, and
// writes percentiles and a histogram.
//
//     latency SOLVER.ert [FRAMES]
#include <sched.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <random>
#include <vector>

#include "runtime/runtime.h"

using namespace ertbench::runtime;
using Clock = std::chrono::steady_clock;

int main(int count, char** words) try {
  if (count < 2) return std::fprintf(stderr, "usage: latency SOLVER.ert [FRAMES]\n"), 2;
  const std::size_t frames = count > 2 ? std::strtoull(words[2], nullptr, 10) : 1000000;
  Solver solver = Solver::load(words[1]);
  const auto channels = static_cast<std::size_t>(solver.channels());
  const auto pixels = static_cast<std::size_t>(solver.rows() * solver.columns());
  const sched_param highest{sched_get_priority_max(SCHED_FIFO)};
  const bool is_fifo = sched_setscheduler(0, SCHED_FIFO, &highest) == 0;

  // A thousand frames of noise: the time of an image does not depend on them, that of its contacts
  // is longest where nearly all pixels are above the threshold.
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0, 1e-3F);
  std::vector<float> all(1000 * channels);
  for (float& voltage : all) voltage = noise(random);
  solver.set_reference(std::vector<float>(channels, 0.0F));
  std::vector<float> image(pixels);
  std::array<Contact, 8> contacts;
  std::vector<double> us(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    const Clock::time_point begin = Clock::now();
    solver.reconstruct({&all[i % 1000 * channels], channels}, image);
    solver.contacts(image, contacts);
    us[i] = std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
  }
  std::sort(us.begin(), us.end());
  const auto share = [&](double s) {
    return us[static_cast<std::size_t>(s * (double(frames) - 1))];
  };
  std::printf(
      "%s, %zu frames, voltages to contacts%s: p50 %.1f, p99 %.1f, p99.9 %.1f, most %.1f us\n",
      solver.name().c_str(), frames, is_fifo ? ", SCHED_FIFO" : "", share(0.5), share(0.99),
      share(0.999), us.back());
  for (double from = us.front(); from <= us.back(); from *= 1.25) {
    const auto in = std::lower_bound(us.begin(), us.end(), 1.25 * from) -
                    std::lower_bound(us.begin(), us.end(), from);
    const double stars = in > 0 ? 6 * std::log10(double(in)) + 1 : 0;
    std::printf("%9.1f us %9td %s\n", from, in, std::string(std::size_t(stars), '*').c_str());
  }
} catch (const std::exception& error) {
  return std::fprintf(stderr, "latency: %s\n", error.what()), 2;
}
