#pragma once

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "forward/sheet/sensor.h"

namespace ertbench::testing {

/// A disc of radius 1 with point electrodes in closed form, which shares nothing with the models:
/// the Neumann function on its border is -ln|z - e| / pi, and a small inclusion polarises in the
/// uniform sheet's field (first order in its area).
struct ClosedFormDisc {
  struct Inclusion {
    std::complex<double> place;
    double radius = 0.1;
    double ratio = 0.5;  ///< its conductivity over the sheet's
  };

  std::vector<std::complex<double>> electrodes;
  double current = 1;
  double conductivity = 1;

  /// `count` electrodes from `start` degrees, 0 at 3 o'clock and 90 at the top.
  ClosedFormDisc(int count, double start, bool clockwise) {
    for (int e = 0; e < count; ++e) {
      const double turn = (clockwise ? -360.0 : 360.0) * e / count;
      electrodes.push_back(std::polar(1.0, (start + turn) * std::numbers::pi / 180));
    }
  }

  double potential(int at, int source) const { return -std::log(std::abs(of(at) - of(source))); }
  std::complex<double> field(std::complex<double> z, const ElectrodePair& pair) const {
    const auto one = [&](int e) { return -1.0 / std::conj(z - of(e)); };
    return one(pair.second) - one(pair.first);
  }

  /// Volts of a channel, its drive -I into the first and +I into the second electrode.
  double voltage(const ChannelElectrodes& channel, const std::vector<Inclusion>& all = {}) const {
    const auto& [d, m] = channel;
    const double scale = current / (std::numbers::pi * conductivity);
    double volts = scale * (potential(m.first, d.second) - potential(m.first, d.first) -
                            potential(m.second, d.second) + potential(m.second, d.first));
    for (const Inclusion& one : all) {
      const double strength = 2 * (one.ratio - 1) / (one.ratio + 1) * one.radius * one.radius;
      // The measuring pair's field is that of a current from its second to its first electrode.
      volts += scale * strength * (field(one.place, d) * std::conj(field(one.place, m))).real();
    }
    return volts;
  }

 private:
  std::complex<double> of(int e) const { return electrodes[static_cast<std::size_t>(e)]; }
};

}  // namespace ertbench::testing
