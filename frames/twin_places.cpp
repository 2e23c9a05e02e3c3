#include "frames/twin_places.h"

#include <algorithm>
#include <cmath>

#include "forward/border/border_model.h"

namespace ertbench {

std::vector<Eigen::Matrix2d> twin_symmetries(const Sensor& sensor) {
  constexpr double same_voltages = 1e-6;  // relative
  const Eigen::Vector2d centre = sensor.sheet->bounds().center();
  const Eigen::Matrix<double, 2, 3> own =
      sensor.sheet->inner_radius() *
      Eigen::Matrix<double, 2, 3>{{0.31, -0.55, 0.08}, {0.17, 0.24, -0.71}};
  const auto symmetries = sensor.sheet->symmetries();
  std::vector<Eigen::Vector2d> places;
  for (const Eigen::Matrix2d& symmetry : symmetries) {
    for (const auto& place : (symmetry * own).eval().colwise()) places.push_back(centre + place);
  }
  const Eigen::MatrixXd voltages = border_sensitivity(sensor, places);
  Eigen::Index identity = 0;
  while (!symmetries[static_cast<std::size_t>(identity)].isIdentity()) ++identity;
  const auto here = voltages.middleCols<3>(3 * identity);
  std::vector<Eigen::Matrix2d> out;
  for (Eigen::Index s = 0; s < std::ssize(symmetries); ++s) {
    const auto differences = (voltages.middleCols<3>(3 * s) - here).colwise().norm().array();
    const bool is_hidden = (differences <= same_voltages * here.colwise().norm().array()).all();
    if (s != identity && is_hidden) out.push_back(symmetries[static_cast<std::size_t>(s)]);
  }
  return out;
}

void add_twins(const Sensor& sensor, const std::vector<Eigen::Matrix2d>& twins,
               std::vector<FoundContact>& contacts) {
  if (twins.empty()) return;
  const Eigen::Vector2d middle = sensor.sheet->bounds().center();
  std::vector<FoundContact> all;
  for (const FoundContact& contact : contacts) {
    all.push_back(contact);
    for (const Eigen::Matrix2d& twin : twins) {
      all.push_back(contact);
      all.back().place = middle + twin * (contact.place - middle);
      all.back().place_deviation = twin.cwiseAbs() * contact.place_deviation;
    }
  }
  contacts = std::move(all);
}

std::string text_of_twins(const std::vector<Eigen::Matrix2d>& symmetries) {
  if (symmetries.empty()) return "";
  std::string out = "(x, y)";
  for (const Eigen::Matrix2d& symmetry : symmetries) {
    const auto coordinate = [&](int row) -> std::string {
      const int column = std::abs(symmetry(row, 0)) > 0.5 ? 0 : 1;
      return std::string(symmetry(row, column) < 0 ? "-" : "") + (column == 0 ? "x" : "y");
    };
    out += " and (" + coordinate(0) + ", " + coordinate(1) + ")";
  }
  return out +
         " from the sheet's centre give the same voltages: images show a contact at all of them; "
         "another pair of drive and measurement patterns tells them apart";
}

}  // namespace ertbench
