#pragma once

#include <cstdint>
#include <vector>

#include "bench/ktc2023/ktc_files.h"
#include "core/random.h"

namespace ertbench {

/// Plastic or metal cylinders of round and polygonal section anywhere in the tank.
class SimulatedCylinders {
 public:
  SimulatedCylinders(RandomStream& random, std::size_t count);

  int kind_at(const Eigen::Vector2d& point) const;  ///< 0 water, 1 resistive, 2 conductive
  /// Of the triangles, S.
  Eigen::VectorXd conductivity(const TankModel& tank, double water) const;

 private:
  /// A polygon, of 32 sides for a round cylinder.
  struct Section {
    Eigen::Vector2d centre;
    double radius;
    int kind;
    std::vector<double> angles;  ///< of its corners, ascending

    bool holds(const Eigen::Vector2d& point) const;
  };
  static Section random_section(RandomStream& random);

  std::vector<Section> sections_;
};

/// Targets of one to five plastic or metal cylinders, of round and polygonal section, anywhere in
/// the calibrated tank. Their changes are those of finer finite elements, with 1 % and 1 mV per mA
/// of noise, on top of the reference's voltages. They stand for every level. Throws InputError
/// where the reference lacks channels.
std::vector<KtcTarget> simulate_ktc_targets(const KtcReference& reference,
                                            const std::filesystem::path& reference_file,
                                            const KtcCalibration& calibration, int count,
                                            std::uint64_t seed);

}  // namespace ertbench
