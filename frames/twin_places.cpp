#include "frames/twin_places.h"

#include <algorithm>
#include <cmath>

#include "forward/border/border_model.h"

namespace ertbench {

std::vector<Eigen::Matrix2d> twin_symmetries(const Sensor& sensor) {
  constexpr double same_voltages = 1e-6;  // relative
  const Eigen::Vector2d centre = sensor.sheet->bounds().center();
  std::vector<Eigen::Matrix2d> out;
  for (const Eigen::Matrix2d& symmetry : sensor.sheet->symmetries()) {
    if (symmetry.isIdentity()) continue;
    const auto is_hidden = [&](const Eigen::Vector2d& direction) {
      const Eigen::Vector2d place = sensor.sheet->inner_radius() * direction;
      const Eigen::VectorXd here = border_sensitivity(sensor, centre + place);
      const Eigen::VectorXd there = border_sensitivity(sensor, centre + symmetry * place);
      return (here - there).norm() <= same_voltages * here.norm();
    };
    const Eigen::Vector2d places[] = {{0.31, 0.17}, {-0.55, 0.24}, {0.08, -0.71}};
    if (std::all_of(std::begin(places), std::end(places), is_hidden)) out.push_back(symmetry);
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
