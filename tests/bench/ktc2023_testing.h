#pragma once

// A small competition of simulated files, of the structure of KTC2023's.

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/ktc2023/ktc_experiment.h"

namespace ertbench {

namespace fs = std::filesystem;

inline const TankModel& tank() {
  static const TankModel model;
  return model;
}

/// Appends a matrix of doubles as an element of a MATLAB file of version 5.
inline void append_variable(std::string& file, const std::string& name,
                            const Eigen::MatrixXd& values) {
  const auto word = [](std::uint32_t number) {
    return std::string(reinterpret_cast<const char*>(&number), sizeof number);
  };
  const auto padded = [](std::string text) {
    text.resize((text.size() + 7) / 8 * 8);
    return text;
  };
  const auto element = [&](std::uint32_t type, const std::string& data) {
    return padded(word(type) + word(static_cast<std::uint32_t>(data.size())) + data);
  };
  const std::string numbers(reinterpret_cast<const char*>(values.data()),
                            static_cast<std::size_t>(values.size()) * sizeof(double));
  const std::string matrix = element(6, word(6) + word(0)) +
                             element(5, word(static_cast<std::uint32_t>(values.rows())) +
                                            word(static_cast<std::uint32_t>(values.cols()))) +
                             element(1, name) + element(9, numbers);
  file += element(14, matrix);
}

inline void write_mat(const fs::path& path,
                      const std::map<std::string, Eigen::MatrixXd>& variables) {
  std::string file = "MATLAB 5.0 MAT-file";
  file.resize(124, ' ');
  file += std::string("\x00\x01IM", 4);
  for (const auto& [name, values] : variables) append_variable(file, name, values);
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << file;
}

/// A resistive and a conductive disc in a tank whose amplifiers have a common mode.
class SmallCompetition {
 public:
  SmallCompetition() {
    patterns.currents.setZero(32, 48);
    for (int d = 0; d < 48; ++d) {
      const int source = 2 * (d % 16);
      const int sink = (source + (d < 16 ? 2 : d < 32 ? 8 : 16)) % 32;
      patterns.currents(source, d) = 1.4 + 0.003 * d;
      patterns.currents(sink, d) = -patterns.currents(source, d);
    }
    patterns.measurements.setZero(32, 31);
    for (int m = 0; m < 31; ++m) {
      patterns.measurements(m, m) = 1;
      patterns.measurements(m + 1, m) = -1;
    }
    common_mode = Eigen::VectorXd::LinSpaced(31, -0.04, 0.04);
    impedance = Eigen::VectorXd::LinSpaced(32, 5e-6, 4e-5);
  }

  static int kind_at(const Eigen::Vector2d& at) {
    if ((at - Eigen::Vector2d(0.04, 0.03)).norm() < 0.03) return 2;
    return (at - Eigen::Vector2d(-0.04, -0.02)).norm() < 0.03 ? 1 : 0;
  }

  Eigen::VectorXd voltages(bool with_target, int level = 1) const {
    Eigen::VectorXd conductivity = Eigen::VectorXd::Constant(std::ssize(tank().triangles()), 0.8);
    for (std::size_t t = 0; with_target && t < tank().triangles().size(); ++t) {
      const int kind = kind_at(tank().nodes()(Eigen::all, tank().triangles()[t]).rowwise().mean());
      conductivity[static_cast<Eigen::Index>(t)] *= kind == 0 ? 1 : kind == 1 ? 0.05 : 20;
    }
    Eigen::VectorXd out = channel_operator(patterns, Eigen::VectorXd::Zero(31), common_mode) *
                          TankModel::packed(tank().solve(conductivity, impedance).resistance);
    for (Eigen::Index c = 0; c < out.size(); ++c) {
      out[c] = patterns.uses_first(c, 2 * (level - 1)) ? NAN : out[c] * patterns.amplitude(c);
    }
    return out;
  }

  static Eigen::MatrixXd truth() {
    Eigen::MatrixXd out(256, 256);
    for (int row = 0; row < 256; ++row) {
      for (int column = 0; column < 256; ++column) {
        out(row, column) = kind_at({(column - 127.5) / 128 * 0.115, (127.5 - row) / 128 * 0.115});
      }
    }
    return out;
  }

  void write_reference(const fs::path& folder) const {
    write_mat(folder / "ref.mat", {{"Injref", patterns.currents},
                                   {"Mpat", patterns.measurements},
                                   {"Uelref", voltages(false)}});
  }
  /// Reference, one target and its truth, all channels of both times `gain` of their number.
  template <typename Gain>
  void write_training(const fs::path& folder, const Gain& gain) const {
    const auto amplified = [&](Eigen::VectorXd out) -> Eigen::MatrixXd {
      for (Eigen::Index c = 0; c < out.size(); ++c) out[c] *= gain(c);
      return out;
    };
    write_mat(folder / "ref.mat", {{"Injref", patterns.currents},
                                   {"Mpat", patterns.measurements},
                                   {"Uelref", amplified(voltages(false))}});
    write_mat(folder / "data1.mat", {{"Inj", patterns.currents},
                                     {"Mpat", patterns.measurements},
                                     {"Uel", amplified(voltages(true))}});
    write_mat(folder / "true1.mat", {{"truth", truth()}});
  }
  void write_data(const fs::path& file, int level) const {
    write_mat(file, {{"Inj", patterns.currents},
                     {"Mpat", patterns.measurements},
                     {"Uel", voltages(true, level)}});
  }

  KtcPatterns patterns;
  Eigen::VectorXd common_mode;
  Eigen::VectorXd impedance;
};

inline KtcResults results_in(const fs::path& folder, const nlohmann::json& methods,
                             int simulated = 0) {
  nlohmann::json content = {{"title", "t"}, {"data", folder.string()}, {"methods", methods}};
  if (simulated > 0) content["simulated"] = {{"count", simulated}, {"seed", 1}};
  content["levels"] = {1, 5};
  content["official"] = {{"winner", {15.24}}};
  ExperimentJson json;
  json.content = content;
  json.source = "ktc.json";
  return ktc_results(json);
}

}  // namespace ertbench
