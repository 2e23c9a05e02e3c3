#pragma once

#include <cmath>
#include <cstdint>

#include "forward/border/border_model.h"
#include "forward/data/faults.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

// Frames of the exact model for the tests of contacts.
namespace ertbench::testing {

inline Contact disc(double x, double y, double radius, double ratio) {
  Contact contact;
  contact.centre = {x, y};
  contact.half_size = {radius, radius};
  contact.conductivity_ratio = ratio;
  return contact;
}

inline Contact ellipse(double x, double y, double a, double b, double angle, double ratio) {
  Contact contact = disc(x, y, a, ratio);
  contact.shape = Shape::ellipse;
  contact.half_size = {a, b};
  contact.angle = angle;
  return contact;
}

inline double noise_at(double snr_db) {
  const Eigen::VectorXd reference = BorderModel(Sensor{}).reference_voltages();
  return reference.norm() * std::pow(10, -snr_db / 20) /
         std::sqrt(static_cast<double>(reference.size()));
}

/// Changes of one frame of the exact model; with noise where `number` is not 0.
inline Frames frame_of(const Scene& scene, double snr_db, std::uint64_t number) {
  const BorderModel model{Sensor{}};
  const double fine = 1e-3 * noise_at(snr_db);
  Eigen::VectorXd voltages = model.reference_voltages() + model.solve(scene, fine).change;
  if (number > 0) {
    RandomStream random(number, key_of("contacts"), 0, Purpose::noise);
    add_noise({snr_db, SnrBasis::absolute}, model.reference_voltages(), random, voltages);
  }
  return (voltages - model.reference_voltages()).transpose();
}

/// Means of the reciprocal pairs of a frame of changes, as ContactFit takes them.
inline Eigen::VectorXd pair_means(const Frames& frame) {
  const auto pairs = reciprocal_pairs(Sensor{});
  Eigen::VectorXd out(static_cast<Eigen::Index>(pairs.size()));
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    out[static_cast<Eigen::Index>(p)] = (frame(0, pairs[p][0]) + frame(0, pairs[p][1])) / 2;
  }
  return out;
}

}  // namespace ertbench::testing
