#include "forward/ellipses/ellipse_model.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "core/random.h"
#include "forward/border/border_model.h"
#include "forward/border/border_system.h"
#include "forward/ellipses/row_lu.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The standard deviation of a channel's noise at 50 dB, V; of a pair's mean less by sqrt(2).
double noise_at_50_dB(const Sensor& sensor) {
  const VectorXd reference = BorderModel(sensor).reference_voltages();
  return reference.norm() * std::pow(10, -2.5) / std::sqrt(static_cast<double>(reference.size()));
}

VectorXd means_of_pairs(const Sensor& sensor, const VectorXd& channels) {
  const auto pairs = reciprocal_pairs(sensor);
  VectorXd out(static_cast<Index>(pairs.size()));
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    out[static_cast<Index>(p)] = (channels[pairs[p][0]] + channels[pairs[p][1]]) / 2;
  }
  return out;
}

/// One to three ellipses that do not touch, ratios from 0.1 to 4.
std::vector<EllipticContact> random_contacts(const EllipseModel& model, RandomStream& random) {
  EllipseModel::Workspace workspace;
  while (true) {
    std::vector<EllipticContact> contacts(static_cast<std::size_t>(random.uniform(1, 4)));
    for (EllipticContact& contact : contacts) {
      contact.centre = {random.uniform(-0.9, 0.9), random.uniform(-0.9, 0.9)};
      contact.log_size = random.uniform(std::log(0.06), std::log(0.4));
      contact.stretch = {random.uniform(-0.35, 0.35), random.uniform(-0.35, 0.35)};
      contact.log_ratio = random.uniform(-2.3, 1.4);
    }
    if (model.place(contacts, workspace)) return contacts;
  }
}

/// The sanitizers see memory that is too small.
TEST(EllipseModel, AWorkspaceServesSensorsInTurn) {
  Sensor few;
  few.electrode_count = 8;
  const EllipseModel small(few);
  const EllipseModel large(Sensor{});
  std::vector<EllipticContact> contacts(2);
  contacts[0].centre = {-0.4, 0};
  contacts[1].centre = {0.4, 0};
  for (EllipticContact& contact : contacts) contact.log_size = -1.6;
  EllipseModel::Workspace used;
  EllipseModel::Workspace fresh;
  VectorXd change(small.pairs());
  VectorXd expected(large.pairs());
  ASSERT_TRUE(small.place(contacts, used));
  small.evaluate(used, change);
  contacts.pop_back();
  ASSERT_TRUE(large.place(contacts, used) && large.place(contacts, fresh));
  change.resize(large.pairs());
  large.evaluate(used, change);
  large.evaluate(fresh, expected);
  EXPECT_EQ(change, expected);
}

/// Against the border model, which is held against EIDORS's reference and finite elements.
TEST(EllipseModel, IsTheBorderModel) {
  const Sensor sensor;
  const BorderModel exact(sensor);
  const double noise = noise_at_50_dB(sensor);
  RandomStream random(7, key_of("ellipses"), 0, Purpose::scene);
  EllipseModel::Workspace workspace;
  const EllipseModel usual(sensor);
  const EllipseModel fine(sensor, {4, 200});
  std::vector<double> errors;
  for (int scene = 0; scene < 60; ++scene) {
    const std::vector<EllipticContact> contacts = random_contacts(usual, random);
    const VectorXd truth =
        means_of_pairs(sensor, exact.solve(scene_of(contacts), 1e-3 * noise).change);
    VectorXd change(usual.pairs());
    ASSERT_TRUE(fine.place(contacts, workspace));
    fine.evaluate(workspace, change);
    // What the points cannot do closest to the border apart, spectral accuracy.
    EXPECT_LT((change - truth).norm(), 0.01 * noise + 1e-3 * truth.norm()) << "scene " << scene;
    ASSERT_TRUE(usual.place(contacts, workspace));
    usual.evaluate(workspace, change);
    errors.push_back((change - truth).norm() / noise);
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[30], 0.05);  // of a channel's noise, over all pairs
  EXPECT_LT(errors[54], 1);
}

TEST(EllipseModel, DerivativesEqualDifferences) {
  const Sensor sensor;
  const EllipseModel model(sensor, {3, 120});
  RandomStream random(8, key_of("ellipses"), 0, Purpose::scene);
  EllipseModel::Workspace workspace;
  for (int scene = 0; scene < 12; ++scene) {
    std::vector<EllipticContact> contacts = random_contacts(model, random);
    if (scene == 0) contacts.front().stretch.setZero();  // a disc
    if (!model.place(contacts, workspace)) continue;
    const Index parameters = EllipticContact::parameters * static_cast<Index>(contacts.size());
    VectorXd change(model.pairs());
    MatrixXd derivatives(model.pairs(), parameters);
    model.evaluate(workspace, change);
    model.derivatives(workspace, derivatives);
    for (Index parameter = 0; parameter < parameters; ++parameter) {
      constexpr double h = 1e-5;
      const auto moved = [&](double step) {
        std::vector<EllipticContact> out = contacts;
        EllipticContact& contact =
            out[static_cast<std::size_t>(parameter / EllipticContact::parameters)];
        EllipticContact::Vector vector = contact.vector();
        vector[parameter % EllipticContact::parameters] += step;
        contact = EllipticContact::from(vector);
        VectorXd at(model.pairs());
        EXPECT_TRUE(model.place(out, workspace));
        model.evaluate(workspace, at);
        return at;
      };
      const VectorXd difference = (moved(h) - moved(-h)) / (2 * h);
      const double scale = std::max(difference.norm(), 0.01 * derivatives.norm());
      EXPECT_LT((derivatives.col(parameter) - difference).norm(), 1e-3 * scale)
          << "scene " << scene << ", parameter " << parameter;
    }
  }
}

TEST(RowLu, SolvesAsEigenDoes) {
  constexpr int size = 13;
  constexpr int width = 8;
  RandomStream random(9, key_of("lu"), 0, Purpose::scene);
  MatrixXd matrix(size, size);
  MatrixXd sides(size, width);
  for (Index i = 0; i < size; ++i) {
    for (Index j = 0; j < size; ++j) matrix(i, j) = 0.1 * random.normal() + (i == j ? 1 : 0);
    for (Index j = 0; j < width; ++j) sides(i, j) = random.normal();
  }
  RowLu lu;
  lu.resize(size);
  std::vector<double> rows(static_cast<std::size_t>(size) * width);
  const auto fill = [&] {
    for (int i = 0; i < size; ++i) {
      for (int j = 0; j < width; ++j) {
        rows[static_cast<std::size_t>(i * width + j)] = sides(i, j);
      }
    }
  };
  for (int i = 0; i < size; ++i) {
    for (int j = 0; j < size; ++j) lu.row(i)[j] = matrix(i, j);
  }
  lu.factor();
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> solution(rows.data(), size, width);
  fill();
  lu.solve(rows, width);
  EXPECT_LT((matrix * solution - sides).norm(), 1e-12);
  fill();
  lu.solve_transposed(rows, width);
  EXPECT_LT((matrix.transpose() * solution - sides).norm(), 1e-12);
}

TEST(Differentiation, IsExactForWhatItInterpolates) {
  constexpr int count = 12;
  const double pi = std::numbers::pi;
  VectorXd wave(count);
  VectorXd slope(count);
  for (int i = 0; i < count; ++i) {
    const double s = static_cast<double>(i) / count;
    wave[i] = std::sin(2 * pi * 3 * s);
    slope[i] = 6 * pi * std::cos(2 * pi * 3 * s);
  }
  EXPECT_LT((closed_differentiation(count) * wave - slope).norm(), 1e-11);
}

/// The map is what it says, and the count meets every probe's demand.
TEST(Gathering, DrawsPointsToWhereTheyAreDemanded) {
  std::array<double, gathering_probes> demand{};
  demand.fill(9);
  EXPECT_EQ(gathering_for(demand, 9).count, 9);
  demand[5] = 100;
  demand[4] = demand[6] = 40;
  const Gathering close = gathering_for(demand, 9);
  EXPECT_LT(close.strength, 1);
  EXPECT_LT(close.count, 60);
  const auto at = [&](double s) {
    return gathered(std::polar(1.0, (s - close.towards) / 2), close);
  };
  for (int i = 0; i < 100; ++i) {
    const double s = 2 * std::numbers::pi * i / 100;
    constexpr double h = 1e-6;
    EXPECT_NEAR(std::abs(at(s).turn), 1, 1e-12);
    const double difference = std::arg(at(s + h).turn / at(s - h).turn);
    EXPECT_NEAR(difference / (2 * h), at(s).slope, 1e-6);
  }
  EXPECT_NEAR(at(close.towards).slope, close.strength, 1e-12);
  EXPECT_NEAR(std::abs(at(close.towards).turn - 1.0), 0, 1e-12);
}

TEST(EllipseModel, KnowsWhatItIsNotFor) {
  const EllipseModel model{Sensor{}};
  EllipseModel::Workspace workspace;
  EllipticContact disc;
  disc.log_size = std::log(0.2);
  disc.log_ratio = std::log(0.5);
  EllipticContact other = disc;
  other.centre = {0.3, 0};
  EllipticContact beyond = disc;
  beyond.centre = {0.9, 0};
  EllipticContact within = disc;
  within.log_size = std::log(0.05);
  EXPECT_TRUE(model.place(std::vector{disc}, workspace));
  EXPECT_FALSE(model.place(std::vector{disc, other}, workspace));
  EXPECT_FALSE(model.place(std::vector{beyond}, workspace));
  EXPECT_FALSE(model.place(std::vector{disc, within}, workspace));
}

TEST(NearestEllipse, HasTheAreaAndTheMomentsOfAShape) {
  Contact ellipse;
  ellipse.shape = Shape::ellipse;
  ellipse.centre = {0.2, -0.1};
  ellipse.half_size = {0.3, 0.15};
  ellipse.angle = 0.4;
  ellipse.conductivity_ratio = 0.5;
  const EllipticContact itself = nearest_ellipse(ellipse);
  EXPECT_NEAR(itself.half_axes().x(), 0.3, 1e-12);
  EXPECT_NEAR(itself.half_axes().y(), 0.15, 1e-12);
  EXPECT_NEAR(itself.angle(), 0.4, 1e-12);
  EXPECT_NEAR(itself.ratio(), 0.5, 1e-12);
  // A rectangle as such and by its corners; its moments are those of half sides squared over 3.
  Contact rectangle = ellipse;
  rectangle.shape = Shape::rectangle;
  Contact polygon = rectangle;
  polygon.shape = Shape::polygon;
  const Eigen::Rotation2Dd turn(rectangle.angle);
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    polygon.vertices.push_back(rectangle.centre + turn * Eigen::Vector2d(0.3 * x, 0.15 * y));
  }
  for (const Contact& contact : {rectangle, polygon}) {
    const EllipticContact out = nearest_ellipse(contact);
    EXPECT_NEAR(out.area(), 4 * 0.3 * 0.15, 1e-12);
    EXPECT_NEAR(out.half_axes().x() / out.half_axes().y(), 2, 1e-9);
    EXPECT_NEAR(out.angle(), 0.4, 1e-9);
    EXPECT_LT((out.centre - rectangle.centre).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace ertbench
