#pragma once

#include <cstdint>
#include <vector>

#include "bench/ktc2023/ktc_files.h"
#include "core/random.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Plastic or metal cylinders of round and polygonal section anywhere in the tank.
class SimulatedCylinders {
 public:
  /// `largest`: radius, m, of the circle around a section.
  SimulatedCylinders(RandomStream& random, std::size_t count, double largest = usual);

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
  static constexpr double usual = 0.028;
  static Section random_section(RandomStream& random, double largest);

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

/// Voltages [channels] of ideal amplifiers by the resistances between electrodes, [32, 32].
Eigen::RowVectorXd ideal_voltages(const std::vector<ChannelElectrodes>& channels,
                                  const Eigen::MatrixXd& resistance);

/// Tanks of one to five such cylinders as frames of networks, in a file as MeasuredFrames reads it.
struct TrainingTanks {
  Sensor sensor;  ///< a disc of unit conductivity with the tank's electrodes
  int count = 0;
  std::uint64_t seed = 0;

  /// The file in `folder`; written where it is missing, the tanks by `threads` threads. Every
  /// electrode of a tank has a contact impedance of its own, every channel an error of 3 % of
  /// its change and .3 % of the reference's size. Conductivities are classes: .01 resistive, 1/2
  /// water, 1 conductive.
  std::filesystem::path file_in(const std::filesystem::path& folder, int threads) const;

 private:
  struct Example {
    Eigen::RowVectorXd change;   ///< [channels] V
    Eigen::RowVectorXd classes;  ///< [pixels]
  };
  Example example(const TankModel& tank, const Eigen::RowVectorXd& reference,
                  std::uint64_t number) const;
};

}  // namespace ertbench
