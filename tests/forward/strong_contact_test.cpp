#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "disc_sheet.h"
#include "forward/border/border_layout.h"
#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"
#include "forward/sheet/rasterise.h"

namespace ertbench {
namespace {

using Eigen::VectorXd;
using std::numbers::pi;

Contact strong_disc(double x, double y, double radius, double ratio) {
  Contact contact;
  contact.centre = {x, y};
  contact.half_size.setConstant(radius);
  contact.conductivity_ratio = ratio;
  return contact;
}

Contact strong_rectangle(double x, double y, double a, double b, double angle, double ratio) {
  Contact contact = strong_disc(x, y, a, ratio);
  contact.shape = Shape::rectangle;
  contact.half_size = {a, b};
  contact.angle = angle;
  return contact;
}

/// What a set at 50 dB promises of a frame: a quarter of its noise.
double promised(const BorderModel& model, const VectorXd& change) {
  return 0.25 * std::pow(10, -2.5) * (model.reference_voltages() + change).norm();
}

BorderModel::Solution solved(const BorderModel& model, const Scene& scene, double share = 1) {
  return model.solve(scene,
                     [&](const VectorXd& change) { return share * promised(model, change); });
}

/// The potential at x, for conductivity 1 outside, of a unit current that enters the upper half
/// plane at x0 on its border, around 0 a half disc of radius R and conductivity f: images.
double potential_beside_a_half_disc(double x, double x0, double R, double f) {
  const double rho = (1 - f) / (1 + f);
  const auto log = [](double distance) { return std::log(std::abs(distance)); };
  double sum;
  if (std::abs(x0) > R) {
    sum = std::abs(x) > R ? log(x - x0) + rho * (log(x - R * R / x0) - log(x))
                          : 2 / (1 + f) * log(x - x0) - rho * log(x0);
  } else if (std::abs(x) > R) {
    sum = 2 / (1 + f) * log(x - x0) - rho * log(x);
  } else {
    // x0 ln|x - R^2 / x0| by its limit where x0 is the centre.
    sum = (log(x - x0) - rho * log((x0 * x - R * R) / R)) / f - rho * log(R);
  }
  return -sum / pi;
}

TEST(StrongContacts, OnElectrodesOfADiscEqualTheirImages) {
  // A disc that meets the sheet's border, a circle, at right angles is a half disc in the half
  // plane, to which the sheet goes by w -> tan(half the angle from the contact's middle).
  const BorderModel model(testing::disc_sensor());
  const Sensor& sensor = model.sensor();
  const int count = sensor.electrode_count;
  const std::vector<Channel> channels = channels_of(sensor);
  const Eigen::Matrix2Xd places = electrode_positions(sensor, VectorXd::Zero(count));
  const double first = std::atan2(places(1, 0), places(0, 0));
  const double step = 2 * pi / count;
  // On one electrode; beside its middle; on two; next to the crossings; between the electrodes.
  const std::vector<std::pair<double, double>> contacts = {
      {0, 0.3}, {0.05, 0.3}, {step / 2, 0.35}, {0, step + 1e-3}, {0, step - 1e-3}, {step / 2, 0.1}};
  for (const auto& [turn, opening] : contacts) {
    for (const double f : {1e-6, 1e-3, 0.02, 0.5, 30.0, 1e3, 1e6}) {
      const double middle = first + turn;
      const Scene scene{{strong_disc(std::cos(middle) / std::cos(opening),
                                     std::sin(middle) / std::cos(opening), std::tan(opening), f)}};
      VectorXd x(count);
      for (int e = 0; e < count; ++e)
        x[e] = std::tan((std::atan2(places(1, e), places(0, e)) - middle) / 2);
      const auto potential = [&](int m, int e) {
        return potential_beside_a_half_disc(x[m], x[e], std::tan(opening / 2), f);
      };
      VectorXd exact(sensor.channels());
      for (std::size_t c = 0; c < channels.size(); ++c) {
        const int d = channels[c].drive;
        const int m = channels[c].measurement;
        const int d1 = (d + 1) % count;
        const int m1 = (m + 1) % count;
        exact[static_cast<Eigen::Index>(c)] =
            -sensor.drive_current / sensor.background *
            (potential(m1, d1) - potential(m1, d) - potential(m, d1) + potential(m, d));
      }
      const BorderModel::Solution solution = solved(model, scene);
      const VectorXd voltages = model.reference_voltages() + solution.change;
      const std::string where = "turn " + std::to_string(turn) + ", opening " +
                                std::to_string(opening) + ", ratio " + std::to_string(f);
      EXPECT_LE((voltages - exact).norm(), promised(model, solution.change)) << where;
      EXPECT_LE(solution.error, promised(model, solution.change)) << where;
      EXPECT_LT(solution.points, 150) << where;
    }
  }
}

/// Strong contacts of every kind at one ratio.
std::vector<std::pair<const char*, Scene>> strong_scenes(double f) {
  return {
      {"on an electrode and the corner", {{strong_disc(0.75, 1, 0.3, f)}}},
      {"on two electrodes", {{strong_disc(0.5, 1, 0.4, f)}}},
      {"on one electrode each", {{strong_disc(0.25, 1, 0.2, f), strong_disc(1, -0.25, 0.25, f)}}},
      {"overlapping on electrodes",
       {{strong_disc(0.25, 1, 0.2, f), strong_disc(0.45, 0.9, 0.25, f / 10)}}},
      {"flush with the border", {{strong_rectangle(0.8, 0.25, 0.2, 0.2, 0, f)}}},
      {"a rectangle inside", {{strong_rectangle(0.2, 0.3, 0.3, 0.2, 0.4, f)}}},
      {"a stronger one in it",
       {{strong_disc(0.25, 1, 0.4, f), strong_disc(0.25, 0.8, 0.1, f / 10)}}},
      {"across the sheet", {{strong_rectangle(0.25, 0, 0.15, 1.5, 0.1, f)}}}};
}

TEST(StrongContacts, KeepThePromise) {
  const BorderModel model{Sensor{}};
  for (const double f : {1e-6, 1e-3, 0.02, 50.0, 1e3, 1e6}) {
    for (const auto& [name, scene] : strong_scenes(f)) {
      const BorderModel::Solution solution = solved(model, scene);
      const double promise = promised(model, solution.change);
      EXPECT_LE(solution.error, promise) << name << ", ratio " << f;
      const BorderModel::Solution finer = solved(model, scene, 0.1);
      EXPECT_LE((solution.change - finer.change).norm(), promise) << name << ", ratio " << f;
    }
  }
}

TEST(StrongContacts, TendToALimit) {
  // An insulator with a millionth of the background's conductivity lets a thousandth of the current
  // pass that one with a thousandth does: voltages outside differ by about the ratio itself.
  const BorderModel model{Sensor{}};
  for (const bool insulating : {true, false}) {
    const auto change = [&](double f) {
      const Scene scene{{strong_disc(0.75, 1, 0.3, insulating ? f : 1 / f)}};
      return VectorXd(model.solve_at(scene, 6).change);
    };
    const VectorXd limit = change(1e-9);
    const double at_1e3 = (change(1e-3) - limit).norm();
    EXPECT_LT(at_1e3, 0.02 * limit.norm());
    EXPECT_NEAR((change(1e-6) - limit).norm(), 1e-3 * at_1e3, 1e-4 * at_1e3);
  }
}

TEST(StrongContacts, GridsConvergeToThem) {
  const BorderModel model{Sensor{}};
  // First order in h once the grid resolves the thin wedge of sheet beside the contact.
  const ForwardModel coarse(Sensor{}, 96);
  const ForwardModel fine(Sensor{}, 384);
  for (const Scene& scene :
       {Scene{{strong_disc(0.75, 1, 0.3, 0.01)}},
        Scene{{strong_disc(0.25, 1, 0.2, 0.01), strong_disc(1, -0.25, 0.25, 0.02)}}}) {
    const VectorXd exact = solved(model, scene).change;
    const auto distance = [&](const ForwardModel& grid) {
      VectorXd ratio(grid.grid() * grid.grid());
      rasterise(scene, square_sheet()->pixels(grid.grid()), Rasterisation::area, ratio);
      Images sheet(1, ratio.size());
      sheet.row(0) = grid.sensor().background * ratio.transpose();
      return (grid.solve(sheet).row(0).transpose() - grid.reference_voltages() - exact).norm();
    };
    EXPECT_LT(distance(fine), 0.6 * distance(coarse));
    EXPECT_LT(distance(fine), 0.1 * exact.norm());
  }
}

TEST(StrongContacts, CornersHaveTheExponentsOfTheirWedges) {
  EXPECT_EQ(corner_exponent(1e-3, 1, pi / 2),
            1);  // at right angles the mirror image is a smooth border
  EXPECT_EQ(corner_exponent(0.3, 0.3, 1), 1);
  // Almost an insulator inside 3/4 of the angle: quarter waves, pi / 2 over the angle.
  EXPECT_NEAR(corner_exponent(1e-9, 1, 0.75 * pi), 2.0 / 3, 2e-3);
  // The condition itself: the currents' potentials and their flow match where the wedges meet.
  const double lambda = corner_exponent(0.2, 1, 2.5);
  EXPECT_NEAR(0.2 * std::tan(lambda * 2.5) + std::tan(lambda * (pi - 2.5)), 0, 0.02);
}

}  // namespace
}  // namespace ertbench
